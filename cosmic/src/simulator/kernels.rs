//! The physics of a step, as kernels: one spring, one bent bar, one node's flight and contact.
//!
//! They work in the ground's frame: first coordinate along the ground, second the height above.

use autodiff::{Kernel, Real};

/// Added to the square of an edge's length, m^2, so that the length is smooth where its nodes
/// coincide (D4).
pub(crate) const SOFTENING: f64 = 1e-12;

/// Hooke's law of an edge whose activation gives it a target length (D8): its impulse on its tail
/// over a step.
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

    #[inline(always)]
    fn vjp<R: Real>(&self, x: [R; 6], y_bar: [R; 2]) -> [R; 6] {
        self.emitted_vjp(x, y_bar)
    }
}

/// A spring that grows stiffer as it is stretched or compressed: `k (e + c e^3)` for a change of
/// length `e` (m) from the target. Numbers as for [`Spring`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Stiffening {
    /// The spring by Hooke's law.
    pub(super) spring: Spring,
    /// The cubic coefficient `c`, 1/m^2.
    pub(super) cubic: f64,
}

impl Kernel<6, 2> for Stiffening {
    #[inline(always)]
    fn eval<R: Real>(&self, [dx, dy, u, stiffness, rest_length, strain]: [R; 6]) -> [R; 2] {
        let length = dx.fma(dx, dy.fma(dy, R::lit(SOFTENING))).sqrt();
        let change = length - rest_length * strain.fma(u, R::one());
        let growth = (R::lit(self.cubic) * change).fma(change, R::one());
        let per_length = stiffness * change * growth * R::lit(self.spring.dt) / length;
        [per_length * dx, per_length * dy]
    }

    #[inline(always)]
    fn vjp<R: Real>(&self, x: [R; 6], y_bar: [R; 2]) -> [R; 6] {
        self.emitted_vjp(x, y_bar)
    }
}

/// An angular spring between two edges that are in line when it is at ease: a torque `c sin(a)`
/// where the path over the three nodes turns by the angle `a`, of the energy `c (1 - cos(a))`.
/// Smooth at every angle; the resistance fades beyond a right one.
///
/// From the three nodes' coordinates (m) and `c` (N m) to the impulses on them (N s).
#[derive(Clone, Copy, Debug)]
pub(super) struct Bend {
    /// Length of a step, s.
    pub(super) dt: f64,
}

impl Kernel<7, 6> for Bend {
    #[inline(always)]
    fn eval<R: Real>(&self, [x0, y0, x1, y1, x2, y2, stiffness]: [R; 7]) -> [R; 6] {
        let unit = |dx: R, dy: R| {
            let inverse = dx.fma(dx, dy.fma(dy, R::lit(SOFTENING))).sqrt().recip();
            (dx * inverse, dy * inverse, inverse)
        };
        let (ax, ay, per_a) = unit(x1 - x0, y1 - y0);
        let (bx, by, per_b) = unit(x2 - x1, y2 - y1);
        let torque = stiffness * (ax * by - ay * bx) * R::lit(self.dt);
        // A torque on an arm is a force across its end; the middle node takes both reactions.
        let (first, last) = (torque * per_a, torque * per_b);
        let [fx, fy, lx, ly] = [first * ay, -(first * ax), last * by, -(last * bx)];
        [fx, fy, -(fx + lx), -(fy + ly), lx, ly]
    }

    #[inline(always)]
    fn vjp<R: Real>(&self, x: [R; 7], y_bar: [R; 6]) -> [R; 7] {
        self.emitted_vjp(x, y_bar)
    }
}

/// A sum of five.
#[derive(Clone, Copy, Debug)]
pub(super) struct Total;

impl Kernel<5, 1> for Total {
    #[inline(always)]
    fn eval<R: Real>(&self, [a, b, c, d, e]: [R; 5]) -> [R; 1] {
        [a + b + (c + d) + e]
    }

    #[inline(always)]
    fn vjp<R: Real>(&self, x: [R; 5], y_bar: [R; 1]) -> [R; 5] {
        self.emitted_vjp(x, y_bar)
    }
}

/// A node on its way over a time, and the ground that it may meet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drift {
    /// For how long, s.
    pub(super) dt: f64,
}

