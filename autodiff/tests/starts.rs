//! Several starts at once must give the same results as single starts.

use autodiff::{
    CotangentBound, Dual, Function, Given, Kernel, Memory, Model, Program, Real, Rollout, Tape,
    Var, gradient, kernel, value_and_gradient,
};
use num_traits::Zero;

use crate::common::assert_refused;
use crate::net::{Loss, NODES, taken_from};

/// A batch: starts that are close to each other, and their parameters.
struct Several<R> {
    loss: Loss,
    starts: Vec<Vec<R>>,
    /// The stiffnesses of each start, which replace parameter 0. Empty if all starts share parameter 0.
    own: Vec<Vec<R>>,
    parameters: Vec<Vec<R>>,
}

impl<R: Real> Several<R> {
    fn new(count: usize, steps: usize) -> Self {
        let loss = Loss::new(steps);
        let x: Vec<R> = loss.point().into_iter().map(R::lit).collect();
        let (start, rest) = x.split_at(2 * NODES);
        let moved = |k: usize| {
            let by = |i: usize| R::lit(0.1 * ((k * NODES + i) as f64).cos());
            (start.iter().enumerate())
                .map(|(i, &x)| x + by(i))
                .collect()
        };
        let mut take = taken_from(rest);
        let shapes = loss.rollout.model.shapes();
        Self {
            starts: (0..count).map(moved).collect(),
            own: Vec::new(),
            parameters: shapes.map(|len| take(len).to_vec()).to_vec(),
            loss,
        }
    }

    /// Gives each start its own stiffnesses.
    fn with_own(mut self) -> Self {
        let times = |factor: f64| {
            let stiffness = self.parameters[0].iter();
            stiffness.map(|&k| k * R::lit(factor)).collect()
        };
        let factors = (0..self.starts.len()).map(|k| 1.0 + 0.3 * k as f64);
        self.own = factors.map(times).collect();
        self
    }

    fn alone(&self) -> Vec<Vec<R>> {
        let run = |(k, start): (usize, &Vec<R>)| {
            let mut parameters = slices(&self.parameters);
            if let Some(own) = self.own.get(k) {
                parameters[0] = own;
            }
            self.loss.rollout.run(start, &parameters)
        };
        self.starts.iter().enumerate().map(run).collect()
    }

    fn together(&self) -> Vec<Vec<R>> {
        let (starts, own) = (slices(&self.starts), slices(&self.own));
        let parameters = slices(&self.parameters);
        let mut given: Vec<Given<R>> = parameters.into_iter().map(Given::Shared).collect();
        if !own.is_empty() {
            given[0] = Given::Each(&own);
        }
        self.loss.rollout.run_batch(&starts, &given)
    }

    /// Returns the gradient of a weighted sum of squares of all observed numbers. The derivatives with respect to
    /// starts and own parameters come first. `together` runs the starts as a batch.
    fn gradient(&self, together: bool) -> Vec<R> {
        self.gradient_of(together, |seen| seen)
    }

    /// Like [`gradient`](Self::gradient), but only for the observed numbers that `choice` selects.
    fn gradient_of(&self, together: bool, choice: impl Fn(Vec<Var<R>>) -> Vec<Var<R>>) -> Vec<R> {
        let x = [&self.starts, &self.own, &self.parameters]
            .map(|of| of.concat())
            .concat();
        gradient(
            |x: &[Var<R>]| {
                let mut part = taken_from(x);
                let mut take = |of: &Vec<R>| part(of.len()).to_vec();
                let variables = Several {
                    loss: self.loss.clone(),
                    starts: self.starts.iter().map(&mut take).collect(),
                    own: self.own.iter().map(&mut take).collect(),
                    parameters: self.parameters.iter().map(&mut take).collect(),
                };
                let seen = if together {
                    variables.together()
                } else {
                    variables.alone()
                };
                let weighted = choice(seen.concat()).into_iter().enumerate();
                let weighted = weighted.map(|(i, s)| s * s * Var::lit(1.0 + 0.1 * (i % 7) as f64));
                weighted.fold(Var::zero(), |sum, term| sum + term)
            },
            &x,
        )
    }
}

fn slices<R>(of: &[Vec<R>]) -> Vec<&[R]> {
    of.iter().map(Vec::as_slice).collect()
}

