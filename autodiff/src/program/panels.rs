//! Matrices in panels that fit the registers: products with vectors, and sums of outer products.
//!
//! The gradient of a layer's weights is gathered over several steps and added as one matrix
//! product: it then touches the gradient's memory once in [`BATCH`] steps.
//!
//! From several starts at once, the lanes are starts: a panel is a few rows, and every weight
//! serves all starts once it is read. The sums of each have the same order as alone.

use super::{Aligned, lanes};
use crate::lanes::{Lane, Vectorized};
use crate::real::Real;

/// Steps whose outer products are added together; those of several starts count apart.
const BATCH: usize = 16;
/// The most lanes of rows that are worked on at once: their sums stay in registers.
const PANEL: usize = 4;
/// Rows that are worked on at once where the lanes are starts.
const TILE: usize = 16;
/// Columns that are summed up apart, so that no sum waits for the one before.
const PHASES: usize = 4;
/// Bytes of a matrix beyond which two of its kind do not fit the first cache together.
const LARGE: usize = 24 << 10;

/// A matrix in panels of some lanes of rows; within a panel column after column.
///
/// Two matrices of a controller do not fit the first cache together. So they are read in panels
/// forth and back in turns: what the last product read at its end is what the next one reads
/// first. That a sixth of a rollout's time is saved says `cosmic explain --measure`.
pub(super) struct Panels<R> {
    pub(super) entries: Aligned<R>,
    rows: usize,
    columns: usize,
    /// Rows in a panel; the last one may have fewer, but whole lanes where the lanes are rows.
    tall: usize,
    /// What the lanes are.
    lanes: Across,
    /// Whether the next product begins at the end.
    pub(super) back: bool,
}

/// What the lanes of a product are.
#[derive(Clone, Copy, PartialEq)]
enum Across {
    Rows,
    Starts,
}

impl Across {
    /// The order of so many columns in a panel: tiles are summed up phase after phase.
    fn order(self, columns: usize) -> impl Iterator<Item = usize> {
        let phases = if self == Self::Rows { 1 } else { PHASES };
        (0..phases).flat_map(move |phase| (phase..columns).step_by(phases))
    }
}

impl<R: Real> Panels<R> {
    pub(super) fn zero(rows: usize, columns: usize) -> Self {
        let lanes_of_rows = rows.div_ceil(lanes::<R>());
        let entries = Aligned::zeros(lanes_of_rows * lanes::<R>() * columns);
        // Two panels at least of a large one, or there is nothing to turn round.
        let least = 1 + usize::from(size_of_val(&entries[..]) > LARGE);
        let tall = lanes_of_rows.div_ceil(least).min(PANEL) * lanes::<R>();
        Self {
            entries,
            rows,
            columns,
            tall,
            lanes: Across::Rows,
            back: false,
        }
    }

    /// For products with the vectors of one start, or of a lane of them.
    pub(super) fn for_starts(starts: usize, rows: usize, columns: usize) -> Self {
        if starts == 1 {
            return Self::zero(rows, columns);
        }
        Self {
            entries: Aligned::zeros(rows.next_multiple_of(TILE) * columns),
            rows,
            columns,
            tall: TILE,
            lanes: Across::Starts,
            back: false,
        }
    }

    /// The first rows of the panels, in the order of the next product.
    #[inline(always)]
    fn firsts(&self) -> impl Iterator<Item = usize> {
        let Self {
            rows, tall, back, ..
        } = *self;
        let panels = rows.div_ceil(tall);
        (0..panels).map(move |panel| tall * if back { panels - 1 - panel } else { panel })
    }

