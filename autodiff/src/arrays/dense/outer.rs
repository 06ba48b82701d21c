//! Sums of outer products: the cotangents of a layer's weights.
//!
//! They are collected over several steps and added as one matrix product, which touches the memory of
//! the gradient once in [`BATCH`] steps.

use super::aligned::Aligned;
use super::panels::{PANEL, Panels, lane_of_column};
use crate::product::Transpose;
use crate::real::Real;
use crate::simd::{Lane, Vectorized, lanes};

/// Outer products that are added together, one per step and start.
const BATCH: usize = 16;

/// Inputs and output cotangents of the last steps, one start after the other.
pub(super) struct Pending<R> {
    x: Vec<R>,
    /// Padded to whole registers. With one start, the current step's cotangents lie behind the last ones.
    y_bar: Aligned<R>,
    /// With several starts, the interleaved cotangents of the current step.
    interleaved: Aligned<R>,
    starts: usize,
    rows: usize,
    /// The distance from one start's cotangents to the next's.
    stride: usize,
    /// How many outer products are kept.
    len: usize,
}

impl<R: Real> Pending<R> {
    pub(super) fn new(starts: usize, rows: usize, columns: usize) -> Self {
        let numbers = if starts == 1 { 0 } else { rows * starts };
        let stride = rows.next_multiple_of(lanes::<R>());
        Self {
            x: vec![R::zero(); BATCH * columns],
            // Both with room for a register past the last.
            y_bar: Aligned::zeros(BATCH * stride + lanes::<R>()),
            interleaved: Aligned::zeros(numbers + lanes::<R>()),
            starts,
            rows,
            stride,
            len: 0,
        }
    }

    /// The cotangents of the current step.
    pub(super) fn current(&self) -> &[R] {
        match self.starts {
            1 => &self.y_bar[self.len * self.stride..][..self.rows],
            starts => &self.interleaved[..self.rows * starts],
        }
    }

    /// The place for these, with room for a register past the last.
    pub(super) fn current_mut(&mut self) -> &mut [R] {
        match self.starts {
            1 => &mut self.y_bar[self.len * self.stride..],
            _ => &mut self.interleaved,
        }
    }

    /// Keeps the current step, whose inputs are `x`; returns whether the batch is full.
    pub(super) fn keep(&mut self, x: &[R]) -> bool {
        let (starts, stride) = (self.starts, self.stride);
        let columns = x.len() / starts;
        if starts == 1 {
            self.x[self.len * columns..][..columns].copy_from_slice(x);
        } else {
            let to = &mut self.x[self.len * columns..][..columns * starts];
            R::vectorize(Transpose {
                from: x,
                from_row: starts,
                rows: columns,
                columns: starts,
                to,
                to_row: columns,
            });
            let to = &mut self.y_bar[self.len * stride..][..stride * starts];
            R::vectorize(Transpose {
                from: &self.interleaved,
                from_row: starts,
                rows: self.rows,
                columns: starts,
                to,
                to_row: stride,
            });
        }
        self.len += starts;
        self.len == BATCH
    }

    pub(super) fn clear(&mut self) {
        self.len = 0;
    }
}

/// `W_bar += sum over the batch of y_bar x^T`.
pub(super) struct OuterProducts<'a, R> {
    pub(super) batch: &'a Pending<R>,
    pub(super) to: &'a mut Panels<R>,
}

impl<R: Real> Vectorized<R> for OuterProducts<'_, R> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        let (columns, stride) = (self.to.columns, self.to.rows.next_multiple_of(L::N));
        for k in 0..self.to.panels.len() {
            let panel = self.to.panels[k];
            let part = PendingRows {
                batch: self.batch,
                columns,
                stride,
                first: panel.first_row,
            };
            let entries = self.to.panel_mut::<L>(panel);
            // `W` by `C` sums and the loads beside them fill the registers: AVX-512 has 32, AVX2 16.
            match (panel.lanes, const { size_of::<L>() == 64 }) {
                (1, _) => part.add::<L, 1, 8>(entries),
                (2, false) => part.add::<L, 2, 4>(entries),
                (2, true) => part.add::<L, 2, 8>(entries),
                (3, false) => part.add::<L, 3, 2>(entries),
                (3, true) => part.add::<L, 3, 4>(entries),
                (_, false) => part.add::<L, PANEL, 2>(entries),
                (_, true) => part.add::<L, PANEL, 4>(entries),
            }
        }
    }
}

/// A batch as one panel sees it.
struct PendingRows<'a, R> {
    batch: &'a Pending<R>,
    columns: usize,
    /// The distance from one start's cotangents to the next's.
    stride: usize,
    /// The panel's first row.
    first: usize,
}

impl<R: Real> PendingRows<'_, R> {
    /// Adds to a panel of `W` registers of rows, `C` columns at once: every load of a cotangent serves all
    /// of them, and their sums do not wait for one another.
    #[inline(always)]
    fn add<L: Lane<R>, const W: usize, const C: usize>(&self, panel: &mut [R]) {
        let whole = self.columns / C * C;
        for column in (0..whole).step_by(C) {
            self.add_columns::<L, W, C>(panel, column);
        }
        for column in whole..self.columns {
            self.add_columns::<L, W, 1>(panel, column);
        }
    }

    /// The `C` columns from `column` on, which are of one chunk.
    #[inline(always)]
    fn add_columns<L: Lane<R>, const W: usize, const C: usize>(
        &self,
        panel: &mut [R],
        column: usize,
    ) {
        let Pending { x, y_bar, len, .. } = self.batch;
        let mut sums = [[L::zero(); W]; C];
        for s in 0..*len {
            let x = &x[s * self.columns + column..][..C];
            let y_bar = &y_bar[s * self.stride + self.first..][..W * L::N];
            for w in 0..W {
                let y_bar = L::load(&y_bar[w * L::N..]);
                for c in 0..C {
                    sums[c][w] = y_bar.fma(L::splat(x[c]), sums[c][w]);
                }
            }
        }
        let to = &mut panel[lane_of_column(column, W) * L::N..][..C * W * L::N];
        for c in 0..C {
            for w in 0..W {
                let to = &mut to[(c * W + w) * L::N..];
                (L::load(to) + sums[c][w]).store(to);
            }
        }
    }
}
