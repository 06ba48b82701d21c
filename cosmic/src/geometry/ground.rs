//! The ground and its frame.

use autodiff::Real;

use super::rotation::Rotation;
use super::vector::Vector;

/// The ground line: an inclined line through the origin of the world.
///
/// The world's frame and the ground's frame have the same origin. The first axis of the ground's frame is the
/// [tangent](Ground::tangent), the last axis the [normal](Ground::normal), so the last coordinate is the height above the
/// ground. On level ground the two frames are the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Angle to the horizontal in degrees; positive if the ground rises towards `+x`.
    pub incline_deg: f64,
}

impl Ground {
    /// True if the ground is horizontal. The ground's frame is then the world's frame.
    pub fn is_flat(&self) -> bool {
        self.incline_deg == 0.0
    }

    /// The rotation from the axes of the world to the axes of the ground.
    fn axes(&self) -> Rotation<f64> {
        Rotation::of_degrees(self.incline_deg)
    }

    /// The unit vector `s` along the ground, exactly `(1, 0)` on flat ground.
    pub fn tangent(&self) -> Vector<f64> {
        self.axes().tangent()
    }

    /// The unit vector `n` out of the ground, exactly `(0, 1)` on flat ground.
    pub fn normal(&self) -> Vector<f64> {
        self.axes().normal()
    }

    /// The unit vector that points against gravity, in the ground's frame.
    pub fn vertical<const D: usize>(&self) -> Vector<f64, D> {
        self.vector_to_ground(Vector::upright(0.0, 1.0))
    }

    /// Converts a vector (a position, a velocity, a force) from the world's frame to the ground's.
    pub fn vector_to_ground<R: Real, const D: usize>(&self, vector: Vector<R, D>) -> Vector<R, D> {
        if self.is_flat() {
            return vector;
        }
        self.axes().lit().into_rotated(vector)
    }

    /// Converts a vector from the ground's frame to the world's.
    pub fn vector_to_world<R: Real, const D: usize>(&self, vector: Vector<R, D>) -> Vector<R, D> {
        if self.is_flat() {
            return vector;
        }
        self.axes().lit().out_of_rotated(vector)
    }

    /// The position along the ground, in metres, of a point that is given in the world's frame.
    pub fn along<R: Real, const D: usize>(&self, point: Vector<R, D>) -> R {
        self.vector_to_ground(point).forward()
    }
}
