//! The physics of a step, as kernels: one spring, one node's contact.
//!
//! They work in the ground's frame: first coordinate along the ground, second the height above.

use autodiff::{Kernel, Real};

/// Softens the length of an edge, m^2: smooth where its nodes coincide (D4).
const SOFTENING: f64 = 1e-12;

/// Hooke's law of an edge that is told a target length: its impulse on its tail over a step.
///
/// From the edge's vector (m), activation, stiffness (N/m), rest length (m) and strain at full
/// activation; to an impulse (N s).
#[derive(Clone, Copy, Debug)]
pub(super) struct Spring {
    /// Length of a step, s.
    pub(super) dt: f64,
}

impl Kernel<6, 2> for Spring {
    #[inline(always)]
    fn eval<R: Real>(&self, [dx, dy, u, stiffness, rest_length, strain]: [R; 6]) -> [R; 2] {
        let length = dx.fma(dx, dy.fma(dy, R::lit(SOFTENING))).sqrt();
        let target = rest_length * strain.fma(u, R::one());
        let per_length = stiffness * (length - target) * R::lit(self.dt) / length;
        [per_length * dx, per_length * dy]
    }
}

/// A node on its way over a time, and the ground that it may meet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drift {
    /// For how long, s.
    pub(super) dt: f64,
}

impl Drift {
    /// Whether a node at this height touches the ground on its way, and when. A node that does
    /// not touch gets the whole time. `v* = 0` never touches: nothing is divided by zero.
    #[inline(always)]
    fn touch<R: Real>(&self, height: R, v_normal: R) -> (R::Mask, R) {
        let (zero, dt) = (R::zero(), R::lit(self.dt));
        let touches = dt.fma(v_normal, height).lt(zero) & v_normal.lt(zero);
        let approach = R::select(touches, v_normal, -R::one());
        let time_of_impact = (-height / approach).clamp(zero, dt);
        (touches, R::select(touches, time_of_impact, dt))
    }

    /// Where a node gets where there is no ground: its new `[x, y, vx, vy]`.
    #[inline(always)]
    fn pass<R: Real>(&self, [x, y]: [R; 2], [vx, vy]: [R; 2]) -> [R; 4] {
        let dt = R::lit(self.dt);
        [dt.fma(vx, x), dt.fma(vy, y), vx, vy]
    }

    /// Where a node gets that stops where it touches: its new `[x, y, vx, vy]`.
    #[inline(always)]
    fn stick<R: Real>(&self, [x, y]: [R; 2], [vx, vy]: [R; 2]) -> [R; 4] {
        let (touches, moving) = self.touch(y, vy);
        let after = |v: R| R::select(touches, R::zero(), v);
        [moving.fma(vx, x), moving.fma(vy, y), after(vx), after(vy)]
    }

    /// The same for a node that is braked along the ground but never reversed (D5).
    #[inline(always)]
    fn slide<R: Real>(&self, friction: f64, [x, y]: [R; 2], [vx, vy]: [R; 2]) -> [R; 4] {
        let (touches, moving) = self.touch(y, vy);
        let left = vx.abs() - R::lit(friction) * vy.abs();
        let braked = vx.signum() * left.max(R::zero());
        let rest = R::lit(self.dt) - moving;
        [
            moving.fma(vx, x) + R::select(touches, rest * braked, R::zero()),
            moving.fma(vy, y),
            R::select(touches, braked, vx),
            R::select(touches, R::zero(), vy),
        ]
    }
}

/// As [`StickingDrift`], where there is no ground.
impl Kernel<4, 4> for Drift {
    #[inline(always)]
    fn eval<R: Real>(&self, [x, y, vx, vy]: [R; 4]) -> [R; 4] {
        self.pass([x, y], [vx, vy])
    }
}

/// What a velocity becomes before its node drifts; as a kernel a step where there is no ground,
/// numbers as for [`Sticking`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Flight {
    /// The drift that follows.
    pub(super) drift: Drift,
    /// What damping leaves of a velocity.
    pub(super) decay: f64,
    /// Velocity that gravity adds, along the ground and across it, m/s.
    pub(super) gravity: [f64; 2],
}

