//! The motion of a node: a push of its velocity, and a drift on which it may meet the ground.
//!
//! All of it is in the ground's frame: first coordinate along the ground, second the height above.

use autodiff::Real;

/// A node on its way over a time, and the ground that it may meet.
#[derive(Clone, Copy, Debug)]
pub struct Drift {
    /// For how long, s.
    pub dt: f64,
}

impl Drift {
    /// Whether a node at this height (m) touches the ground on its way, and the time of impact (s),
    /// which passes no derivative at its bounds 0 and `dt` (D9). A node that does not touch gets
    /// the whole time. `v* = 0` never touches: nothing is divided by zero.
    #[inline(always)]
    pub fn touch<R: Real>(&self, height: R, v_normal: R) -> (R::Mask, R) {
        let (zero, dt) = (R::zero(), R::lit(self.dt));
        let touches = dt.fma(v_normal, height).less(zero) & v_normal.less(zero);
        let approach = R::select(touches, v_normal, -R::one());
        let time_of_impact = (-height / approach).clamp(zero, dt);
        (touches, R::select(touches, time_of_impact, dt))
    }
}

/// The change of a velocity before its node drifts.
#[derive(Clone, Copy, Debug)]
pub struct Flight {
    /// The drift that follows.
    pub drift: Drift,
    /// The share of a velocity that damping leaves, `exp(-damping h)`.
    pub decay: f64,
    /// Velocity that gravity adds, along the ground and across it, m/s.
    pub gravity: [f64; 2],
}

impl Flight {
    /// The velocity `v*` before contact, m/s, from that before the step, the impulse (N s) and
    /// 1 / mass (1/kg).
    #[inline(always)]
    pub fn velocity<R: Real>(&self, v: [R; 2], impulse: [R; 2], inverse_mass: R) -> [R; 2] {
        let mut velocity = v;
        for k in 0..2 {
            let pushed = impulse[k].fma(inverse_mass, R::lit(self.gravity[k]));
            velocity[k] = R::lit(self.decay).fma(v[k], pushed);
        }
        velocity
    }
}
