//! Products of a layer's matrix with the vector of one start, or the interleaved ones of several.

use super::lanes;
use super::panels::Panels;
use super::tiles::Tiles;
use crate::lanes::{Lane, Vectorized};
use crate::real::Real;

/// A matrix, stored for products with the vectors of one start, of two, or of one for each lane.
pub(super) enum Weights<R> {
    One(Panels<R>),
    Two(Panels<R>),
    Lane(Tiles<R>),
}

impl<R: Real> Weights<R> {
    /// Zeros, for this many starts. `numbers` counts the entries of all matrices whose products
    /// alternate, this one's included.
    pub(super) fn zero((starts, numbers): (usize, usize), rows: usize, columns: usize) -> Self {
        match starts {
            1 => Self::One(Panels::taking_turns(numbers, rows, columns)),
            _ if starts == lanes::<R>() => Self::Lane(Tiles::zero(rows, columns)),
            _ => Self::Two(Panels::taking_turns(numbers, rows, columns)),
        }
    }

    /// As of [`Panels::each`].
    pub(super) fn each(&mut self, f: impl FnMut(usize, usize, &mut [R])) {
        match self {
            Self::One(panels) | Self::Two(panels) => panels.each(f),
            Self::Lane(tiles) => tiles.each(f),
        }
    }
}

/// `y = bias + A x`, or `y += A x` without a bias; then `tanh` of it where asked.
pub(super) struct Product<'a, R> {
    pub(super) matrix: &'a Weights<R>,
    pub(super) x: &'a [R],
    pub(super) output: Output<'a, R>,
}

/// Where a product goes.
pub(super) struct Output<'a, R> {
    pub(super) bias: Option<&'a [R]>,
    pub(super) y: &'a mut [R],
    /// Which registers of `y` are rows, if not all in their order; only where each lane is a start.
    pub(super) places: &'a [usize],
    pub(super) tanh: bool,
}

impl<R: Real> Output<'_, R> {
    /// Takes the sums of `H` registers of rows, from the row `first` on, for each of `K` vectors; the
    /// output interleaves them.
    #[inline(always)]
    pub(super) fn add_rows<L: Lane<R>, const H: usize, const K: usize>(
        &mut self,
        first: usize,
        sums: [[L; K]; H],
    ) {
        let (mut at, mut even, mut odd) = ([0; H], [L::zero(); H], [L::zero(); H]);
        for h in 0..H {
            at[h] = (first + h * L::N) * K;
            [even[h], odd[h]] = match K {
                1 => [sums[h][0], L::zero()],
                _ => sums[h][0].zip(sums[h][K - 1]),
            };
        }
        self.add((at, at), even);
        if K > 1 {
            // Past the last rows nothing may be left of a second register.
            for h in 0..H {
                at[h] += L::N;
            }
            self.add((at, at), odd);
        }
    }

    /// Takes the sums of `N` rows, from the row `first` on, each a register of starts; those past the last
    /// of `rows` are dropped.
    #[inline(always)]
    pub(super) fn add_starts<L: Lane<R>, const N: usize>(
        &mut self,
        (first, rows): (usize, usize),
        sums: [L; N],
    ) {
        let (mut from, mut to) = ([0; N], [self.y.len(); N]);
        for n in 0..N {
            let row = first + n;
            from[n] = row * L::N;
            if row < rows {
                to[n] = self.places.get(row).copied().unwrap_or(row) * L::N;
            }
        }
        self.add((from, to), sums);
    }

    /// Adds registers to the bias from places `from` on, or to `y`, and writes them to `y` from places
    /// `to` on; what lies past the end of either is dropped.
    #[inline(always)]
    fn add<L: Lane<R>, const N: usize>(
        &mut self,
        (from, to): ([usize; N], [usize; N]),
        mut sums: [L; N],
    ) {
        for n in 0..N {
            let before = match self.bias {
                Some(bias) => L::load_up_to(&bias[from[n].min(bias.len())..]),
                None => L::load_up_to(&self.y[to[n].min(self.y.len())..]),
            };
            sums[n] = before + sums[n];
        }
        if self.tanh {
            sums = L::tanh_each(sums);
        }
        for n in 0..N {
            let to = to[n].min(self.y.len());
            sums[n].store_up_to(&mut self.y[to..]);
        }
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

/// With `K` vectors. Each `K`, and tiles, have an entry of their own: all in one would be slower.
struct OfPanels<'a, R, const K: usize>(&'a Panels<R>, &'a [R], Output<'a, R>);

impl<R: Real, const K: usize> Vectorized<R> for OfPanels<'_, R, K> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(mut self) {
        // A constant condition, here and below, so that the impossible case is not compiled.
        if const { K > L::N } {
            unreachable!("one lane has no room for {K} starts");
        }
        self.0.times::<L, K>(self.1, &mut self.2);
    }
}

struct OfTiles<'a, R>(&'a Tiles<R>, &'a [R], Output<'a, R>);

impl<R: Real> Vectorized<R> for OfTiles<'_, R> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(mut self) {
        if const { L::N == 1 } {
            unreachable!("a single start is a vector");
        }
        self.0.times::<L>(self.1, &mut self.2);
    }
}
