//! Controls: parameters that have a different value in every step.

use crate::common::assert_refused;
use crate::net::taken_from;
use autodiff::{
    Dual, Function, Given, Kernel, Memory, Model, Program, Real, Rollout, Var, gradient, kernel,
};

const MASSES: usize = 5;
const STEPS: usize = 23;

/// A mass on a spring, pushed by a force of its own and by a wind that all masses share.
#[derive(Clone, Copy)]
struct Pushed;

#[kernel]
impl Kernel<5, 2> for Pushed {
    fn eval<R: Real>(&self, [x, v, stiffness, force, wind]: [R; 5], _: &[R]) -> [R; 2] {
        let v = v + R::lit(0.05) * (force + wind * v - stiffness * x * x * x);
        [x + R::lit(0.05) * v, v]
    }
}

#[derive(Clone, Copy)]
struct Masses;

impl Model for Masses {
    fn record(&self, program: &mut Program) {
        let stiffness = program.parameter(MASSES);
        let [x, v] = [(); 2].map(|()| program.state(MASSES));
        let [force, wind] = [MASSES, 1].map(|len| program.control(len));
        let wind = program.gather(wind, &[Some(0); MASSES]);
        let next = program.map(Pushed, [x, v, stiffness, force, wind], &[]);
        for (state, next) in [x, v].into_iter().zip(next) {
            program.advance(state, next);
        }
    }
}

/// The lengths of the parts of the argument: the start, the stiffnesses, the forces and the winds.
const LENGTHS: [usize; 4] = [2 * MASSES, MASSES, STEPS * MASSES, STEPS];

fn parts<T>(x: &[T]) -> [&[T]; 4] {
    LENGTHS.map(taken_from(x))
}

fn point(k: usize) -> Vec<f64> {
    let wave = |i: usize| 0.5 + 0.4 * ((i * 3 + k) as f64).sin();
    (0..LENGTHS.iter().sum()).map(wave).collect()
}

/// The loss: the sum of the squares of the states in the middle and at the end of a rollout.
#[derive(Clone, Copy, Default)]
struct Squares(Memory);

impl Squares {
    fn rollout(self) -> Rollout<Masses> {
        Rollout {
            observed: vec![STEPS / 2, STEPS],
            memory: self.0,
            ..Rollout::new(Masses, STEPS)
        }
    }
}

impl Function for Squares {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let [start, parameters @ ..] = parts(x);
        let seen = self.rollout().run(start, &parameters);
        R::dot(&seen, &seen)
    }
}

/// The loss of [`Squares`], computed step by step with scalar operations.
fn in_scalars<R: Real>(x: &[R]) -> R {
    let [start, stiffness, forces, winds] = parts(x);
    let (mut x, mut v) = (start[..MASSES].to_vec(), start[MASSES..].to_vec());
    let mut squares = R::zero();
    for step in 0..STEPS {
        for i in 0..MASSES {
            let force = forces[step * MASSES + i];
            [x[i], v[i]] = Pushed.eval([x[i], v[i], stiffness[i], force, winds[step]], &[]);
        }
        if [STEPS / 2, STEPS].contains(&(step + 1)) {
            squares += R::dot(&x, &x) + R::dot(&v, &v);
        }
    }
    squares
}

#[test]
fn gradients_are_those_of_scalars_and_of_duals() {
    let x = point(0);
    let by_rollout = gradient(|x| Squares::default().eval(x), &x);
    let by_tape = gradient(in_scalars::<Var<f64>>, &x);
    for i in 0..x.len() {
        let lifted = |(k, &x): (usize, &f64)| Dual::<f64, 1> {
            value: x,
            tangent: [f64::from(u8::from(k == i))],
        };
        let lifted: Vec<_> = x.iter().enumerate().map(lifted).collect();
        let [forward] = Squares::default().eval(&lifted).tangent;
        // Both gradients are sums of a few hundred terms of magnitude 1.
        assert!((by_rollout[i] - by_tape[i]).abs() < 1e-13, "{i}");
        assert!((by_rollout[i] - forward).abs() < 1e-13, "{i}");
        assert!(by_rollout[i] != 0.0, "{i}");
    }
}