impl Drift {
    /// Whether a node at this height (m) touches the ground on its way, and the time of impact (s),
    /// which passes no derivative at its bounds 0 and `dt` (D9). A node that does not touch gets
    /// the whole time. `v* = 0` never touches: nothing is divided by zero.
    #[inline(always)]
    fn touch<R: Real>(&self, height: R, v_normal: R) -> (R::Mask, R) {
        let (zero, dt) = (R::zero(), R::lit(self.dt));
        let touches = dt.fma(v_normal, height).lt(zero) & v_normal.lt(zero);
        let approach = R::select(touches, v_normal, -R::one());
        let time_of_impact = (-height / approach).clamp(zero, dt);
        (touches, R::select(touches, time_of_impact, dt))
    }

    /// Where a node gets that stops where it touches: its new `[x, y, vx, vy]`.
    #[inline(always)]
    fn stick<R: Real>(&self, [x, y]: [R; 2], [vx, vy]: [R; 2]) -> [R; 4] {
        let (touches, moving) = self.touch(y, vy);
        let after = |v: R| R::select(touches, R::zero(), v);
        [moving.fma(vx, x), moving.fma(vy, y), after(vx), after(vy)]
    }

    /// Place and velocity of a node that friction brakes along the ground but never reverses (D5).
    #[inline(always)]
    fn slide<R: Real>(&self, friction: f64, [x, y]: [R; 2], [vx, vy]: [R; 2]) -> [R; 4] {
        let (touches, moving) = self.touch(y, vy);
        let friction = R::lit(friction);
        let left = vx.abs() - friction * vy.abs();
        let braked = vx.signum() * left.max(R::zero());
        // Without friction nothing holds a node at rest: no kink is there, and no derivative of
        // one.
        let braked = R::select(R::zero().lt(friction), braked, vx);
        let rest = R::lit(self.dt) - moving;
        [
            moving.fma(vx, x) + R::select(touches, rest * braked, R::zero()),
            moving.fma(vy, y),
            R::select(touches, braked, vx),
            R::select(touches, R::zero(), vy),
        ]
    }
}

