//! Kernels run compiled on floats, and replay a recording on all other numbers. Both must have the bits of plain code.
//! The drawn programs also have the derivatives of plain code.

use std::panic::{AssertUnwindSafe, catch_unwind};

use autodiff::{DoubleDouble, Dual, Real, Var, custom, gradient};
use autodiff_programs::{Compiled, Kernel, Model, Program, Rollout, data, kernel};

use crate::steps::Mapped;

/// Computes the new position `x` of a node. The inputs are `[x, force, a value of the node's neighbour]`.
#[derive(Clone, Copy)]
struct Move;

#[kernel]
impl Kernel<3, 1> for Move {
    fn eval<R: Real>(&self, [x, force, neighbour]: [R; 3], _: &[R]) -> [R; 1] {
        let sum = R::sum_of(&[x, R::lit(0.1) * force, R::lit(0.05) * neighbour.sin()]);
        [sum + R::dot(&[x, force], &[force, neighbour]) * R::lit(0.01)]
    }
}

/// A model whose next state is a result of [`Move`].
#[derive(Clone)]
struct Moving;

impl Model for Moving {
    fn record(&self, program: &mut Program) {
        let [x, force, neighbour] = [(); 3].map(|()| program.state(5));
        let [next] = program.map(Move, [x, force, neighbour], &[]);
        for (state, next) in [(x, next), (force, force), (neighbour, neighbour)] {
            program.advance(state, next);
        }
    }
}

/// A step must have the bits of the kernel's code in every number type.
#[test]
fn replayed_numbers_are_those_of_the_code() {
    fn check<R: Real + PartialEq>() {
        let number = |i: usize| R::lit((1.3 * i as f64 + 0.4).sin());
        let start: Vec<R> = (0..15).map(number).collect();
        let end = Rollout::new(Moving, 1).run(&start, &[]);
        let input = |k: usize| [start[k], start[5 + k], start[10 + k]];
        data::values(&Move, 5, input, |k, y| assert_eq!([end[k]], y));
    }
    check::<f64>();
    check::<f32>();
    check::<DoubleDouble>();
    check::<Dual<f64, 1>>();
}

/// [`Move`] times a uniform input, compiled for what `KINDS[KIND]` says.
#[derive(Clone, Copy)]
struct Scaled<const KIND: usize>;

const KINDS: [Compiled; 4] = [
    Compiled::Never,
    Compiled::Seldom,
    Compiled::Narrow,
    Compiled::Fully,
];

#[kernel]
impl<const KIND: usize> Kernel<3, 1> for Scaled<KIND> {
    const COMPILED: Compiled = KINDS[KIND];
    const UNIFORMS: usize = 1;

    fn eval<R: Real>(&self, x: [R; 3], factor: &[R]) -> [R; 1] {
        let [x] = Move.eval(x, &[]);
        [x * factor[0]]
    }
}

impl<const KIND: usize> Model for Scaled<KIND> {
    fn record(&self, program: &mut Program) {
        let factor = program.parameter(1);
        let [x, force, neighbour] = [(); 3].map(|()| program.state(5));
        let [next] = program.map(*self, [x, force, neighbour], &[factor]);
        for (state, next) in [(x, next), (force, force), (neighbour, neighbour)] {
            program.advance(state, next);
        }
    }
}

/// The state after two steps, and the derivative of its sum by the uniform input.
fn scaled<R: Real, const KIND: usize>(tolerance: f64) -> (Vec<R>, R) {
    let rollout = Rollout::new(Scaled::<KIND>, 2);
    let number = |i: usize| R::lit((1.3 * i as f64 + 0.4).sin());
    let (start, factor): (Vec<R>, R) = ((0..15).map(number).collect(), R::lit(0.9));
    let ends = rollout.run(&start, &[&[factor]]);
    let constant: Vec<Var<R>> = start.iter().map(|&x| Var::constant(x)).collect();
    let sum = |factor: &[Var<R>]| rollout.run(&constant, &[factor]).into_iter().sum();
    let [slope] = gradient(sum, &[factor])[..] else {
        panic!("one derivative");
    };
    let constant: Vec<Dual<R, 1>> = start.iter().map(|&x| Dual::constant(x)).collect();
    let moving = rollout.run(&constant, &[&[Dual::variable(factor, 0)]]);
    let forward = moving.iter().map(|x| x.tangent[0]);
    let size: R = forward.clone().map(Real::abs).sum();
    let off = ((slope - forward.sum::<R>()) / size).abs().primal();
    assert!(off < tolerance, "{off} of {size:?} from forward mode");
    (ends, slope)
}

