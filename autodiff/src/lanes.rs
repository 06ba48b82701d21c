//! SIMD lanes as a [`Real`]: many evaluations at once, chosen at run time.

use crate::real::Real;

/// A number type that holds `N` scalars of type `S`, one a lane.
pub trait Lane<S>: Real {
    /// How many scalars.
    const N: usize;
    /// The same scalar in every lane.
    fn splat(value: S) -> Self;
    /// The first `N` scalars of a slice.
    fn load(from: &[S]) -> Self;
    /// Writes the lanes to the first `N` places of a slice.
    fn store(self, to: &mut [S]);
}

/// Every number is a lane of itself.
impl<R: Real> Lane<R> for R {
    const N: usize = 1;
    #[inline(always)]
    fn splat(value: R) -> R {
        value
    }
    #[inline(always)]
    fn load(from: &[R]) -> R {
        from[0]
    }
    #[inline(always)]
    fn store(self, to: &mut [R]) {
        to[0] = self;
    }
}

/// Work that is written for any lane width; see [`Real::vectorize`].
pub trait Vectorized<S: Real> {
    /// What the work returns.
    type Output;
    /// Does the work in lanes of type `L`. Implementations are `#[inline(always)]`, all the way
    /// down: only then does the code take on the instruction set it was entered with.
    fn run<L: Lane<S>>(self) -> Self::Output;
}
