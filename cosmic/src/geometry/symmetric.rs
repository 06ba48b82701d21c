//! Symmetric matrices of the plane, for use in kernels.

use std::ops::Mul;

use autodiff::Real;

use super::vector::Vector;

/// A symmetric matrix with two rows: the entries `[0, 0]`, `[1, 0]` and `[1, 1]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Symmetric<R>([R; 3]);

impl<R: Real> Symmetric<R> {
    /// The matrix with these entries: those of the lower triangle, row by row.
    #[inline(always)]
    pub fn new(triangle: [R; 3]) -> Self {
        Self(triangle)
    }

    /// The matrix that multiplies vectors along the unit vector `u` by `along`, and vectors across it by `across`.
    #[inline(always)]
    pub fn scaling(u: Vector<R, 2>, along: R, across: R) -> Self {
        let [x, y] = u.0;
        let rest = along - across;
        Self([
            (rest * x).fma(x, across),
            rest * x * y,
            (rest * y).fma(y, across),
        ])
    }

    /// The entries of the lower triangle, row by row.
    #[inline(always)]
    pub fn array(self) -> [R; 3] {
        self.0
    }

    /// The sum of the diagonal.
    #[inline(always)]
    pub fn trace(self) -> R {
        self.0[0] + self.0[2]
    }
}

impl<R: Real> Mul<Vector<R, 2>> for Symmetric<R> {
    type Output = Vector<R, 2>;
    #[inline(always)]
    fn mul(self, v: Vector<R, 2>) -> Vector<R, 2> {
        let [xx, xy, yy] = self.0;
        let [x, y] = v.0;
        Vector([xx.fma(x, xy * y), xy.fma(x, yy * y)])
    }
}