/// A kernel that is replayed has the bits of a compiled one, and its derivatives except for rounding. The recording of a kernel
/// that is always replayed is simplified, so its numbers may be rounded in another way.
#[test]
fn kernels_have_the_same_numbers_for_whatever_they_are_compiled() {
    fn check<R: Real + PartialEq>(tolerance: f64) {
        let fully = scaled::<R, 3>(tolerance);
        let others = [
            scaled::<R, 2>(tolerance),
            scaled::<R, 1>(tolerance),
            scaled::<R, 0>(tolerance),
        ];
        let off = |a: R, b: R| (a - b).abs().primal();
        assert!(others[0] == fully && others[1].0 == fully.0);
        for (ends, slope) in &others {
            let ends = ends.iter().zip(&fully.0).map(|(&a, &b)| off(a, b));
            let most = ends.fold(off(*slope, fully.1), f64::max);
            assert!(most < tolerance, "{most}");
        }
    }
    // A few ulps of a sum of ten terms of order one.
    check::<f64>(4e-15);
    check::<f32>(2e-6);
}

/// A square root by a custom rule. A recording cannot contain it.
#[derive(Clone)]
struct Root;

impl custom::Rule for Root {
    fn value<R: Real>(&self, x: &[R]) -> R {
        x[0].sqrt()
    }
    fn partials<R: Real>(&self, x: &[R], y: R) -> Vec<R> {
        vec![R::lit(0.5) / (y + x[0] - x[0])]
    }
}

#[derive(Clone, Copy)]
struct ByRule;

#[kernel]
impl Kernel<1, 1> for ByRule {
    fn eval<R: Real>(&self, x: [R; 1], _: &[R]) -> [R; 1] {
        [custom::apply(Root, &x)]
    }
}

/// Such a kernel with a uniform input.
#[derive(Clone, Copy)]
struct ScaledByRule;

#[kernel]
impl Kernel<1, 1> for ScaledByRule {
    const UNIFORMS: usize = 1;

    fn eval<R: Real>(&self, [x]: [R; 1], factor: &[R]) -> [R; 1] {
        [custom::apply(Root, &[x]) * factor[0]]
    }
}

impl Model for ScaledByRule {
    fn record(&self, program: &mut Program) {
        let (factor, x) = (program.parameter(1), program.state(1));
        let [next] = program.map(*self, [x], &[factor]);
        program.advance(x, next);
    }
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn a_kernel_that_cannot_be_recorded_runs_on_floats_and_is_refused_elsewhere() {
    let rollout = Rollout::new(Mapped(ByRule, 1), 2);
    assert_eq!(rollout.run(&[16.0], &[]), [2.0]);
    let dual = || rollout.run(&[Dual::<f64, 1>::variable(16.0, 0)], &[]);
    let refused = catch_unwind(AssertUnwindSafe(dual)).unwrap_err();
    let says = refused.downcast_ref::<String>().expect("a sentence");
    assert!(
        says.contains("ByRule, mapped at")
            && says.contains("steps/mod.rs")
            && says.contains("it needs f64 or f32"),
        "{says}"
    );
}

/// Derivatives by a uniform input come from a recording, those by the other inputs do not.
#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn a_kernel_that_cannot_be_recorded_has_no_derivatives_by_uniform_inputs() {
    let rollout = Rollout::new(ScaledByRule, 1);
    let end = |x: &[Var<f64>]| rollout.run(&x[..1], &[&[Var::constant(3.0)]])[0];
    assert_eq!(gradient(end, &[16.0]), [0.375]);
    let end = |factor: &[Var<f64>]| rollout.run(&[Var::constant(16.0)], &[factor])[0];
    let refused = catch_unwind(AssertUnwindSafe(|| gradient(end, &[3.0]))).unwrap_err();
    let says = refused.downcast_ref::<String>().expect("a sentence");
    assert!(
        says.contains("uniform inputs without derivatives"),
        "{says}"
    );
}
