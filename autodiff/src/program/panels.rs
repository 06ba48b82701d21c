//! Matrices in panels that fit the registers: products with vectors, and sums of outer products.
//!
//! The gradient of a layer's weights is gathered over several steps and added as one matrix
//! product: it then touches the gradient's memory once in [`BATCH`] steps.

use super::{Aligned, lanes};
use crate::lanes::{Lane, Vectorized};
use crate::real::Real;

/// Steps whose outer products are added together.
pub(super) const BATCH: usize = 16;
/// The most lanes of rows that are worked on at once: their sums stay in registers.
const PANEL: usize = 4;
/// Columns that are summed up apart, so that no sum waits for the one before.
const PHASES: usize = 4;

/// A matrix in panels of some lanes of rows; within a panel column after column.
///
/// Two matrices of a controller do not fit the first cache together. So they are read in panels
/// forth and back in turns: what the last product read at its end is what the next one reads
/// first. That a sixth of a rollout's time is saved says `cosmic explain --measure`.
pub(super) struct Panels<R> {
    pub(super) entries: Aligned<R>,
    rows: usize,
    columns: usize,
    /// Lanes of rows in a panel; the last one may have fewer.
    tall: usize,
    /// Whether the next product begins at the end.
    pub(super) back: bool,
}

impl<R: Real> Panels<R> {
    pub(super) fn zero(rows: usize, columns: usize) -> Self {
        let lanes_of_rows = rows.div_ceil(lanes::<R>());
        Self {
            entries: Aligned::zeros(lanes_of_rows * lanes::<R>() * columns),
            rows,
            columns,
            // Two panels at least, or there is nothing to turn round.
            tall: lanes_of_rows.div_ceil(2).min(PANEL),
            back: false,
        }
    }

    /// Calls `f(row, column, entry)` for every entry.
    pub(super) fn each(&mut self, mut f: impl FnMut(usize, usize, &mut R)) {
        let lanes = lanes::<R>();
        let (height, lanes) = (self.rows.next_multiple_of(lanes), self.tall * lanes);
        for first in (0..height).step_by(lanes) {
            let tall = lanes.min(height - first);
            let panel = &mut self.entries[first * self.columns..][..tall * self.columns];
            for (column, part) in panel.chunks_exact_mut(tall).enumerate() {
                for (row, entry) in part.iter_mut().enumerate() {
                    if first + row < self.rows {
                        f(first + row, column, entry);
                    }
                }
            }
        }
    }
}

pub(super) struct Batch<R> {
    pub(super) x: Vec<R>,
    /// In whole lanes. The last is that of the step that is under way.
    pub(super) y_bar: Aligned<R>,
    pub(super) len: usize,
}

/// `y = start + A x`, or `y += A x` without a start; then `tanh` of it where asked. Every entry
/// of `y` is summed in the same order at every lane width: every fourth column, then those sums.
pub(super) struct Product<'a, R> {
    pub(super) matrix: &'a Panels<R>,
    pub(super) x: &'a [R],
    pub(super) start: Option<&'a [R]>,
    pub(super) y: &'a mut [R],
    pub(super) tanh: bool,
}

impl<R: Real> Vectorized<R> for Product<'_, R> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(mut self) {
        let height = self.matrix.rows.div_ceil(L::N);
        let tall = self.matrix.tall;
        let panels = height.div_ceil(tall);
        for panel in 0..panels {
            let first = tall
                * if self.matrix.back {
                    panels - 1 - panel
                } else {
                    panel
                };
            match tall.min(height - first) {
                1 => self.panel::<L, 1>(first * L::N),
                2 => self.panel::<L, 2>(first * L::N),
                3 => self.panel::<L, 3>(first * L::N),
                _ => self.panel::<L, PANEL>(first * L::N),
            }
        }
    }
}

