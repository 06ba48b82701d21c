//! A matrix in tiles of rows, and its product with interleaved vectors, one per lane.
//!
//! Each lane is a start, so a weight is read once for all starts. With the panels of single starts in place of tiles,
//! the gradient of a net of 36 nodes that a network drives takes 1.04 times as long.

use autodiff::Real;
use autodiff::internal::{Factors, IS_SIMD128, Strided};
use autodiff::simd::Lane;

use super::aligned::Aligned;
use super::epilogue::Epilogue;
use super::panels::PHASES;

/// The number of rows that are summed at once in registers. WebAssembly engines have only sixteen registers, and the
/// factors and products need some of them.
const TILE: usize = if IS_SIMD128 { 8 } else { 16 };
/// The number of rows whose bias and activation are applied at once. More rows would need too many registers.
const ABREAST: usize = 4;

/// A matrix in tiles of [`TILE`] rows. Within a tile, the columns are ordered by [phase](PHASES): the index of the
/// partial sum to which a column belongs.
pub(super) struct Tiles<R> {
    entries: Aligned<R>,
    rows: usize,
    columns: usize,
}

impl<R: Real> Tiles<R> {
    pub(super) fn zero(rows: usize, columns: usize) -> Self {
        Self {
            entries: Aligned::zeros(rows.next_multiple_of(TILE) * columns),
            rows,
            columns,
        }
    }

    /// Calls a function for the entries of each column; see [`Panels::each`](super::panels::Panels::each).
    pub(super) fn each(&mut self, mut f: impl FnMut(usize, usize, &mut [R])) {
        let tiles = self.entries.chunks_exact_mut(TILE * self.columns.max(1));
        for (first, tile) in (0..self.rows).step_by(TILE).zip(tiles) {
            let order = (0..PHASES).flat_map(|phase| (phase..self.columns).step_by(PHASES));
            for (column, part) in order.zip(tile.chunks_exact_mut(TILE)) {
                f(first, column, &mut part[..TILE.min(self.rows - first)]);
            }
        }
    }

    /// Passes `A x` to the output. The terms of a sum are added in the same order as in
    /// [`Panels`](super::panels::Panels::times), so each start gives the same bits as when it runs alone.
    #[inline(always)]
    pub(super) fn times<L: Lane<R>>(&self, x: &[R], output: &mut Epilogue<R>) {
        assert!(
            x.len() >= self.columns * L::N,
            "`x` is too short: it must have one number per column and lane"
        );
        for first in (0..self.rows).step_by(TILE) {
            // The sums of the four phases are added in the order (0 + 1) + (2 + 3), as in `Panels`.
            let phase = |phase| self.phase::<L>(x, first, phase);
            let (mut sums, more) = (phase(0), phase(1));
            for row in 0..TILE {
                sums[row] += more[row];
            }
            let (third, last) = (phase(2), phase(3));
            for row in 0..TILE {
                sums[row] += third[row] + last[row];
            }
            let (groups, _) = sums.as_chunks::<ABREAST>();
            for (k, sums) in groups.iter().enumerate() {
                output.add_starts(first + k * ABREAST, *sums);
            }
        }
    }

    /// Returns the sums of one phase over a tile. Computing one phase at a time leaves registers for more rows, so each
    /// load of `x` serves more multiplications.
    #[inline(always)]
    fn phase<L: Lane<R>>(&self, x: &[R], first: usize, phase: usize) -> [L; TILE] {
        let columns = self.columns;
        let before = (0..phase).map(|p| columns.saturating_sub(p).div_ceil(PHASES));
        let place = first * columns + before.sum::<usize>() * TILE;
        let count = columns.saturating_sub(phase).div_ceil(PHASES);
        let factors = Factors {
            a: Strided::by_rows(&self.entries[place..][..count * TILE], TILE).transposed(),
            b: &x[(phase * L::N).min(x.len())..],
            b_row: PHASES * L::N,
            depth: count,
        };
        // SAFETY: the slice of the tile was bounds-checked, and `times` checked that `x` has a register for every
        // column.
        #[allow(unsafe_code)]
        let [sums] = unsafe { factors.sums::<L, 1, TILE, 1>(L::N) };
        sums.map(|[sum]| sum)
    }
}
