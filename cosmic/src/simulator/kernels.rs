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

/// How a node moves in a step that does not reach the ground.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flight {
    /// Length of a step, s.
    pub(super) dt: f64,
    /// What is left of a velocity after a step: `exp(-damping dt)`.
    pub(super) decay: f64,
    /// Velocity that gravity adds in a step, along the ground and across it, m/s.
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

    /// Whether a node at this height touches the ground in this step, and when. A node that does
    /// not touch gets the whole step. `v* = 0` never touches: nothing is divided by zero.
    #[inline(always)]
    fn touch<R: Real>(&self, height: R, v_normal: R) -> (R::Mask, R) {
        let (zero, dt) = (R::zero(), R::lit(self.dt));
        let touches = dt.fma(v_normal, height).lt(zero) & v_normal.lt(zero);
        let approach = R::select(touches, v_normal, -R::one());
        let time_of_impact = (-height / approach).clamp(zero, dt);
        (touches, R::select(touches, time_of_impact, dt))
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
        let [vx, vy] = self.0.velocity([vx, vy], [jx, jy], inverse_mass);
        let (touches, moving) = self.0.touch(y, vy);
        let after = |v: R| R::select(touches, R::zero(), v);
        [moving.fma(vx, x), moving.fma(vy, y), after(vx), after(vy)]
    }
}

/// A step of a node under Coulomb friction: it stops across the ground and is braked along it,
/// but never reversed (D5). Numbers as for [`Sticking`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Sliding {
    pub(super) flight: Flight,
    /// Coefficient of friction.
    pub(super) friction: f64,
}

impl Kernel<7, 4> for Sliding {
    #[inline(always)]
    fn eval<R: Real>(&self, [x, y, vx, vy, jx, jy, inverse_mass]: [R; 7]) -> [R; 4] {
        let [vx, vy] = self.flight.velocity([vx, vy], [jx, jy], inverse_mass);
        let (touches, moving) = self.flight.touch(y, vy);
        let left = vx.abs() - R::lit(self.friction) * vy.abs();
        let braked = vx.signum() * left.max(R::zero());
        let rest = R::lit(self.flight.dt) - moving;
        [
            moving.fma(vx, x) + R::select(touches, rest * braked, R::zero()),
            moving.fma(vy, y),
            R::select(touches, braked, vx),
            R::select(touches, R::zero(), vy),
        ]
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use autodiff::emit::adjoint;

    use super::{Flight, Sliding, Spring, Sticking};

    const HEADER: &str = "\
//! Adjoints of the kernels, emitted from recordings of them: not to be edited. After a change of
//! a kernel: `EMIT=1 cargo test -p cosmic --lib adjoints_are_fresh`.

use autodiff::{Adjoint, Real};

use super::kernels::{Sliding, Spring, Sticking};
";

    fn flight(values: &[f64]) -> Flight {
        Flight {
            dt: values[0],
            decay: values[1],
            gravity: [values[2], values[3]],
        }
    }

    fn emitted() -> String {
        let sticking = ["dt", "decay", "gravity[0]", "gravity[1]"].map(|f| format!("self.0.{f}"));
        let sticking = sticking.each_ref().map(String::as_str);
        let sliding = [
            "flight.dt",
            "flight.decay",
            "flight.gravity[0]",
            "flight.gravity[1]",
        ];
        let sliding = [&sliding[..], &["friction"]].concat();
        let sliding: Vec<String> = sliding.iter().map(|f| format!("self.{f}")).collect();
        let sliding: Vec<&str> = sliding.iter().map(String::as_str).collect();
        let parts = [
            adjoint("Spring", &["self.dt"], |v| Spring { dt: v[0] }),
            adjoint("Sticking", &sticking, |v| Sticking(flight(v))),
            adjoint("Sliding", &sliding, |v| Sliding {
                flight: flight(v),
                friction: v[4],
            }),
        ];
        [HEADER, &parts.join("\n")].join("\n")
    }

    #[test]
    fn adjoints_are_fresh() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/simulator/adjoints.rs");
        let emitted = emitted();
        if std::env::var_os("EMIT").is_some() {
            std::fs::write(&path, &emitted).expect("the source folder can be written");
        }
        let checked_in = std::fs::read_to_string(&path).expect("the adjoints are checked in");
        assert!(
            checked_in == emitted,
            "the kernels have changed: see the head of {path:?}"
        );
    }
}
