//! Products of a layer's matrix with the vector of one start, or with the interleaved vectors of several.

use autodiff::Real;
use autodiff::internal::lanes;
use autodiff::simd::{Lane, Vectorized};

use super::epilogue::Epilogue;
use super::panels::Panels;
use super::tiles::Tiles;

/// A matrix stored for products with the vectors of one start, of two starts, or of one start per lane.
pub(super) enum PackedMatrix<R> {
    One(Panels<R>),
    Two(Panels<R>),
    Lane(Tiles<R>),
}

impl<R: Real> PackedMatrix<R> {
    /// Returns a matrix of zeros for products with the vectors of `starts` starts (initial states).
    pub(super) fn zero(rows: usize, columns: usize, starts: usize) -> Self {
        match starts {
            1 => Self::One(Panels::zero(rows, columns)),
            _ if starts == lanes::<R>() => Self::Lane(Tiles::zero(rows, columns)),
            _ => Self::Two(Panels::zero(rows, columns)),
        }
    }

    /// Calls a function for the entries of each column; see [`Panels::each`].
    pub(super) fn each(&mut self, f: impl FnMut(usize, usize, &mut [R])) {
        match self {
            Self::One(panels) | Self::Two(panels) => panels.each(f),
            Self::Lane(tiles) => tiles.each(f),
        }
    }
}

/// Computes `y = bias + A x`, or `y += A x` if there is no bias. If `tanh` is true, the hyperbolic tangent is applied
/// to the result.
pub(super) struct MatrixProduct<'a, R> {
    pub(super) matrix: &'a PackedMatrix<R>,
    pub(super) x: &'a [R],
    pub(super) output: Epilogue<'a, R>,
}

impl<R: Real> MatrixProduct<'_, R> {
    #[inline(always)]
    pub(super) fn run(self) {
        let Self { matrix, x, output } = self;
        match matrix {
            PackedMatrix::One(panels) => R::vectorize(OfPanels::<R, 1>(panels, x, output)),
            PackedMatrix::Two(panels) => R::vectorize(OfPanels::<R, 2>(panels, x, output)),
            PackedMatrix::Lane(tiles) => R::vectorize(OfTiles(tiles, x, output)),
        }
    }
}

/// The product of a matrix in panels with `K` vectors. Each `K` is dispatched to SIMD code separately, and so is the
/// product of a matrix in tiles: one common dispatch would be slower.
struct OfPanels<'a, R, const K: usize>(&'a Panels<R>, &'a [R], Epilogue<'a, R>);

impl<R: Real, const K: usize> Vectorized<R> for OfPanels<'_, R, K> {
    const USE_THE_ATTRIBUTE_KERNEL: () = ();
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(mut self) {
        // Here and below, the condition is constant and the impossible case is not compiled.
        if const { K > L::N } {
            unreachable!("a register of one lane cannot hold {K} starts");
        }
        self.0.times::<L, K>(self.1, &mut self.2);
    }
}

struct OfTiles<'a, R>(&'a Tiles<R>, &'a [R], Epilogue<'a, R>);

impl<R: Real> Vectorized<R> for OfTiles<'_, R> {
    const USE_THE_ATTRIBUTE_KERNEL: () = ();
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(mut self) {
        if const { L::N == 1 } {
            unreachable!("a single start uses panels");
        }
        self.0.times::<L>(self.1, &mut self.2);
    }
}
