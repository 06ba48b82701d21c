//! A matrix in panels, and its product with a vector. A panel is a block of rows that fills a few registers. Their
//! number is chosen so that the sums of all rows of a panel fit into the processor's registers.

use autodiff::Real;
use autodiff::internal::{Factors, IS_SIMD128, Strided, fits_registers, lanes};
use autodiff::simd::Lane;

use super::aligned::Aligned;
use super::epilogue::Epilogue;

/// The largest number of registers that the rows of a panel fill. With this number, all their sums fit into the
/// processor's registers.
const PANEL: usize = 4;
/// The number of partial sums ("phases") per row. Phase `p` sums the columns `p`, `p + 4`, `p + 8`, …, so that
/// consecutive additions do not wait for each other.
pub(super) const PHASES: usize = 4;

/// A matrix in panels of up to [`PANEL`] registers of rows. Each panel is stored column by column.
pub(super) struct Panels<R> {
    entries: Aligned<R>,
    rows: usize,
    columns: usize,
}

/// One panel of the matrix: up to [`PANEL`] registers of rows.
struct Panel<'a, R> {
    first_row: usize,
    /// The entries, column by column.
    entries: &'a [R],
}

impl<R: Real> Panels<R> {
    /// Returns a matrix of zeros.
    pub(super) fn zero(rows: usize, columns: usize) -> Self {
        Self {
            entries: Aligned::zeros(rows.next_multiple_of(lanes::<R>()) * columns),
            rows,
            columns,
        }
    }

    /// For the panel whose first row is in register number `first`, returns the number of its registers and the
    /// position of its entries.
    #[inline(always)]
    fn place(&self, first: usize, width: usize) -> (usize, usize) {
        let registers = self.rows.div_ceil(width) - first;
        (registers.min(PANEL), first * width * self.columns)
    }

    /// Calls `f(row, column, entries)` for parts of columns that together cover the matrix. `entries` are the entries
    /// of `column` from `row` downwards.
    pub(super) fn each(&mut self, mut f: impl FnMut(usize, usize, &mut [R])) {
        let width = lanes::<R>();
        for first in (0..self.rows.div_ceil(width)).step_by(PANEL) {
            let (registers, start) = self.place(first, width);
            let rows = (self.rows - first * width).min(width * registers);
            let entries = self.entries[start..].chunks_exact_mut(registers * width);
            for (column, entries) in entries.take(self.columns).enumerate() {
                f(first * width, column, &mut entries[..rows]);
            }
        }
    }

    /// Passes `A x` to the output, for one or two (`K`) interleaved vectors. Each phase is summed separately, then the
    /// sums of the four phases are added. So the order of summation does not depend on the register width.
    #[inline(always)]
    pub(super) fn times<L: Lane<R>, const K: usize>(&self, x: &[R], output: &mut Epilogue<R>) {
        let x = &x[..self.columns * K];
        for first in (0..self.rows.div_ceil(L::N)).step_by(PANEL) {
            let (lanes, start) = self.place(first, L::N);
            let panel = Panel {
                first_row: first * L::N,
                entries: &self.entries[start..][..lanes * L::N * self.columns],
            };
            // The condition is constant, so only one branch is compiled. For large numbers, such as duals, unrolled
            // loops would be slow to compile and save nothing.
            if const { !fits_registers::<R, L>() } {
                for from in 0..lanes {
                    panel.part::<L, 1, K>(from, lanes, x, output);
                }
                continue;
            }
            match (lanes, K) {
                (1, _) => panel.part::<L, 1, K>(0, 1, x, output),
                (2, _) => panel.part::<L, 2, K>(0, 2, x, output),
                (3, 1) => panel.part::<L, 3, K>(0, 3, x, output),
                (_, 1) if IS_SIMD128 => {
                    // WebAssembly engines have only sixteen registers. The factors and products need some of them, so
                    // the panel is summed in two halves.
                    let low = panel.sums::<L, 2, K>(0, PANEL, x);
                    let high = panel.sums::<L, 2, K>(2, PANEL, x);
                    output.add_rows(panel.first_row, [low[0], low[1], high[0], high[1]]);
                }
                (_, 1) => panel.part::<L, PANEL, K>(0, PANEL, x, output),
                // With two vectors, the registers hold the sums of half as many rows.
                (3, _) => {
                    panel.part::<L, 2, K>(0, 3, x, output);
                    panel.part::<L, 1, K>(2, 3, x, output);
                }
                (_, _) => {
                    panel.part::<L, 2, K>(0, PANEL, x, output);
                    panel.part::<L, 2, K>(2, PANEL, x, output);
                }
            }
        }
    }
}

impl<R: Real> Panel<'_, R> {
    /// Computes the product for `H` registers of rows, beginning with register `from` of the `lanes` registers in the
    /// panel.
    #[inline(always)]
    fn part<L: Lane<R>, const H: usize, const K: usize>(
        &self,
        from: usize,
        lanes: usize,
        x: &[R],
        output: &mut Epilogue<R>,
    ) {
        let all = self.sums::<L, H, K>(from, lanes, x);
        output.add_rows(self.first_row + from * L::N, all);
    }

    #[inline(always)]
    fn sums<L: Lane<R>, const H: usize, const K: usize>(
        &self,
        from: usize,
        lanes: usize,
        x: &[R],
    ) -> [[L; K]; H] {
        let factors = Factors {
            a: Strided::by_rows(x, K).transposed(),
            b: &self.entries[(from * L::N).min(self.entries.len())..],
            b_row: lanes * L::N,
            depth: x.len() / K,
        };
        // SAFETY: `from + H` is at most `lanes`, and each column of the panel has `lanes` registers.
        #[allow(unsafe_code)]
        let sums = unsafe { factors.sums::<L, PHASES, K, H>(L::N) };
        let mut all = [[L::zero(); K]; H];
        for h in 0..H {
            for k in 0..K {
                all[h][k] = (sums[0][k][h] + sums[1][k][h]) + (sums[2][k][h] + sums[3][k][h]);
            }
        }
        all
    }
}
