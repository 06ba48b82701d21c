//! Rotations in the vertical plane.

use autodiff::{Dual, Real};

use super::vector::Vector;

/// A rotation in the plane of the first and the last axis: turns the first axis towards the last. Other axes do not
/// change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation<R> {
    cos: R,
    sin: R,
}

impl Rotation<f64> {
    /// No rotation.
    pub const NONE: Self = Self { cos: 1.0, sin: 0.0 };

    /// The rotation by an angle in degrees.
    pub fn of_degrees(degrees: f64) -> Self {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Self { cos, sin }
    }

    /// The rotation that turns the first axis to the direction from one point to another.
    pub fn towards(from: Vector<f64>, to: Vector<f64>) -> Self {
        let [cos, sin] = (to - from).unit().in_plane();
        Self { cos, sin }
    }

    /// The first axis after the rotation.
    pub fn tangent(&self) -> Vector<f64> {
        Vector::upright(self.cos, self.sin)
    }

    /// The last axis after the rotation.
    pub fn normal(&self) -> Vector<f64> {
        Vector::upright(-self.sin, self.cos)
    }

    /// Converts the numbers of the rotation to the number type `R`, as constants.
    #[inline(always)]
    pub fn lit<R: Real>(&self) -> Rotation<R> {
        Rotation {
            cos: R::lit(self.cos),
            sin: R::lit(self.sin),
        }
    }
}

impl<R: Real> Rotation<R> {
    /// The rotation that turns the first axis to the unit vector `tangent`.
    #[inline(always)]
    pub fn with_tangent(tangent: Vector<R, 2>) -> Self {
        let [cos, sin] = tangent.0;
        Self { cos, sin }
    }

    /// Converts a vector to its components along the rotated axes.
    #[inline(always)]
    pub fn into_rotated<const D: usize>(&self, vector: Vector<R, D>) -> Vector<R, D> {
        let mut rotated = vector;
        rotated.0[0] = self.cos.fma(vector.forward(), self.sin * vector.up());
        rotated.0[D - 1] = self.out(vector);
        rotated
    }

    /// The inverse of [`into_rotated`](Self::into_rotated): converts components along the rotated axes to the vector.
    #[inline(always)]
    pub fn out_of_rotated<const D: usize>(&self, rotated: Vector<R, D>) -> Vector<R, D> {
        let mut vector = rotated;
        vector.0[0] = self.cos.fma(rotated.forward(), -(self.sin * rotated.up()));
        vector.0[D - 1] = self.sin.fma(rotated.forward(), self.cos * rotated.up());
        vector
    }

    /// Like [`out_of_rotated`](Self::out_of_rotated), for components along the rotated axes of which the last one is 0.
    #[inline(always)]
    pub fn out_of_plane<const D: usize>(&self, along: Vector<R, D>) -> Vector<R, D> {
        let mut vector = along;
        vector.0[0] = self.cos * along.forward();
        vector.0[D - 1] = self.sin * along.forward();
        vector
    }

    /// The component of a vector along the last axis after the rotation.
    #[inline(always)]
    pub fn out<const D: usize>(&self, vector: Vector<R, D>) -> R {
        self.cos.fma(vector.up(), -(self.sin * vector.forward()))
    }

    /// The height of a point above a plane. The normal of the plane is the last axis after the rotation. `offset` is
    /// the distance of the plane from the origin along that normal.
    #[inline(always)]
    pub(super) fn height<const D: usize>(&self, place: Vector<R, D>, offset: R) -> R {
        self.cos
            .fma(place.up(), (-self.sin).fma(place.forward(), -offset))
    }

    /// `if_true` where the mask is true, otherwise `if_false`.
    #[inline(always)]
    pub fn select(mask: R::Mask, if_true: Self, if_false: Self) -> Self {
        Self {
            cos: R::select(mask, if_true.cos, if_false.cos),
            sin: R::select(mask, if_true.sin, if_false.sin),
        }
    }

    /// The rotation for duals with the values of `R`, without tangents.
    #[inline(always)]
    pub fn constant<const N: usize>(self) -> Rotation<Dual<R, N>> {
        Rotation {
            cos: Dual::constant(self.cos),
            sin: Dual::constant(self.sin),
        }
    }

    /// The same rotation as a constant: its numbers have no derivatives.
    #[inline(always)]
    #[must_use]
    pub fn detach(self) -> Self {
        Self {
            cos: self.cos.detach(),
            sin: self.sin.detach(),
        }
    }
}