#[test]
fn little_memory_gives_the_same_bits() {
    let x = point(1);
    let few = Squares(Memory::States(16));
    assert_eq!(
        gradient(|x| few.eval(x), &x),
        gradient(|x| Squares::default().eval(x), &x)
    );
}

/// A batch must give the same results as single runs, whether the controls are shared or each start has its own.
#[test]
fn a_batch_of_starts_equals_single_runs() {
    for count in [1, 2, 3, 8, 11] {
        let points: Vec<Vec<f64>> = (0..count).map(point).collect();
        let alone = |own: bool| {
            let gradient_at = |x: &Vec<f64>| {
                let shared = |i| if own { x[i] } else { points[0][i] };
                let controls = LENGTHS[0] + LENGTHS[1]..x.len();
                let x = [
                    &x[..controls.start],
                    &controls.map(shared).collect::<Vec<_>>(),
                ]
                .concat();
                gradient(|x| Squares::default().eval(x), &x)
            };
            points.iter().map(gradient_at).collect::<Vec<_>>()
        };
        let together = |own: bool| {
            let of_all = |x: &[Var<f64>]| {
                let models: Vec<_> = x.chunks(points[0].len()).map(parts).collect();
                let each = [0, 1, 2, 3].map(|k| models.iter().map(|m| m[k]).collect::<Vec<_>>());
                let [starts, stiffness, forces, winds] = each.each_ref().map(Vec::as_slice);
                let controls = if own {
                    [Given::Each(forces), Given::Each(winds)]
                } else {
                    [Given::Shared(forces[0]), Given::Shared(winds[0])]
                };
                let given = [&[Given::Each(stiffness)][..], &controls].concat();
                let seen = Squares::default().rollout().run_batch(starts, &given);
                let squares: Vec<Var<f64>> = seen.iter().map(|seen| Var::dot(seen, seen)).collect();
                Var::sum_of(&squares)
            };
            gradient(of_all, &points.concat())
        };
        assert_eq!(together(true), alone(true).concat(), "{count}");
        let (together, alone) = (together(false), alone(false));
        let len = points[0].len();
        let controls = LENGTHS[0] + LENGTHS[1];
        for (k, alone) in alone.iter().enumerate() {
            assert_eq!(together[k * len..][..controls], alone[..controls]);
        }
        for i in controls..len {
            let sum: f64 = alone.iter().map(|alone| alone[i]).sum();
            // The two results add the same terms in a different order.
            assert!((together[i] - sum).abs() < 1e-13 * count as f64, "{i}");
        }
    }
}

/// Controls that are constants must get no cotangent. The cotangents of the other controls must not change.
#[test]
fn controls_may_be_constants() {
    let x = point(2);
    let all = gradient(|x| Squares::default().eval(x), &x);
    let [start, rest] = [&x[..2 * MASSES], &x[2 * MASSES..]];
    let of_start = |start: &[Var<f64>]| {
        let rest: Vec<Var<f64>> = rest.iter().map(|&x| Var::constant(x)).collect();
        Squares::default().eval(&[start, &rest[..]].concat())
    };
    assert_eq!(gradient(of_start, start), all[..2 * MASSES]);
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn controls_for_other_steps_are_told() {
    let x = point(0);
    let [start, stiffness, forces, winds] = parts(&x);
    let few = &forces[MASSES..];
    assert_refused("over 23 steps, but ", || {
        (Squares::default().rollout()).run(start, &[stiffness, few, winds])
    });
    // So many steps have more controls than memory could hold.
    let steps = 1 << (usize::BITS - 1);
    let sentence = format!(
        "{} numbers over {steps} steps, but 0 were given",
        usize::MAX
    );
    assert_refused(&sentence, || {
        Rollout::new(Masses, steps).run(start, &[stiffness, &[], &[]])
    });
}
