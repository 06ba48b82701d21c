//! Products of a layer's matrix with the vectors of one start or of several side by side.

use super::panels::Panels;
use super::tiles::Tiles;
use crate::lanes::{Lane, Vectorized};
use crate::real::Real;

/// A matrix, set out for products with vectors of one start, or of a lane of them.
pub(super) enum Weights<R> {
    Panels(Panels<R>),
    Tiles(Tiles<R>),
}

impl<R: Real> Weights<R> {
    /// Zeros, for so many starts. `numbers` are those of all matrices that products go through in
    /// turns, this one's included.
    pub(super) fn zero((starts, numbers): (usize, usize), rows: usize, columns: usize) -> Self {
        match starts {
            1 => Self::Panels(Panels::taking_turns(numbers, rows, columns)),
            _ => Self::Tiles(Tiles::zero(rows, columns)),
        }
    }

    /// Calls `f(row, column, entry)` for every entry.
    pub(super) fn each(&mut self, f: impl FnMut(usize, usize, &mut R)) {
        match self {
            Self::Panels(panels) => panels.each(f),
            Self::Tiles(tiles) => tiles.each(f),
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
    /// Takes a lane of rows.
    #[inline(always)]
    pub(super) fn add_rows<L: Lane<R>>(&mut self, first: usize, sum: L) {
        let start = match self.start {
            Some(start) => L::load_up_to(&start[first..]),
            None => L::load_up_to(&self.y[first..]),
        };
        self.value(start + sum).store_up_to(&mut self.y[first..]);
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

impl<R: Real> Vectorized<R> for Product<'_, R> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(mut self) {
        match self.matrix {
            Weights::Panels(panels) => panels.times::<L>(self.x, &mut self.output),
            Weights::Tiles(tiles) => tiles.times::<L>(self.x, &mut self.output),
        }
    }
}