    /// Calls `f(row, column, entry)` for every entry.
    pub(super) fn each(&mut self, mut f: impl FnMut(usize, usize, &mut R)) {
        let height = self.entries.len() / self.columns;
        for first in (0..height).step_by(self.tall) {
            let tall = self.tall.min(height - first);
            let panel = &mut self.entries[first * self.columns..][..tall * self.columns];
            let columns = self.lanes.order(self.columns);
            for (column, part) in columns.zip(panel.chunks_exact_mut(tall)) {
                for (row, entry) in part.iter_mut().enumerate() {
                    if first + row < self.rows {
                        f(first + row, column, entry);
                    }
                }
            }
        }
    }
}

/// Inputs and output cotangents of the last steps, of one start after the other.
pub(super) struct Batch<R> {
    x: Vec<R>,
    /// In whole lanes. The last is that of the step that is under way, if there is one start.
    y_bar: Aligned<R>,
    /// The cotangents of the step that is under way, if there are several starts side by side.
    side_by_side: Aligned<R>,
    starts: usize,
    rows: usize,
    /// From one step's cotangents to those of the next.
    tall: usize,
    len: usize,
}

impl<R: Real> Batch<R> {
    pub(super) fn new(starts: usize, rows: usize, columns: usize) -> Self {
        let numbers = if starts == 1 { 0 } else { rows * starts };
        let tall = rows.next_multiple_of(lanes::<R>());
        Self {
            x: vec![R::zero(); BATCH * columns],
            y_bar: Aligned::zeros(BATCH * tall + lanes::<R>()),
            // With room for a lane past the last, as above.
            side_by_side: Aligned::zeros(numbers + lanes::<R>()),
            starts,
            rows,
            tall,
            len: 0,
        }
    }

    /// The cotangents of the step that is under way.
    pub(super) fn under_way(&self) -> &[R] {
        match self.starts {
            1 => &self.y_bar[self.len * self.tall..][..self.rows],
            starts => &self.side_by_side[..self.rows * starts],
        }
    }

    /// The place for these, with room for a lane past the last.
    pub(super) fn under_way_mut(&mut self) -> &mut [R] {
        match self.starts {
            1 => &mut self.y_bar[self.len * self.tall..],
            _ => &mut self.side_by_side,
        }
    }

    /// Keeps the step that is under way, with its inputs; says whether the batch is full.
    pub(super) fn note(&mut self, x: &[R]) -> bool {
        let (starts, tall) = (self.starts, self.tall);
        let columns = x.len() / starts;
        if starts == 1 {
            self.x[self.len * columns..][..columns].copy_from_slice(x);
        } else {
            let to = &mut self.x[self.len * columns..][..columns * starts];
            part(x, (starts, columns), to);
            let to = &mut self.y_bar[self.len * tall..][..tall * starts];
            part(&self.side_by_side[..self.rows * starts], (starts, tall), to);
        }
        self.len += starts;
        self.len == BATCH
    }

    pub(super) fn clear(&mut self) {
        self.len = 0;
    }
}

/// Numbers of several starts side by side become those of one after the other, so far apart.
fn part<R: Real>(side_by_side: &[R], (starts, apart): (usize, usize), to: &mut [R]) {
    for (start, to) in to.chunks_exact_mut(apart).enumerate() {
        let of_start = side_by_side[start..].iter().step_by(starts);
        for (to, &from) in to.iter_mut().zip(of_start) {
            *to = from;
        }
    }
}

/// `y = start + A x`, or `y += A x` without a start; then `tanh` of it where asked. Every entry
/// of `y` is summed in the same order at every lane width: every fourth column, then those sums.
pub(super) struct Product<'a, R> {
    pub(super) matrix: &'a Panels<R>,
    pub(super) x: &'a [R],
    pub(super) start: Option<&'a [R]>,
    pub(super) y: &'a mut [R],
    /// Where the rows stand in `y`, if not in their order: that only where the lanes are starts.
    pub(super) places: &'a [usize],
    pub(super) tanh: bool,
}

