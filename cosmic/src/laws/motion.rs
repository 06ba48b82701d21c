//! The motion of a node in a step: a push changes its velocity, then a drift changes its position. During the drift,
//! the node may meet the ground.

use autodiff::Real;
use autodiff_programs::Array;

use crate::Fields;
use crate::geometry::{Axes, Dimension, Vector};

/// Position and velocity of a node, in the ground's frame.
#[derive(Clone, Copy, Debug, PartialEq, Fields)]
pub struct Particle<R, const D: usize> {
    /// The position, m.
    pub x: Vector<R, D>,
    /// The velocity, m/s.
    pub v: Vector<R, D>,
}

/// Positions and velocities of all nodes, as arrays.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// The positions, m.
    pub x: Axes<Array>,
    /// The velocities, m/s.
    pub v: Axes<Array>,
}

impl<R: Real, const D: usize> Particle<R, D> {
    /// Moves the particle at constant velocity for a time (s).
    #[inline(always)]
    #[must_use]
    pub fn after(self, time: R) -> Self {
        let Self { x, v } = self;
        let x = v.fma(time, x);
        Self { x, v }
    }
}

/// The drift of a node: motion at constant velocity, until the node meets the ground.
#[derive(Clone, Copy, Debug)]
pub struct Drift {
    /// The duration of the drift, s.
    pub dt: f64,
}

impl Drift {
    /// Returns whether a node touches flat ground during the drift, and the time of impact (s). The time is `dt` for a
    /// node that does not touch the ground. Its derivative is 0 at its bounds 0 and `dt` (D9). A node without velocity
    /// towards the ground does not touch it, so nothing is divided by zero.
    #[inline(always)]
    pub fn touch<R: Real, const D: usize>(&self, node: Particle<R, D>) -> (R::Mask, R) {
        let (height, out) = (node.x.up(), node.v.up());
        let (zero, dt) = (R::zero(), R::lit(self.dt));
        let touches = dt.fma(out, height).less(zero) & out.less(zero);
        let approach = R::select(touches, out, -R::one());
        let time_of_impact = (-height / approach).clamp(zero, dt);
        (touches, R::select(touches, time_of_impact, dt))
    }
}

/// Gravity and damping, which change a node's velocity in every push. Kernels get these numbers as their first
/// [`COUNT`](Self::COUNT) uniform inputs.
#[derive(Clone, Copy, Debug, Fields)]
pub struct Push<R, const D: usize> {
    /// The velocity that gravity adds, m/s.
    pub gravity: Vector<R, D>,
    /// The factor `exp(-damping h)`, by which damping multiplies a velocity in a substep of length `h`.
    pub decay: R,
}

impl<R: Real, const D: usize> Push<R, D> {
    /// The number of uniform inputs.
    pub const COUNT: usize = <Self as Fields<R>>::COUNT;

    /// Reads the first uniform inputs of a kernel.
    #[inline(always)]
    pub fn of(uniforms: &[R]) -> Self {
        Self::first_of(uniforms)
    }

    /// Computes the velocity `v*` (m/s) that a node has after the push and before contact. The inputs are the velocity
    /// before the step, the impulse (N s) and 1 / mass (1/kg).
    #[inline(always)]
    pub fn velocity(
        &self,
        v: Vector<R, D>,
        impulse: Vector<R, D>,
        inverse_mass: R,
    ) -> Vector<R, D> {
        let pushed = impulse.fma(inverse_mass, self.gravity);
        v.fma(self.decay, pushed)
    }
}

impl Motion {
    /// The arrays of a node.
    ///
    /// # Panics
    /// If vectors have another number of components.
    pub fn particle<const D: usize>(self) -> Particle<Array, D> {
        Particle {
            x: self.x.vector(),
            v: self.v.vector(),
        }
    }

    /// The components of the positions and velocities, as a list.
    pub fn list(self) -> Vec<Array> {
        [self.x.as_slice(), self.v.as_slice()].concat()
    }

    /// The dimension of the vectors.
    pub fn dimension(&self) -> Dimension {
        self.x.dimension()
    }
}

impl<const D: usize> From<Particle<Array, D>> for Motion
where
    Axes<Array>: From<Vector<Array, D>>,
{
    fn from(Particle { x, v }: Particle<Array, D>) -> Self {
        Self {
            x: x.into(),
            v: v.into(),
        }
    }
}