impl<R: Real> Product<'_, R> {
    /// `W` lanes of rows.
    #[inline(always)]
    fn panel<L: Lane<R>, const W: usize>(&mut self, first: usize) {
        let columns = self.matrix.columns;
        let x = &self.x[..columns];
        let mut sums = [[L::zero(); W]; PHASES];
        let panel = &self.matrix.entries[first * columns..][..columns * W * L::N];
        let whole = columns / PHASES * PHASES;
        let (body, rest) = panel.split_at(whole * W * L::N);
        let columns = body.chunks_exact(PHASES * W * L::N);
        for (weights, x) in columns.zip(x.chunks_exact(PHASES)) {
            for phase in 0..PHASES {
                let x = L::splat(x[phase]);
                for w in 0..W {
                    let weights = L::load(&weights[(phase * W + w) * L::N..]);
                    sums[phase][w] = weights.fma(x, sums[phase][w]);
                }
            }
        }
        let columns = rest.chunks_exact(W * L::N);
        for ((weights, &x), sums) in columns.zip(&x[whole..]).zip(&mut sums) {
            for w in 0..W {
                sums[w] = L::load(&weights[w * L::N..]).fma(L::splat(x), sums[w]);
            }
        }
        for w in 0..W {
            let row = first + w * L::N;
            let start = match self.start {
                Some(start) => L::load_up_to(&start[row..]),
                None => L::load_up_to(&self.y[row..]),
            };
            let sum = start + ((sums[0][w] + sums[1][w]) + (sums[2][w] + sums[3][w]));
            (if self.tanh { sum.tanh() } else { sum }).store_up_to(&mut self.y[row..]);
        }
    }
}

/// `W_bar += sum over the batch of y_bar x^T`.
pub(super) struct OuterProducts<'a, R> {
    pub(super) batch: &'a Batch<R>,
    pub(super) to: &'a mut Panels<R>,
}

impl<R: Real> Vectorized<R> for OuterProducts<'_, R> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        let Panels {
            entries,
            rows,
            columns,
            tall,
            ..
        } = self.to;
        let height = rows.next_multiple_of(L::N);
        for first in (0..height).step_by(*tall * L::N) {
            let panel = &mut entries[first * *columns..];
            let part = BatchRows {
                batch: self.batch,
                columns: *columns,
                height,
                first,
            };
            match (*tall).min((height - first) / L::N) {
                1 => part.add::<L, 1>(panel),
                2 => part.add::<L, 2>(panel),
                3 => part.add::<L, 3>(panel),
                _ => part.add::<L, PANEL>(panel),
            }
        }
    }
}

/// The rows of a batch that belong to one panel.
struct BatchRows<'a, R> {
    batch: &'a Batch<R>,
    columns: usize,
    height: usize,
    first: usize,
}

impl<R: Real> BatchRows<'_, R> {
    #[inline(always)]
    fn add<L: Lane<R>, const W: usize>(&self, panel: &mut [R]) {
        let Batch { x, y_bar, len } = self.batch;
        let mut column = 0;
        // Two columns at once: every load of a cotangent serves both.
        while column + 2 <= self.columns {
            let mut sums = [[L::zero(); W]; 2];
            for s in 0..*len {
                let x = &x[s * self.columns + column..][..2];
                let (x0, x1) = (L::splat(x[0]), L::splat(x[1]));
                let y_bar = &y_bar[s * self.height + self.first..];
                for w in 0..W {
                    let y_bar = L::load(&y_bar[w * L::N..]);
                    sums[0][w] = y_bar.fma(x0, sums[0][w]);
                    sums[1][w] = y_bar.fma(x1, sums[1][w]);
                }
            }
            for sum in sums {
                add_to::<R, L, W>(&mut panel[column * W * L::N..], sum);
                column += 1;
            }
        }
        if column < self.columns {
            let mut sum = [L::zero(); W];
            for s in 0..*len {
                let x0 = L::splat(x[s * self.columns + column]);
                let y_bar = &y_bar[s * self.height + self.first..];
                for w in 0..W {
                    sum[w] = L::load(&y_bar[w * L::N..]).fma(x0, sum[w]);
                }
            }
            add_to::<R, L, W>(&mut panel[column * W * L::N..], sum);
        }
    }
}

#[inline(always)]
fn add_to<R: Real, L: Lane<R>, const W: usize>(to: &mut [R], sum: [L; W]) {
    for w in 0..W {
        let to = &mut to[w * L::N..];
        (L::load(to) + sum[w]).store(to);
    }
}
