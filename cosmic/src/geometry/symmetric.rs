//! Symmetric matrices for use in kernels.

use std::ops::Mul;

use autodiff::Real;
use autodiff_programs::Fields;

use super::vector::Vector;

/// A symmetric matrix with `D` rows: the rows up to the diagonal. The entries after it are not read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Symmetric<R, const D: usize>([[R; D]; D]);

/// The numbers of the lower triangle, row by row.
impl<T: Copy, const D: usize> Fields<T> for Symmetric<T, D> {
    const COUNT: usize = D * (D + 1) / 2;

    #[inline(always)]
    fn first_of(numbers: &[T]) -> Self {
        let (mut rows, mut next) = ([[numbers[0]; D]; D], 0);
        for row in 0..D {
            for column in 0..=row {
                rows[row][column] = numbers[next];
                next += 1;
            }
        }
        Self(rows)
    }

    #[inline(always)]
    fn write(self, numbers: &mut [T]) {
        let mut next = 0;
        for row in 0..D {
            for column in 0..=row {
                numbers[next] = self.0[row][column];
                next += 1;
            }
        }
    }

    #[inline(always)]
    fn any(&self) -> T {
        self.0[0][0]
    }
}

impl<R: Real, const D: usize> Symmetric<R, D> {
    /// The matrix with this number in the diagonal and zeros elsewhere.
    #[inline(always)]
    pub fn diagonal(number: R) -> Self {
        let mut rows = [[R::zero(); D]; D];
        for k in 0..D {
            rows[k][k] = number;
        }
        Self(rows)
    }

    /// The matrix that multiplies vectors along the unit vector `u` by `along`, and vectors across it by `across`.
    #[inline(always)]
    pub fn scaling(u: Vector<R, D>, along: R, across: R) -> Self {
        let (mut rows, rest) = ([[R::zero(); D]; D], along - across);
        for row in 0..D {
            for column in 0..row {
                rows[row][column] = rest * u.0[column] * u.0[row];
            }
            rows[row][row] = (rest * u.0[row]).fma(u.0[row], across);
        }
        Self(rows)
    }

    /// The matrix that multiplies vectors along a plane by `along`, and vectors out of it by `out`. The plane is inclined
    /// along the first axis, where it has this tangent.
    #[inline(always)]
    pub fn of_plane(tangent: Vector<R, 2>, along: R, out: R) -> Self {
        let [cos, sin] = tangent.0;
        if D == 2 {
            return Self::scaling(Vector::upright(cos, sin), along, out);
        }
        Self::scaling(Vector::upright(-sin, cos), out, along)
    }

    /// The sum of the diagonal.
    #[inline(always)]
    pub fn trace(self) -> R {
        let mut sum = self.0[0][0];
        for k in 1..D {
            sum += self.0[k][k];
        }
        sum
    }
}

impl<R: Real, const D: usize> Mul<Vector<R, D>> for Symmetric<R, D> {
    type Output = Vector<R, D>;
    #[inline(always)]
    fn mul(self, v: Vector<R, D>) -> Vector<R, D> {
        let mut product = Vector::zero();
        for row in 0..D {
            let mut full = Vector::zero();
            for column in 0..D {
                full.0[column] = self.0[row.max(column)][row.min(column)];
            }
            product.0[row] = full.dot(v);
        }
        product
    }
}