/// Returns the number of steps; Miri runs fewer.
fn steps(all: usize) -> usize {
    if cfg!(miri) { all.min(7) } else { all }
}

/// The tests of drawn programs and those of instruction sets have floats.
#[test]
fn batches_of_duals_have_the_values_of_each_start_alone() {
    let duals = Several::<Dual<f64, 1>>::new(3, 9).with_own();
    let values = |of: Vec<Vec<Dual<f64, 1>>>| of.concat().iter().map(|x| x.value).collect();
    let [together, alone]: [Vec<f64>; 2] = [duals.together(), duals.alone()].map(values);
    assert_eq!(together, alone);
}

/// A rollout that returns only chosen entries must be bit-identical to a rollout that returns whole states, in the
/// chosen entries and in their gradients.
#[test]
fn entries_are_those_of_whole_states() {
    let entries = vec![1, NODES, 2 * NODES - 1];
    let whole = Several::<f64>::new(9, steps(37));
    let mut some = Several::<f64>::new(9, steps(37));
    some.loss.rollout.entries = Some(entries.clone());
    let state = 2 * NODES;
    let place = |k: usize| k / entries.len() * state + entries[k % entries.len()];
    let count = some.loss.rollout.observed.len() * entries.len();
    for (some, whole) in some.together().iter().zip(whole.together()) {
        let expected: Vec<f64> = (0..count).map(|k| whole[place(k)]).collect();
        assert_eq!(*some, expected);
    }
    assert_eq!(some.together(), some.alone());
    for together in [true, false] {
        let choice = |seen: Vec<Var<f64>>| {
            let all = seen.len() / state * entries.len();
            (0..all).map(|k| seen[place(k)]).collect()
        };
        assert!(some.gradient(together) == whole.gradient_of(together, choice));
    }
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn parameters_that_do_not_fit_the_starts_are_refused() {
    let several = Several::<f64>::new(8, 1);
    let (starts, parameters) = (slices(&several.starts), slices(&several.parameters));
    let refused = |sentence: &str, place: usize, own: &[&[f64]]| {
        let mut given: Vec<Given<f64>> = parameters.iter().map(|&p| Given::Shared(p)).collect();
        given[place] = Given::Each(own);
        assert_refused(sentence, || several.loss.rollout.run_batch(&starts, &given));
    };
    let matrix = "parameter 2 is a matrix, which all starts must share: use `Given::Shared`";
    refused(matrix, 2, &[parameters[2]; 8]);
    let each = "Given::Each must have one slice for each start";
    refused(each, 0, &parameters[..1]);
    // The number of values is that of a single start.
    let few = "parameter 0 of the program has 48 numbers, but 47 were given";
    refused(few, 0, &[&parameters[0][1..]; 8]);
}

/// With checkpoints a batch must give the same gradient. With a bound, the cotangent of each start must be clipped
/// separately.
#[test]
fn memory_and_bounds_are_as_for_one() {
    let mut several = Several::<f64>::new(8, steps(61));
    let all = several.gradient(true);
    several.loss.rollout.memory = Memory::States(13);
    assert!(several.gradient(true) == all);
    several.loss.rollout.cotangent_bound = Some(CotangentBound {
        norm: 0.5,
        every: 2,
    });
    let [together, alone] = [true, false].map(|together| several.gradient(together));
    let of_starts = ..several.starts.len() * 2 * NODES;
    assert!(together[of_starts] == alone[of_starts]);
    assert!(together[of_starts] != all[of_starts]);
    // In units twice as large, all numbers are half as large.
    several.loss.rollout.cotangent_units = Some(vec![2.0; 2 * NODES].into());
    assert!(several.gradient(true) != together);
    several.loss.rollout.cotangent_bound = Some(CotangentBound {
        norm: 0.25,
        every: 2,
    });
    assert!(several.gradient(true) == together);
}

/// The bound is the largest number that one of the starts reaches. Starts that reach this number or a larger one must
/// return NaN. All others must be bit-identical to runs without a bound.
#[test]
fn a_state_that_is_not_below_its_bound_gives_nan() {
    fn largest(of: &[f64]) -> f64 {
        of.iter().fold(0.0, |most, x| most.max(x.abs()))
    }
    fn check<R: Real + PartialEq + Into<f64>>() {
        let steps = steps(23);
        for count in [1, 2, 9] {
            let mut several = Several::<R>::new(count, steps).with_own();
            several.loss.rollout.observed = (1..=steps).collect();
            let numbers = |seen: Vec<R>| seen.into_iter().map(R::into).collect::<Vec<f64>>();
            let largest: Vec<f64> = (several.alone().into_iter())
                .map(|seen| largest(&numbers(seen)))
                .collect();
            several.loss.rollout.observed = vec![0, steps];
            several.loss.rollout.entries = Some(vec![0]);
            let plain = several.together();
            for &bound in &largest {
                several.loss.rollout.state_bound = Some(bound);
                let (together, alone) = (several.together(), several.alone());
                for (k, largest) in largest.iter().enumerate() {
                    let told = |seen: &[R]| seen.iter().all(|&x| x.into().is_nan());
                    let sane = |seen: &[R]| seen == plain[k];
                    let expected = |seen: &[R]| {
                        if *largest < bound {
                            sane(seen)
                        } else {
                            told(seen)
                        }
                    };
                    assert!(expected(&together[k]) && expected(&alone[k]), "{k}");
                }
            }
        }
    }
    check::<f64>();
    check::<f32>();
}

/// With any memory, derivatives must not depend on the bound. Outputs that exceed it must be NaN in every mode.
#[test]
fn a_bound_on_the_state_leaves_derivatives_alone() {
    let mut several = Several::<f64>::new(3, steps(23));
    let plain = several.gradient(true);
    for memory in [Memory::All, Memory::States(12)] {
        several.loss.rollout.memory = memory;
        several.loss.rollout.state_bound = Some(1e3);
        assert!(several.gradient(true) == plain);
    }
    let x = Several::<f64>::new(1, 1).loss.point();
    let loss = |bound| {
        let mut loss = Loss::new(steps(23));
        (loss.rollout.state_bound, loss.rollout.memory) = (Some(bound), Memory::States(12));
        loss
    };
    let lifted: Vec<Dual<f64, 1>> = x.iter().map(|&x| Dual::lit(x)).collect();
    let dual = |bound| loss(bound).eval(&lifted);
    assert_eq!(dual(1e3).value, loss(1e3).eval(&x));
    assert!(dual(1e-3).value.is_nan() && loss(1e-3).eval(&x).is_nan());
    let (value, _) = value_and_gradient(|x| loss(1e-3).eval(x), &x);
    assert!(value.is_nan());
}

/// A model whose state never changes. The field is the length of the state.
#[derive(Clone, Copy)]
struct Still(usize);

#[kernel]
impl Kernel<1, 1> for Still {
    fn eval<R: Real>(&self, x: [R; 1], _: &[R]) -> [R; 1] {
        x
    }
}

impl Model for Still {
    fn record(&self, program: &mut Program) {
        let state = program.state(self.0);
        let [same] = program.map(*self, [state], &[]);
        program.advance(state, same);
    }
}

impl Still {
    fn rollout(self, steps: usize, state_bound: Option<f64>) -> Rollout<Self> {
        Rollout {
            state_bound,
            ..Rollout::new(self, steps)
        }
    }
}

/// One number that exceeds the bound must give NaN, wherever it is and however short the rollout. The start must not be
/// checked.
#[test]
fn every_number_of_every_state_is_looked_at() {
    // Enough numbers for three pairs of the widest registers, and five more.
    let numbers = 6 * 16 + 5;
    for place in 0..numbers {
        let mut start = vec![0.1f32; numbers];
        start[place] = [2.0, -1.0, f32::NAN][place % 3];
        let seen = |steps| Still(numbers).rollout(steps, Some(1.0)).run(&start, &[]);
        assert!(seen(1).iter().all(|x| x.is_nan()), "{place}");
        assert_eq!(seen(0).iter().filter(|x| x.is_nan()).count(), place % 3 / 2);
    }
    let small = vec![0.999; numbers];
    assert_eq!(Still(numbers).rollout(9, Some(1.0)).run(&small, &[]), small);
}

/// The check of a bound must record nothing on a tape.
#[test]
fn a_bound_leaves_no_trace_on_a_tape() {
    let entries = |bound| {
        let mut tape = Tape::new();
        let rollout = Still(3).rollout(4, bound);
        tape.record(&[0.5; 3], |x| rollout.unrolled(x, &[]));
        tape.len()
    };
    assert_eq!(entries(Some(1.0)), entries(None));
}
