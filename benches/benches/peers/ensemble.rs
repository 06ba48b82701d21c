//! Measures a task with many rollouts: one small network brings pendulums to rest from many starts. It computes a torque
//! from angle and speed. The gradient is that of the sum of squared final states with respect to all weights.

use crate::task::{Task, Way, kept};

/// The number of starts.
const STARTS: usize = 64;
/// The number of steps.
const STEPS: usize = 100;
/// The length of a time step.
const STEP: f64 = 0.05;
/// The number of hidden units of the network.
const HIDDEN: usize = 16;
/// The number of parameters of the network: the weights from angle and speed to the hidden units, their biases, the
/// weights to the torque, and its bias.
const WEIGHTS: usize = 2 * HIDDEN + HIDDEN + HIDDEN + 1;

pub(crate) fn task() -> Task {
    let number = |i: usize| (0.618_033_988 * (i as f64 + 1.0)).fract() - 0.5;
    let w = kept((0..WEIGHTS).map(number));
    let starts: &'static [[f64; 2]] = kept((0..STARTS).map(|i| [number(i), number(i + STARTS)]));
    Task {
        title: format!("Gradient of an ensemble: {STARTS} rollouts of a pendulum under a network"),
        source: include_str!("ensemble.rs"),
        // The tolerance is for sums of 6400 terms in a different order. The crate's tanh differs from the system's by a
        // rounding.
        tolerance: 1e-11,
        ways: vec![
            Way::new("primal", "", || {
                vec![starts.iter().map(|s| primal::end(w, *s)).sum()]
            }),
            Way::new("ours", "`Rollout::run_batch`", || ours::gradient(w, starts)),
            Way::new("reverse", "a tape, one by one", || {
                reverse::gradient(w, starts)
            }),
        ],
    }
}

/// A rollout in plain numbers, with the system's tanh.
mod primal {
    use super::{HIDDEN, STEP, STEPS};

    pub(super) fn end(w: &[f64], [mut angle, mut speed]: [f64; 2]) -> f64 {
        let (w1, rest) = w.split_at(2 * HIDDEN);
        let (b1, rest) = rest.split_at(HIDDEN);
        for _ in 0..STEPS {
            let hidden = |i: usize| (w1[2 * i] * angle + w1[2 * i + 1] * speed + b1[i]).tanh();
            let torque = (0..HIDDEN).map(|i| rest[i] * hidden(i)).sum::<f64>() + rest[HIDDEN];
            speed += STEP * (torque - angle.sin());
            angle += STEP * speed;
        }
        angle * angle + speed * speed
    }
}

/// A rollout whose step is recorded once. The starts run in lanes.
mod ours {
    use autodiff::{Real, Var, lit};
    use autodiff_programs::{Given, Kernel, Model, Program, Rollout};
    use cosmic::kernel;

    use super::{HIDDEN, STEP, STEPS};

    #[derive(Clone)]
    struct Pendulum;

    #[kernel]
    impl Kernel<3, 2> for Pendulum {
        fn eval<R: Real>(&self, [angle, speed, torque]: [R; 3], _: &[R]) -> [R; 2] {
            let speed = speed + lit(STEP) * (torque - angle.sin());
            [angle + lit(STEP) * speed, speed]
        }
    }

    impl Model for Pendulum {
        fn record(&self, program: &mut Program) {
            let (w1, b1) = (program.matrix(HIDDEN, 2), program.parameter(HIDDEN));
            let (w2, b2) = (program.matrix(1, HIDDEN), program.parameter(1));
            let (angle, speed) = (program.state(1), program.state(1));
            let hidden = program.dense_tanh(w1, &[angle, speed], b1);
            let torque = program.dense(w2, &[hidden], b2);
            let next = program.map(Pendulum, [angle, speed, torque], &[]);
            program.advance(angle, next[0]);
            program.advance(speed, next[1]);
        }
    }

    pub(super) fn gradient(w: &[f64], starts: &[[f64; 2]]) -> Vec<f64> {
        let rollout = Rollout::new(Pendulum, STEPS);
        let loss = |w: &[Var<f64>]| {
            let (w1, rest) = w.split_at(2 * HIDDEN);
            let (b1, rest) = rest.split_at(HIDDEN);
            let (w2, b2) = rest.split_at(HIDDEN);
            let starts: Vec<[Var<f64>; 2]> = starts.iter().map(|s| s.map(Var::lit)).collect();
            let starts: Vec<&[Var<f64>]> = starts.iter().map(|start| &start[..]).collect();
            let ends = rollout.run_batch(&starts, &[w1, b1, w2, b2].map(Given::Shared));
            ends.iter().flatten().map(|&x| x * x).sum()
        };
        autodiff::gradient(loss, w)
    }
}

/// A rollout on the tape of the crate `reverse`. The tape is cleared between starts.
mod reverse {
    use reverse::{Gradient, Tape, Var};

    use super::{HIDDEN, STEP, STEPS};

    fn end<'a>(w: &[Var<'a>], start: [f64; 2]) -> Var<'a> {
        let (w1, rest) = w.split_at(2 * HIDDEN);
        let (b1, rest) = rest.split_at(HIDDEN);
        let [mut angle, mut speed] = start.map(|x| w[0].tape.add_var(x));
        for _ in 0..STEPS {
            let hidden = |i: usize| (w1[2 * i] * angle + w1[2 * i + 1] * speed + b1[i]).tanh();
            let torque = (0..HIDDEN).map(|i| rest[i] * hidden(i)).sum::<Var<'_>>() + rest[HIDDEN];
            speed = speed + STEP * (torque - angle.sin());
            angle = angle + STEP * speed;
        }
        angle * angle + speed * speed
    }

    pub(super) fn gradient(w: &[f64], starts: &[[f64; 2]]) -> Vec<f64> {
        let tape = Tape::new();
        let mut sum = vec![0.0; w.len()];
        for &start in starts {
            tape.clear();
            let w = tape.add_vars(w);
            let gradient = end(&w, start).grad().wrt(&w);
            sum.iter_mut().zip(gradient).for_each(|(sum, g)| *sum += g);
        }
        sum
    }
}