impl<R: Real> Vectorized<R> for Product<'_, R> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(mut self) {
        let Panels { rows, tall, .. } = *self.matrix;
        match self.matrix.lanes {
            Across::Starts => {
                for first in self.matrix.firsts() {
                    self.tile::<L>(first);
                }
            }
            Across::Rows => {
                for first in self.matrix.firsts() {
                    match tall.min(rows - first).div_ceil(L::N) {
                        1 => self.panel::<L, 1>(first),
                        2 => self.panel::<L, 2>(first),
                        3 => self.panel::<L, 3>(first),
                        _ => self.panel::<L, PANEL>(first),
                    }
                }
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

impl<R: Real> Product<'_, R> {
    /// A few rows, for a lane of starts: each sum has the order of [`panel`](Self::panel).
    #[inline(always)]
    fn tile<L: Lane<R>>(&mut self, first: usize) {
        let (mut sums, more) = (self.phase::<L>(first, 0), self.phase::<L>(first, 1));
        for row in 0..TILE {
            sums[row] += more[row];
        }
        let (third, last) = (self.phase::<L>(first, 2), self.phase::<L>(first, 3));
        for row in 0..TILE {
            sums[row] += third[row] + last[row];
        }
        for k in 0..TILE.min(self.matrix.rows - first) {
            let row = first + k;
            let place = self.places.get(row).copied().unwrap_or(row) * L::N;
            let start = match self.start {
                Some(start) => L::load(&start[row * L::N..]),
                None => L::load(&self.y[place..]),
            };
            let sum = start + sums[k];
            (if self.tanh { sum.tanh() } else { sum }).store(&mut self.y[place..]);
        }
    }

    /// The sums of every fourth column. One phase at a time, as the registers hold more rows that
    /// way: what is read for a multiplication is then little more than its weight.
    #[inline(always)]
    fn phase<L: Lane<R>>(&self, first: usize, phase: usize) -> [L; TILE] {
        let columns = self.matrix.columns;
        let before = (0..phase).map(|p| columns.saturating_sub(p).div_ceil(PHASES));
        let place = first * columns + before.sum::<usize>() * TILE;
        let count = columns.saturating_sub(phase).div_ceil(PHASES);
        let weights = self.matrix.entries[place..][..count * TILE].chunks_exact(TILE);
        let x = self.x[(phase * L::N).min(self.x.len())..].chunks(PHASES * L::N);
        let mut sums = [L::zero(); TILE];
        for (weights, x) in weights.zip(x) {
            let x = L::load(x);
            for row in 0..TILE {
                sums[row] = L::splat(weights[row]).fma(x, sums[row]);
            }
        }
        sums
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
        for first in (0..height).step_by(*tall) {
            let panel = &mut entries[first * *columns..];
            let part = BatchRows {
                batch: self.batch,
                columns: *columns,
                height,
                first,
            };
            match (*tall).min(height - first) / L::N {
                1 => part.add::<L, 1, 8>(panel),
                2 => part.add::<L, 2, 4>(panel),
                3 => part.add::<L, 3, 2>(panel),
                _ => part.add::<L, PANEL, 2>(panel),
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
    /// To a panel of `W` lanes of rows, `C` columns at once: every load of a cotangent serves all
    /// of them, and none of their sums waits for the one before.
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

    #[inline(always)]
    fn add_columns<L: Lane<R>, const W: usize, const C: usize>(
        &self,
        panel: &mut [R],
        column: usize,
    ) {
        let Batch { x, y_bar, len, .. } = self.batch;
        let mut sums = [[L::zero(); W]; C];
        for s in 0..*len {
            let x = &x[s * self.columns + column..][..C];
            let y_bar = &y_bar[s * self.height + self.first..][..W * L::N];
            for w in 0..W {
                let y_bar = L::load(&y_bar[w * L::N..]);
                for c in 0..C {
                    sums[c][w] = y_bar.fma(L::splat(x[c]), sums[c][w]);
                }
            }
        }
        for c in 0..C {
            add_to::<R, L, W>(&mut panel[(column + c) * W * L::N..], sums[c]);
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
