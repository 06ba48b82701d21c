//! Asserts that steps defined as programs agree with the same steps written out in plain code.

use crate::common::{Formula, Sym, formula};
use crate::net::{taken_from, weighted_squares};
use autodiff::{Dual, Function, Real, Tape, Var, gradient};
use autodiff_programs::{Kernel, Model, Program, Rollout, kernel};

// Miri is slow, so it gets the fewest steps that suffice.
pub(crate) const STEPS: usize = if cfg!(miri) { 2 } else { 5 };

/// A step that is defined both as a program and in plain code.
pub(crate) trait Step: Model + Clone {
    /// Returns the length of the state, followed by the lengths of the parameters.
    fn shapes(&self) -> Vec<usize>;
    /// Converts the given parameters to the form that the program takes: positive weights, for example.
    fn parameters<R: Real>(&self, given: &[&[R]]) -> Vec<Vec<R>> {
        given.iter().map(|part| part.to_vec()).collect()
    }
    /// Returns the inputs, which are the same in every step.
    fn inputs(&self) -> Vec<f64> {
        Vec::new()
    }
    /// Returns the state after step `step`, in plain code.
    fn written_out<R: Real>(&self, step: usize, state: &[R], parameters: &[&[R]]) -> Vec<R>;
}

/// A loss of the last state, computed by the program. The argument holds the state and all parameters.
struct Steps<M>(M);

/// Splits the argument into the state and the parameters.
fn parts<'a, R>(model: &impl Step, x: &'a [R]) -> Vec<&'a [R]> {
    model.shapes().into_iter().map(taken_from(x)).collect()
}

impl<M: Step> Function for Steps<M> {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let parts = parts(&self.0, x);
        let parameters = self.0.parameters(&parts[1..]);
        let parameters: Vec<&[R]> = parameters.iter().map(Vec::as_slice).collect();
        let rollout = Rollout {
            inputs: self.0.inputs().repeat(STEPS).into(),
            ..Rollout::new(self.0.clone(), STEPS)
        };
        weighted_squares(&rollout.run(parts[0], &parameters))
    }
}

/// Returns the same loss, computed by the step in plain code.
fn written_out(model: &impl Step) -> Formula {
    formula(model.shapes().iter().sum(), |x| {
        let parts = parts(model, x);
        let step = |state: Vec<Sym>, k| model.written_out(k, &state, &parts[1..]);
        weighted_squares(&(0..STEPS).fold(parts[0].to_vec(), step))
    })
}

#[track_caller]
fn assert_close(a: &[f64], b: &[f64]) {
    assert_eq!(a.len(), b.len());
    let size = b.iter().fold(1.0_f64, |size, x| size.max(x.abs()));
    for (a, b) in a.iter().zip(b) {
        // The two numbers are sums of hundreds of equal terms in a different order.
        assert!((a - b).abs() <= 1e-12 * size, "{a} and {b} of {size}");
    }
}

/// Returns four results: the value, the derivative along a direction, the gradient, and the derivative of the gradient
/// along the direction.
fn derivatives(function: &impl Function, x: &[f64], along: &[Dual<f64, 1>]) -> [Vec<f64>; 4] {
    let second = gradient(|x| function.eval(x), along);
    [
        vec![function.eval(x)],
        function.eval(along).tangent.to_vec(),
        gradient(|x| function.eval(x), x),
        second.iter().map(|g| g.tangent[0]).collect(),
    ]
}

/// Asserts that the program and the plain code of a step have the same value and derivatives.
#[track_caller]
pub(crate) fn assert_same(model: impl Step) {
    let plain = written_out(&model);
    let len: usize = model.shapes().iter().sum();
    let x: Vec<f64> = (0..len).map(|i| (1.3 * i as f64 + 0.4).sin()).collect();
    let dual = |(&tangent, &value)| Dual {
        value,
        tangent: [tangent],
    };
    let along: Vec<Dual<f64, 1>> = x.iter().rev().zip(&x).map(dual).collect();
    let program = derivatives(&Steps(model), &x, &along);
    for (program, plain) in program.iter().zip(derivatives(&plain, &x, &along)) {
        assert_close(program, &plain);
    }
}

/// Asserts that runs that run together have the values and the gradients of runs that run alone, bit by bit. `run`
/// gets the numbers of each run.
#[track_caller]
pub(crate) fn assert_as_alone(
    runs: &[Vec<f64>],
    run: impl Fn(&[&[Var<f64>]]) -> Vec<Vec<Var<f64>>>,
) {
    let gradient = |runs: &[Vec<f64>]| {
        let mut tape = Tape::new();
        let last = tape.record(&runs.concat(), |x: &[Var<f64>]| {
            let runs: Vec<&[Var<f64>]> = x.chunks_exact(runs[0].len()).collect();
            run(&runs).concat()
        });
        let values: Vec<f64> = last.iter().map(|x| x.value()).collect();
        let ones = vec![1.0; values.len()];
        (values, tape.pullback(&last, &ones).to_vec())
    };
    let (values, gradients) = gradient(runs);
    let alone = runs.iter().map(|one| gradient(std::slice::from_ref(one)));
    let (each_value, each_gradient): (Vec<_>, Vec<_>) = alone.unzip();
    assert!(values.iter().all(|x| x.is_finite()));
    assert_eq!(values, each_value.concat());
    assert_eq!(gradients, each_gradient.concat());
}

/// A kernel that mixes two numbers and keeps them small. It is algebraic, so that the many programs that use it compile
/// quickly.
#[derive(Clone, Copy)]
pub(crate) struct Turn;

#[kernel]
impl Kernel<2, 1> for Turn {
    fn eval<R: Real>(&self, [x, y]: [R; 2], _: &[R]) -> [R; 1] {
        [x * R::lit(0.9) + y / (R::one() + y * y) * R::lit(0.6)]
    }
}

/// A kernel that multiplies each number by this factor.
#[derive(Clone, Copy)]
pub(crate) struct Times(pub(crate) f64);

#[kernel]
impl Kernel<1, 1> for Times {
    fn eval<R: Real>(&self, [x]: [R; 1], _: &[R]) -> [R; 1] {
        [x * R::lit(self.0)]
    }
}

/// A kernel that multiplies two numbers.
#[derive(Clone, Copy)]
pub(crate) struct Product;

#[kernel]
impl Kernel<2, 1> for Product {
    fn eval<R: Real>(&self, [x, y]: [R; 2], _: &[R]) -> [R; 1] {
        [x * y]
    }
}

/// A model that maps a kernel over a state of this length.
#[derive(Clone, Copy)]
pub(crate) struct Mapped<K>(pub(crate) K, pub(crate) usize);

impl<K: Kernel<1, 1> + Clone + Sync> Model for Mapped<K> {
    fn record(&self, program: &mut Program) {
        let x = program.state(self.1);
        let [next] = program.map(self.0.clone(), [x], &[]);
        program.advance(x, next);
    }
}

/// A model of a push that differs from step to step.
#[derive(Clone)]
pub(crate) struct Pushed;

impl Model for Pushed {
    fn record(&self, program: &mut Program) {
        let (x, push) = (program.state(2), program.control(2));
        program.advance(x, push);
    }
}
