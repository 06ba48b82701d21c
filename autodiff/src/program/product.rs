//! Products of a layer's matrix with the vectors of one start or of several side by side.

use super::lanes;
use super::panels::Panels;
use super::tiles::Tiles;
use crate::lanes::{Lane, Vectorized};
use crate::real::Real;

/// A matrix, set out for products with vectors of one start, of two, or of a lane of them.
pub(super) enum Weights<R> {
    One(Panels<R>),
    Two(Panels<R>),
    Lane(Tiles<R>),
}

impl<R: Real> Weights<R> {
    /// Zeros, for so many starts. `numbers` are those of all matrices that products go through in
    /// turns, this one's included.
    pub(super) fn zero((starts, numbers): (usize, usize), rows: usize, columns: usize) -> Self {
        match starts {
            1 => Self::One(Panels::taking_turns(numbers, rows, columns)),
            _ if starts == lanes::<R>() => Self::Lane(Tiles::zero(rows, columns)),
            _ => Self::Two(Panels::taking_turns(numbers, rows, columns)),
        }
    }

    /// Calls `f(row, column, entry)` for every entry.
    pub(super) fn each(&mut self, f: impl FnMut(usize, usize, &mut R)) {
        match self {
            Self::One(panels) | Self::Two(panels) => panels.each(f),
            Self::Lane(tiles) => tiles.each(f),
        }
    }
}

/// `y = start + A x`, or `y += A x` without a start; then `tanh` of it where asked.
pub(super) struct Product<'a, R> {
    pub(super) matrix: &'a Weights<R>,
    pub(super) x: &'a [R],
    pub(super) output: Output<'a, R>,
}

/// Where a product goes.
pub(super) struct Output<'a, R> {
    pub(super) start: Option<&'a [R]>,
    pub(super) y: &'a mut [R],
    /// Where the rows stand in `y`, if not in their order: that only where the lanes are starts.
    pub(super) places: &'a [usize],
    pub(super) tanh: bool,
}

impl<R: Real> Output<'_, R> {
    /// Takes a lane of rows of each vector; they stand side by side in the output.
    #[inline(always)]
    pub(super) fn add_rows<L: Lane<R>, const K: usize>(&mut self, first: usize, sums: [L; K]) {
        if K == 1 {
            return self.add_lane(first, sums[0]);
        }
        let [even, odd] = sums[0].zip(sums[K - 1]);
        self.add_lane(2 * first, even);
        // Of the last rows there may be none left for a second lane.
        if 2 * first + L::N < self.y.len() {
            self.add_lane(2 * first + L::N, odd);
        }
    }

    #[inline(always)]
    fn add_lane<L: Lane<R>>(&mut self, at: usize, sum: L) {
        let start = match self.start {
            Some(start) => L::load_up_to(&start[at..]),
            None => L::load_up_to(&self.y[at..]),
        };
        self.value(start + sum).store_up_to(&mut self.y[at..]);
    }

    /// Takes a row of a lane of starts.
    #[inline(always)]
    pub(super) fn add_starts<L: Lane<R>>(&mut self, row: usize, sum: L) {
        let place = self.places.get(row).copied().unwrap_or(row) * L::N;
        let start = match self.start {
            Some(start) => L::load(&start[row * L::N..]),
            None => L::load(&self.y[place..]),
        };
        self.value(start + sum).store(&mut self.y[place..]);
    }

    #[inline(always)]
    fn value<L: Lane<R>>(&self, sum: L) -> L {
        if self.tanh { sum.tanh() } else { sum }
    }
}

impl<R: Real> Product<'_, R> {
    #[inline(always)]
    pub(super) fn run(self) {
        let Self { matrix, x, output } = self;
        match matrix {
            Weights::One(panels) => R::vectorize(OfPanels::<R, 1>(panels, x, output)),
            Weights::Two(panels) => R::vectorize(OfPanels::<R, 2>(panels, x, output)),
            Weights::Lane(tiles) => R::vectorize(OfTiles(tiles, x, output)),
        }
    }
}

/// With `K` vectors. Code of its own for each: in one function all would be slower.
struct OfPanels<'a, R, const K: usize>(&'a Panels<R>, &'a [R], Output<'a, R>);

impl<R: Real, const K: usize> Vectorized<R> for OfPanels<'_, R, K> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(mut self) {
        self.0.times::<L, K>(self.1, &mut self.2);
    }
}

struct OfTiles<'a, R>(&'a Tiles<R>, &'a [R], Output<'a, R>);

impl<R: Real> Vectorized<R> for OfTiles<'_, R> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(mut self) {
        self.0.times::<L>(self.1, &mut self.2);
    }
}
