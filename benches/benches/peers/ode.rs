//! Measures the fit of an ODE, which describes hares and lynxes after Lotka and Volterra. The ODE is solved by the
//! classical Runge-Kutta method.

use crate::task::{Task, Way, kept};

/// The length of a time step.
const STEP: f64 = 0.01;
/// The number of steps.
const STEPS: usize = 1000;
/// The number of steps between observations.
const APART: usize = 100;
/// The parameters at which the gradient is taken. The observations were made with other parameters.
const POINT: [f64; 4] = [1.1, 0.4, 0.1, 0.4];
const TRUTH: [f64; 4] = [1.0, 0.5, 0.12, 0.35];
const START: [f64; 2] = [3.0, 1.0];

pub(crate) fn task() -> Task {
    let states = std::iter::successors(Some(START), |&state| Some(primal::step(state, TRUTH)));
    let seen = kept(states.step_by(APART).skip(1).take(STEPS / APART));
    Task {
        title: "Gradient of an ODE fit with respect to four parameters".into(),
        source: include_str!("ode.rs"),
        // The tolerance is for 4000 evaluations with a few roundings each. Perturbations grow with time and amplify the
        // errors.
        tolerance: 1e-11,
        ways: vec![
            Way::new("primal", "", || vec![primal::loss(POINT, seen)]),
            Way::new("ours", "`value_and_gradient_array`", || {
                ours::gradient(seen)
            }),
            Way::new("echidna", "`DualVec64<4>`", || echidna::gradient(seen)),
        ],
    }
}

/// The error of the fit in plain numbers, without a gradient. Its closures are inlined automatically.
mod primal {
    use super::{APART, START, STEP};

    pub(super) fn step([x, y]: [f64; 2], [a, b, c, d]: [f64; 4]) -> [f64; 2] {
        let rate = |[x, y]: [f64; 2]| [a * x - b * x * y, c * x * y - d * y];
        let at = |k: [f64; 2], h: f64| [x + h * k[0], y + h * k[1]];
        let k1 = rate([x, y]);
        let k2 = rate(at(k1, STEP / 2.0));
        let k3 = rate(at(k2, STEP / 2.0));
        let k4 = rate(at(k3, STEP));
        let sum = |i: usize| k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i];
        at([sum(0), sum(1)], STEP / 6.0)
    }

    pub(super) fn loss(p: [f64; 4], seen: &[[f64; 2]]) -> f64 {
        let (mut state, mut loss) = (START, 0.0);
        for &[x, y] in seen {
            for _ in 0..APART {
                state = step(state, p);
            }
            let [dx, dy] = [state[0] - x, state[1] - y];
            loss += dx * dx + dy * dy;
        }
        loss
    }
}

/// The gradient in forward mode: four tangents at once, without a tape. The functions of a step need `#[kernel]`, which
/// closures cannot have.
mod ours {
    use autodiff::{Real, lit, value_and_gradient_array};
    use cosmic::kernel;

    use super::{APART, POINT, START, STEP};

    #[kernel]
    fn rate<R: Real>([x, y]: [R; 2], [a, b, c, d]: [R; 4]) -> [R; 2] {
        [a * x - b * x * y, c * x * y - d * y]
    }

    #[kernel]
    fn along<R: Real>([x, y]: [R; 2], h: f64, k: [R; 2]) -> [R; 2] {
        [x + lit(h) * k[0], y + lit(h) * k[1]]
    }

    #[kernel]
    fn step<R: Real>(state: [R; 2], p: [R; 4]) -> [R; 2] {
        let k1 = rate(state, p);
        let k2 = rate(along(state, STEP / 2.0, k1), p);
        let k3 = rate(along(state, STEP / 2.0, k2), p);
        let k4 = rate(along(state, STEP, k3), p);
        let x = k1[0] + lit(2.0) * (k2[0] + k3[0]) + k4[0];
        let y = k1[1] + lit(2.0) * (k2[1] + k3[1]) + k4[1];
        along(state, STEP / 6.0, [x, y])
    }

    fn loss<R: Real>(p: [R; 4], seen: &[[f64; 2]]) -> R {
        let (mut state, mut loss) = (START.map(R::lit), R::zero());
        for &[x, y] in seen {
            for _ in 0..APART {
                state = step(state, p);
            }
            let [dx, dy] = [state[0] - lit(x), state[1] - lit(y)];
            loss += dx * dx + dy * dy;
        }
        loss
    }

    pub(super) fn gradient(seen: &[[f64; 2]]) -> Vec<f64> {
        let (_, gradient) = value_and_gradient_array(|&p| loss(p, seen), POINT);
        gradient.to_vec()
    }
}

/// The fit, generic over the trait of echidna, as in its "Quick Start", and its gradient in forward mode with four
/// tangents at once.
mod echidna {
    use echidna::{DualVec64, Scalar};

    use super::{APART, POINT, START, STEP};

    fn step<T: Scalar<Float = f64>>([x, y]: [T; 2], [a, b, c, d]: [T; 4]) -> [T; 2] {
        let rate = |[x, y]: [T; 2]| [a * x - b * x * y, c * x * y - d * y];
        let at = |k: [T; 2], h: f64| [x + T::from_f(h) * k[0], y + T::from_f(h) * k[1]];
        let k1 = rate([x, y]);
        let k2 = rate(at(k1, STEP / 2.0));
        let k3 = rate(at(k2, STEP / 2.0));
        let k4 = rate(at(k3, STEP));
        let sum = |i: usize| k1[i] + T::from_f(2.0) * (k2[i] + k3[i]) + k4[i];
        at([sum(0), sum(1)], STEP / 6.0)
    }

    fn loss<T: Scalar<Float = f64>>(p: &[T], seen: &[[f64; 2]]) -> T {
        let (mut state, mut loss) = (START.map(T::from_f), T::from_f(0.0));
        for &[x, y] in seen {
            for _ in 0..APART {
                state = step(state, [p[0], p[1], p[2], p[3]]);
            }
            let [dx, dy] = [state[0] - T::from_f(x), state[1] - T::from_f(y)];
            loss = loss + dx * dx + dy * dy;
        }
        loss
    }

    pub(super) fn gradient(seen: &[[f64; 2]]) -> Vec<f64> {
        let seeded = |i: usize| DualVec64::<4>::with_tangent(POINT[i], i);
        loss(&[0, 1, 2, 3].map(seeded), seen).eps.to_vec()
    }
}
