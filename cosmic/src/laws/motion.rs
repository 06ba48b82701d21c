//! The motion of a node: a push of its velocity, and a drift on which it may meet the ground.

use autodiff::Real;

use crate::geometry::Vector;

/// Where a node is and how it moves, in the ground's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Particle<R, const D: usize = 2> {
    /// Its position, m.
    pub x: Vector<R, D>,
    /// Its velocity, m/s.
    pub v: Vector<R, D>,
}

impl<R> Particle<R> {
    /// The particle of `[x, y, vx, vy]`.
    #[inline(always)]
    pub fn new([x, y, vx, vy]: [R; 4]) -> Self {
        let (x, v) = (Vector::new([x, y]), Vector::new([vx, vy]));
        Self { x, v }
    }

    /// Its `[x, y, vx, vy]`.
    #[inline(always)]
    pub fn array(self) -> [R; 4] {
        let ([x, y], [vx, vy]) = (self.x.array(), self.v.array());
        [x, y, vx, vy]
    }
}

impl<R: Real, const D: usize> Particle<R, D> {
    /// The particle after a time (s) at its velocity.
    #[inline(always)]
    #[must_use]
    pub fn after(self, time: R) -> Self {
        let Self { x, v } = self;
        let x = v.fma(time, x);
        Self { x, v }
    }
}

/// A node on its way over a time, and the ground that it may meet.
#[derive(Clone, Copy, Debug)]
pub struct Drift {
    /// For how long, s.
    pub dt: f64,
}

impl Drift {
    /// Whether a node touches the ground on its way, and the time of impact (s), which passes no derivative at
    /// its bounds 0 and `dt` (D9). A node that does not touch gets the whole time. `v* = 0` never touches:
    /// nothing is divided by zero.
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

/// The change of a velocity before its node drifts.
#[derive(Clone, Copy, Debug)]
pub struct Flight<const D: usize = 2> {
    /// The drift that follows.
    pub drift: Drift,
    /// The share of a velocity that damping leaves, `exp(-damping h)`.
    pub decay: f64,
    /// The velocity that gravity adds in the scene, m/s; a step is given it as an input.
    pub gravity: Vector<f64, D>,
}

impl<const D: usize> Flight<D> {
    /// The velocity `v*` before contact, m/s, from that before the step, the impulse (N s),
    /// 1 / mass (1/kg) and the velocity that gravity adds (m/s).
    #[inline(always)]
    pub fn velocity<R: Real>(
        &self,
        v: Vector<R, D>,
        impulse: Vector<R, D>,
        inverse_mass: R,
        gravity: Vector<R, D>,
    ) -> Vector<R, D> {
        let pushed = impulse.fma(inverse_mass, gravity);
        v.fma(R::lit(self.decay), pushed)
    }
}
