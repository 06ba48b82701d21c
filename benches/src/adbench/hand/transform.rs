//! Affine transformations of space.

use autodiff::simd::Lane;
use autodiff::{Dual, Real};
use num_traits::Zero;

/// The three upper rows of a homogeneous 4x4 matrix.
#[derive(Clone, Copy, Debug)]
pub struct Affine<R>(pub [[R; 4]; 3]);

impl<R: Real> Affine<R> {
    /// `self` after `first`.
    #[inline(always)]
    pub(super) fn after(&self, first: &Self) -> Self {
        let mut product = self.0;
        for row in 0..3 {
            for column in 0..4 {
                let shift = if column < 3 {
                    R::zero()
                } else {
                    self.0[row][3]
                };
                let mut sum = shift;
                for k in 0..3 {
                    sum += self.0[row][k] * first.0[k][column];
                }
                product[row][column] = sum;
            }
        }
        Self(product)
    }

    /// The image of a point.
    #[inline(always)]
    pub(super) fn apply(&self, point: [R; 3]) -> [R; 3] {
        let mut image = point;
        for row in 0..3 {
            let [x, y, z, shift] = self.0[row];
            image[row] = x.fma(point[0], y.fma(point[1], z.fma(point[2], shift)));
        }
        image
    }

    /// With x the other way round.
    #[inline(always)]
    pub(super) fn mirrored(&self) -> Self {
        let mut mirrored = *self;
        for entry in &mut mirrored.0[0] {
            *entry = -*entry;
        }
        mirrored
    }

    /// Without its shift.
    #[inline(always)]
    pub(super) fn linear(&self) -> Self {
        let mut linear = *self;
        for row in 0..3 {
            linear.0[row][3] = R::zero();
        }
        linear
    }

    /// Entry by entry as another type of number.
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

    /// The rotation about x, then y, then z, right-handed.
    #[inline(always)]
    pub(super) fn euler([x, y, z]: [R; 3]) -> Self {
        let (zero, one) = (R::zero(), R::one());
        let (sin, cos) = (x.sin(), x.cos());
        let about_x = Self([
            [one, zero, zero, zero],
            [zero, cos, -sin, zero],
            [zero, sin, cos, zero],
        ]);
        let (sin, cos) = (y.sin(), y.cos());
        let about_y = Self([
            [cos, zero, sin, zero],
            [zero, one, zero, zero],
            [-sin, zero, cos, zero],
        ]);
        let (sin, cos) = (z.sin(), z.cos());
        let about_z = Self([
            [cos, -sin, zero, zero],
            [sin, cos, zero, zero],
            [zero, zero, one, zero],
        ]);
        about_z.after(&about_y.after(&about_x))
    }
}

/// In every lane the same.
#[inline(always)]
pub(super) fn splat<L: Lane<f64>>(matrix: &Affine<f64>) -> Affine<L> {
    matrix.map(L::splat)
}

/// In every lane the same, with its derivatives.
#[inline(always)]
pub(super) fn lift<L: Lane<f64>, const N: usize>(
    matrix: &Affine<Dual<f64, N>>,
) -> Affine<Dual<L, N>> {
    let mut lifted = Affine([[Dual::zero(); 4]; 3]);
    for row in 0..3 {
        for column in 0..4 {
            let (to, from) = (&mut lifted.0[row][column], matrix.0[row][column]);
            to.value = L::splat(from.value);
            for d in 0..N {
                to.tangent[d] = L::splat(from.tangent[d]);
            }
        }
    }
    lifted
}
