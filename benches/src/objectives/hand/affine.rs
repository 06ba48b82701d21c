//! Affine transformations of space: a linear map and a translation.

use autodiff::Real;

/// An affine transformation, as the three upper rows of a homogeneous 4x4 matrix.
#[derive(Clone, Copy, Debug)]
pub(super) struct Affine<R>(pub(super) [[R; 4]; 3]);

impl<R: Real> Affine<R> {
    /// Returns the transformation that applies `first`, then `self`.
    #[inline(always)]
    pub(super) fn after(&self, first: &Self) -> Self {
        let mut product = self.0;
        for row in 0..3 {
            for column in 0..4 {
                let mut sum = if column < 3 {
                    R::zero()
                } else {
                    self.0[row][3]
                };
                for k in 0..3 {
                    sum += self.0[row][k] * first.0[k][column];
                }
                product[row][column] = sum;
            }
        }
        Self(product)
    }

    /// Returns the image of a point.
    #[inline(always)]
    pub(super) fn apply(&self, point: [R; 3]) -> [R; 3] {
        let mut image = point;
        for row in 0..3 {
            let [x, y, z, shift] = self.0[row];
            image[row] = x.fma(point[0], y.fma(point[1], z.fma(point[2], shift)));
        }
        image
    }

    /// Returns the linear part of the transformation, without its translation.
    #[inline(always)]
    pub(super) fn linear(mut self) -> Self {
        for row in 0..3 {
            self.0[row][3] = R::zero();
        }
        self
    }

    /// Converts each entry to another number type.
    #[inline(always)]
    pub(super) fn map<S: Real>(&self, entry: impl Fn(R) -> S) -> Affine<S> {
        let mut mapped = [[S::zero(); 4]; 3];
        for row in 0..3 {
            for column in 0..4 {
                mapped[row][column] = entry(self.0[row][column]);
            }
        }
        Affine(mapped)
    }

    /// Returns the rotation about x, then about y, then about z. The angles are right-handed.
    #[inline(always)]
    pub(super) fn euler(angles: [R; 3]) -> Self {
        let mut turns = [Self([[R::zero(); 4]; 3]); 3];
        for axis in 0..3 {
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            let (sin, cos) = (angles[axis].sin(), angles[axis].cos());
            let turn = &mut turns[axis].0;
            turn[axis][axis] = R::one();
            (turn[next][next], turn[next][last]) = (cos, -sin);
            (turn[last][next], turn[last][last]) = (sin, cos);
        }
        turns[2].after(&turns[1].after(&turns[0]))
    }
}