impl Flight {
    /// The velocity `v*` before contact.
    #[inline(always)]
    fn velocity<R: Real>(&self, v: [R; 2], impulse: [R; 2], inverse_mass: R) -> [R; 2] {
        let mut velocity = v;
        for k in 0..2 {
            let pushed = impulse[k].fma(inverse_mass, R::lit(self.gravity[k]));
            velocity[k] = R::lit(self.decay).fma(v[k], pushed);
        }
        velocity
    }
}

impl Kernel<7, 4> for Flight {
    #[inline(always)]
    fn eval<R: Real>(&self, [x, y, vx, vy, jx, jy, inverse_mass]: [R; 7]) -> [R; 4] {
        let v = self.velocity([vx, vy], [jx, jy], inverse_mass);
        self.drift.pass([x, y], v)
    }
}

/// A step of a node that stops where it touches the ground (infinite friction).
///
/// From `[x, y, vx, vy, impulse x, impulse y, 1 / mass]` to the new `[x, y, vx, vy]`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sticking(pub(super) Flight);

impl Kernel<7, 4> for Sticking {
    #[inline(always)]
    fn eval<R: Real>(&self, [x, y, vx, vy, jx, jy, inverse_mass]: [R; 7]) -> [R; 4] {
        let v = self.0.velocity([vx, vy], [jx, jy], inverse_mass);
        self.0.drift.stick([x, y], v)
    }
}

/// A step of a node under Coulomb friction. Numbers as for [`Sticking`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Sliding {
    pub(super) flight: Flight,
    /// Coefficient of friction.
    pub(super) friction: f64,
}

impl Kernel<7, 4> for Sliding {
    #[inline(always)]
    fn eval<R: Real>(&self, [x, y, vx, vy, jx, jy, inverse_mass]: [R; 7]) -> [R; 4] {
        let v = self.flight.velocity([vx, vy], [jx, jy], inverse_mass);
        self.flight.drift.slide(self.friction, [x, y], v)
    }
}

/// A drift that nothing pushes, as [`Sticking`]: from `[x, y, vx, vy]` to the new ones.
#[derive(Clone, Copy, Debug)]
pub(super) struct StickingDrift(pub(super) Drift);

impl Kernel<4, 4> for StickingDrift {
    #[inline(always)]
    fn eval<R: Real>(&self, [x, y, vx, vy]: [R; 4]) -> [R; 4] {
        self.0.stick([x, y], [vx, vy])
    }
}

/// A drift that nothing pushes, as [`Sliding`]: from `[x, y, vx, vy]` to the new ones.
#[derive(Clone, Copy, Debug)]
pub(super) struct SlidingDrift {
    pub(super) drift: Drift,
    /// Coefficient of friction.
    pub(super) friction: f64,
}

impl Kernel<4, 4> for SlidingDrift {
    #[inline(always)]
    fn eval<R: Real>(&self, [x, y, vx, vy]: [R; 4]) -> [R; 4] {
        self.drift.slide(self.friction, [x, y], [vx, vy])
    }
}

#[cfg(test)]
mod tests {
    use autodiff::check::{Claim, Options, Verdict, check_directions};
    use autodiff::{Adjoint, Dual};

    use super::{Drift, Flight, Sliding, SlidingDrift, Spring, Sticking, StickingDrift};

    const DT: f64 = 0.002;

