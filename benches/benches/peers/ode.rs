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
        about: "Lotka and Volterra's equations, 1000 steps of the classical Runge-Kutta method, squared errors at \
                ten times. Ratios are to the primal in f64.",
        source: include_str!("ode.rs"),
        // The tolerance is for 4000 evaluations with a few roundings each. Perturbations grow with time and amplify the
        // errors.
        tolerance: 1e-11,
        ways: vec![
            Way::new("primal", "", &["primal"], || {
                vec![primal::loss(POINT, seen)]
            }),
            Way::new(
                "ours",
                "`value_and_gradient_array`",
                &["ours_step", "ours_fit", "ours_forward"],
                || ours_forward::gradient(seen),
            ),
            Way::new(
                "ours",
                "`gradient`",
                &["ours_step", "ours_fit", "ours_tape"],
                || ours_tape::gradient(seen),
            ),
            Way::new(
                "ours",
                "`gradient` a `Rollout`",
                &["ours_step", "ours_rollout"],
                || ours_rollout::gradient(seen),
            ),
            Way::new(
                "echidna",
                "`DualVec64<4>`",
                &["echidna", "echidna_forward"],
                || echidna_forward::gradient(seen),
            ),
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

/// One time step, as a kernel uses it. All functions need `#[kernel]`, which closures cannot have.
mod ours_step {
    use autodiff::{Real, lit};
    use cosmic::kernel;

    use super::STEP;

    #[kernel]
    fn rate<R: Real>([x, y]: [R; 2], [a, b, c, d]: [R; 4]) -> [R; 2] {
        [a * x - b * x * y, c * x * y - d * y]
    }

    #[kernel]
    fn along<R: Real>([x, y]: [R; 2], h: f64, k: [R; 2]) -> [R; 2] {
        [x + lit(h) * k[0], y + lit(h) * k[1]]
    }

    #[kernel]
    pub(super) fn step<R: Real>(state: [R; 2], p: [R; 4]) -> [R; 2] {
        let k1 = rate(state, p);
        let k2 = rate(along(state, STEP / 2.0, k1), p);
        let k3 = rate(along(state, STEP / 2.0, k2), p);
        let k4 = rate(along(state, STEP, k3), p);
        let x = k1[0] + lit(2.0) * (k2[0] + k3[0]) + k4[0];
        let y = k1[1] + lit(2.0) * (k2[1] + k3[1]) + k4[1];
        along(state, STEP / 6.0, [x, y])
    }
}

/// The error of the fit as a function for any driver.
mod ours_fit {
    use autodiff::{Function, Real, lit};

    use super::{APART, START, ours_step::step};

    pub(super) struct Fit<'a>(pub(super) &'a [[f64; 2]]);

    impl Function for Fit<'_> {
        fn eval<R: Real>(&self, p: &[R]) -> R {
            let (mut state, mut loss) = (START.map(R::lit), R::zero());
            for &[x, y] in self.0 {
                for _ in 0..APART {
                    state = step(state, [p[0], p[1], p[2], p[3]]);
                }
                let [dx, dy] = [state[0] - lit(x), state[1] - lit(y)];
                loss += dx * dx + dy * dy;
            }
            loss
        }
    }
}

/// The gradient in forward mode: four tangents at once, without a tape.
mod ours_forward {
    use autodiff::{Function, value_and_gradient_array};

    use super::{POINT, ours_fit::Fit};

    pub(super) fn gradient(seen: &[[f64; 2]]) -> Vec<f64> {
        let (_, gradient) = value_and_gradient_array(|x| Fit(seen).eval(x), POINT);
        gradient.to_vec()
    }
}

/// The gradient by one reverse sweep over a recording of all steps.
mod ours_tape {
    use autodiff::Function;

    use super::{POINT, ours_fit::Fit};

    pub(super) fn gradient(seen: &[[f64; 2]]) -> Vec<f64> {
        autodiff::gradient(|x| Fit(seen).eval(x), &POINT)
    }
}

/// The gradient by a rollout. The step is a kernel and is recorded once.
mod ours_rollout {
    use autodiff::{Kernel, Model, Program, Real, Rollout, Var};
    use cosmic::kernel;

    use super::{APART, POINT, START, STEPS, ours_step::step};

    #[derive(Clone)]
    struct Populations;

    #[kernel]
    impl Kernel<6, 2> for Populations {
        fn eval<R: Real>(&self, [x, y, a, b, c, d]: [R; 6], _: &[R]) -> [R; 2] {
            step([x, y], [a, b, c, d])
        }
    }

    impl Model for Populations {
        fn record(&self, program: &mut Program) {
            let [a, b, c, d] = [(); 4].map(|()| program.parameter(1));
            let [x, y] = [(); 2].map(|()| program.state(1));
            let next = program.map(Populations, [x, y, a, b, c, d], &[]);
            program.advance(x, next[0]);
            program.advance(y, next[1]);
        }
    }

    pub(super) fn gradient(seen: &[[f64; 2]]) -> Vec<f64> {
        let rollout = Rollout {
            observed: (APART..=STEPS).step_by(APART).collect(),
            ..Rollout::new(Populations, STEPS)
        };
        let loss = |p: &[Var<f64>]| {
            let parameters: Vec<_> = p.chunks(1).collect();
            let states = rollout.run(&START.map(Var::lit), &parameters);
            let gaps = states.iter().zip(seen.as_flattened());
            gaps.map(|(&x, &seen)| (x - seen).powi(2)).sum()
        };
        autodiff::gradient(loss, &POINT)
    }
}

/// The fit, generic over the trait of echidna, as in its "Quick Start".
mod echidna {
    use echidna::Scalar;

    use super::{APART, START, STEP};

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

    pub(super) fn loss<T: Scalar<Float = f64>>(p: &[T], seen: &[[f64; 2]]) -> T {
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
}

/// The gradient in echidna's forward mode, with four tangents at once.
mod echidna_forward {
    use echidna::DualVec64;

    use super::{POINT, echidna::loss};

    pub(super) fn gradient(seen: &[[f64; 2]]) -> Vec<f64> {
        let seeded = |i: usize| DualVec64::<4>::with_tangent(POINT[i], i);
        loss(&[0, 1, 2, 3].map(seeded), seen).eps.to_vec()
    }
}