/// The change of a velocity before its node drifts. As a kernel: a step of a node where there is no
/// ground; numbers as for [`Sticking`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Flight {
    /// The drift that follows.
    pub(super) drift: Drift,
    /// The share of a velocity that damping leaves, `exp(-damping h)`.
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
        let [vx, vy] = self.velocity([vx, vy], [jx, jy], inverse_mass);
        let dt = R::lit(self.drift.dt);
        [dt.fma(vx, x), dt.fma(vy, y), vx, vy]
    }

    #[inline(always)]
    fn vjp<R: Real>(&self, x: [R; 7], y_bar: [R; 4]) -> [R; 7] {
        self.emitted_vjp(x, y_bar)
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

    #[inline(always)]
    fn vjp<R: Real>(&self, x: [R; 7], y_bar: [R; 4]) -> [R; 7] {
        self.emitted_vjp(x, y_bar)
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

    #[inline(always)]
    fn vjp<R: Real>(&self, x: [R; 7], y_bar: [R; 4]) -> [R; 7] {
        self.emitted_vjp(x, y_bar)
    }
}

/// A drift that nothing pushes where there is no ground: from `[x, y, vx, vy]` to the new ones.
#[derive(Clone, Copy, Debug)]
pub(super) struct FreeDrift(pub(super) Drift);

impl Kernel<4, 4> for FreeDrift {
    #[inline(always)]
    fn eval<R: Real>(&self, [x, y, vx, vy]: [R; 4]) -> [R; 4] {
        let dt = R::lit(self.0.dt);
        [dt.fma(vx, x), dt.fma(vy, y), vx, vy]
    }

    #[inline(always)]
    fn vjp<R: Real>(&self, x: [R; 4], y_bar: [R; 4]) -> [R; 4] {
        self.emitted_vjp(x, y_bar)
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

    #[inline(always)]
    fn vjp<R: Real>(&self, x: [R; 4], y_bar: [R; 4]) -> [R; 4] {
        self.emitted_vjp(x, y_bar)
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

    #[inline(always)]
    fn vjp<R: Real>(&self, x: [R; 4], y_bar: [R; 4]) -> [R; 4] {
        self.emitted_vjp(x, y_bar)
    }
}

#[cfg(test)]
mod tests {
    use autodiff::check::{Claim, Options, Verdict, check_directions};
    use autodiff::{Dual, Function, Kernel, Real, gradient};

    use super::{
        Bend, Drift, Flight, FreeDrift, Sliding, SlidingDrift, Spring, Sticking, StickingDrift,
        Stiffening,
    };

    const DT: f64 = 0.002;

    /// The kernel's adjoint, its duals and differences of it, along a fixed cotangent.
    fn verdict<K: Kernel<I, O>, const I: usize, const O: usize>(
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

    fn is_right<K: Kernel<I, O>, const I: usize, const O: usize>(kernel: &K, x: [f64; I]) {
        assert_eq!(verdict(kernel, x, 0.0), Verdict::Smooth);
        assert_eq!(verdict(kernel, x, 0.01), Verdict::Wrong);
    }

    #[test]
    fn springs() {
        let spring = Spring { dt: DT };
        let cubic = 150.0;
        // Stretched, compressed, slack in one direction, and nearly without length.
        for [dx, dy] in [[0.08, 0.09], [-0.05, 0.02], [0.0, 0.1], [2e-3, 1e-3]] {
            let given = [dx, dy, 0.3, 4.0, 0.1, 0.35];
            is_right(&spring, given);
            is_right(&Stiffening { spring, cubic }, given);
        }
    }

    /// Nodes in line, turned a little, at a right angle, folded back, and of uneven arms.
    const TURNS: [[f64; 6]; 5] = [
        [0.0, 0.0, 0.1, 0.0, 0.2, 0.0],
        [0.0, 0.0, 0.1, 0.01, 0.2, 0.0],
        [0.0, 0.0, 0.1, 0.0, 0.1, 0.1],
        [0.0, 0.0, 0.1, 0.0, 0.01, 0.005],
        [0.3, 0.2, 0.1, 0.1, -0.4, 0.3],
    ];

    #[test]
    fn bending() {
        // In line, the cotangent above, which is linear along the nodes, is met by no slope.
        for [a, b, c, d, e, f] in TURNS[1..].iter().copied() {
            is_right(&Bend { dt: DT }, [a, b, c, d, e, f, 0.04]);
        }
    }

    /// The energy of the angular spring, as a function of the three nodes.
    struct Energy;

    impl Function for Energy {
        fn eval<R: Real>(&self, x: &[R]) -> R {
            let [ax, ay] = [x[2] - x[0], x[3] - x[1]];
            let [bx, by] = [x[4] - x[2], x[5] - x[3]];
            let lengths = (ax * ax + ay * ay).sqrt() * (bx * bx + by * by).sqrt();
            R::lit(0.04) * (R::one() - (ax * bx + ay * by) / lengths)
        }
    }

    #[test]
    fn the_forces_of_bending_are_the_energy_s_slope() {
        for nodes in TURNS {
            let [a, b, c, d, e, f] = nodes;
            let pulls = Bend { dt: 1.0 }.eval([a, b, c, d, e, f, 0.04]);
            let slope = gradient(&Energy, &nodes);
            for (pull, slope) in pulls.iter().zip(slope) {
                // Softening moves a length of 0.1 by a share of 5e-11; forces are below 1 N.
                assert!((pull + slope).abs() < 1e-9, "{pulls:?}");
            }
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
            is_right(&FreeDrift(Drift { dt: DT }), drifting(node));
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

    /// Friction holds a node that is at rest, so that nothing passes (D9); without friction nothing
    /// holds it.
    #[test]
    fn coulomb_friction_at_rest() {
        let resting = [0.3, 1e-3, 0.0, -0.9];
        let drift = |friction| SlidingDrift {
            drift: Drift { dt: DT },
            friction,
        };
        is_right(&drift(0.2), resting);
        is_right(&drift(0.0), resting);
        let by_velocity = |friction| drift(friction).vjp(resting, [0.0, 0.0, 1.0, 0.0])[2];
        assert_eq!([0.2, 0.0].map(by_velocity), [0.0, 1.0]);
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
