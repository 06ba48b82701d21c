//! Inclined planes.

use autodiff::{Dual, Real};

use super::rotation::Rotation;
use super::vector::Vector;

/// A plane that may be inclined along the first axis. In two dimensions it is a line.
#[derive(Clone, Copy, Debug)]
pub struct Plane<R> {
    /// The rotation from the axes of space to the axes of the plane.
    pub axes: Rotation<R>,
    /// The distance of the plane from the origin along the normal, in metres.
    offset: R,
}

impl Plane<f64> {
    /// The level plane through the origin.
    pub const LEVEL: Self = Self {
        axes: Rotation::NONE,
        offset: 0.0,
    };

    /// The plane through a point whose axes have the given rotation.
    pub fn through(point: Vector<f64>, axes: Rotation<f64>) -> Self {
        let offset = axes.tangent().cross(point);
        Self { axes, offset }
    }

    /// Converts the numbers of the plane to the number type `R`, as constants.
    #[inline(always)]
    pub fn lit<R: Real>(&self) -> Plane<R> {
        Plane {
            axes: self.axes.lit(),
            offset: R::lit(self.offset),
        }
    }
}

impl<R: Real> Plane<R> {
    /// The height of a point above the plane, in metres.
    #[inline(always)]
    pub fn height<const D: usize>(&self, place: Vector<R, D>) -> R {
        self.axes.height(place, self.offset)
    }

    /// `if_true` where the mask is true, otherwise `if_false`.
    #[inline(always)]
    pub fn select(mask: R::Mask, if_true: Self, if_false: Self) -> Self {
        Self {
            axes: Rotation::select(mask, if_true.axes, if_false.axes),
            offset: R::select(mask, if_true.offset, if_false.offset),
        }
    }

    /// The plane for duals with the values of `R`, without tangents.
    #[inline(always)]
    pub fn constant<const N: usize>(self) -> Plane<Dual<R, N>> {
        Plane {
            axes: self.axes.constant(),
            offset: Dual::constant(self.offset),
        }
    }

    /// The same plane as a constant: its numbers have no derivatives.
    #[inline(always)]
    #[must_use]
    pub fn detach(self) -> Self {
        Self {
            axes: self.axes.detach(),
            offset: self.offset.detach(),
        }
    }
}