    /// The kernel's adjoint, its duals and differences of it, along a fixed cotangent.
    fn verdict<K: Adjoint<I, O>, const I: usize, const O: usize>(
        kernel: &K,
        x: [f64; I],
        wrong_by: f64,
    ) -> Verdict {
        let y_bar: [f64; O] = std::array::from_fn(|k| 1.0 - 0.4 * k as f64);
        let value = |x: &[f64]| {
            let y = kernel.eval::<f64>(std::array::from_fn(|i| x[i]));
            y.iter().zip(y_bar).map(|(y, bar)| y * bar).sum()
        };
        let forward = |direction: &[f64]| {
            let y = kernel.eval::<Dual<f64, 1>>(std::array::from_fn(|i| Dual {
                value: x[i],
                tangent: [direction[i]],
            }));
            y.iter().zip(y_bar).map(|(y, bar)| y.tangent[0] * bar).sum()
        };
        let gradient = kernel.vjp(x, y_bar).map(|bar| bar * (1.0 + wrong_by));
        let forward: Option<autodiff::check::Along> = match wrong_by {
            0.0 => Some(&forward),
            // The differences alone must notice.
            _ => None,
        };
        let claim = Claim {
            x: &x,
            gradient: &gradient,
            forward,
        };
        // An impulse over a mass of grams makes slopes that differ by thousands: the typical one
        // is then the largest alone, and the step must be small beside a time of impact.
        let options = Options {
            directions: 16,
            largest_step: 1e-3,
            ..Options::default()
        };
        let report = check_directions(value, &claim, &options);
        println!("{report}");
        report.verdict
    }

    fn is_right<K: Adjoint<I, O>, const I: usize, const O: usize>(kernel: &K, x: [f64; I]) {
        assert_eq!(verdict(kernel, x, 0.0), Verdict::Smooth);
        assert_eq!(verdict(kernel, x, 0.01), Verdict::Wrong);
    }

    #[test]
    fn springs() {
        let spring = Spring { dt: DT };
        // Stretched, compressed, slack in one direction, and nearly without length.
        for [dx, dy] in [[0.08, 0.09], [-0.05, 0.02], [0.0, 0.1], [2e-3, 1e-3]] {
            is_right(&spring, [dx, dy, 0.3, 4.0, 0.1, 0.35]);
        }
    }

    fn flight() -> Flight {
        Flight {
            drift: Drift { dt: DT },
            decay: (-20.0 * DT).exp(),
            gravity: [-0.003, -0.009],
        }
    }

    /// Nodes `[x, y, vx, vy, jx, jy, 1 / m]` that stay off the ground, that touch it within the
    /// step, and that are under it and leave.
    const NODES: [[f64; 7]; 3] = [
        [0.3, 0.2, 0.4, -0.5, 1e-3, 2e-3, 40.0],
        [0.3, 1e-3, 0.4, -0.9, 1e-3, -2e-3, 40.0],
        [0.3, -2e-3, 0.4, 0.9, 1e-3, 2e-3, 40.0],
    ];

    fn drifting([x, y, vx, vy, ..]: [f64; 7]) -> [f64; 4] {
        [x, y, vx, vy]
    }

    #[test]
    fn free_flight() {
        for node in NODES {
            is_right(&flight(), node);
            is_right(&flight().drift, drifting(node));
        }
    }

    #[test]
    fn infinite_friction() {
        for node in NODES {
            is_right(&Sticking(flight()), node);
            is_right(&StickingDrift(Drift { dt: DT }), drifting(node));
        }
    }

    #[test]
    fn coulomb_friction() {
        // Slides on, stops, and slides without friction.
        for friction in [0.2, 2.5, 0.0] {
            let kernel = Sliding {
                flight: flight(),
                friction,
            };
            let drift = SlidingDrift {
                drift: Drift { dt: DT },
                friction,
            };
            for node in NODES {
                is_right(&kernel, node);
                is_right(&drift, drifting(node));
            }
        }
    }

    /// A node under the ground that moves inward stops where it is: `time_of_impact` is clamped
    /// at 0, and passes nothing (D9).
    #[test]
    fn a_buried_node_keeps_its_place() {
        let buried = [0.3, -1e-3, 0.4, -0.5, 0.0, 0.0, 40.0];
        let by_place = Sticking(flight()).vjp(buried, [0.7, 1.0, 5.0, 5.0]);
        assert_eq!(by_place, [0.7, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(verdict(&Sticking(flight()), buried, 0.0), Verdict::Smooth);
    }
}
