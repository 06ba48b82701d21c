//! Kernels run compiled on floats, and replay a recording on all other numbers. Both must agree with plain code.

use std::panic::{AssertUnwindSafe, catch_unwind};

use autodiff::{
    DoubleDouble, Dual, Graph, Kernel, Model, Program, Real, Rollout, custom, data, kernel,
};

use crate::steps::{Step, assert_same};

/// The force of a spring along an edge. The inputs are `[difference of x, difference of y, stiffness]`.
#[derive(Clone, Copy)]
struct Spring;

#[kernel]
impl Kernel<3, 2> for Spring {
    fn eval<R: Real>(&self, [dx, dy, stiffness]: [R; 3], _: &[R]) -> [R; 2] {
        let length = dx.fma(dx, dy * dy + R::lit(1e-3)).sqrt();
        let pull = R::select(length.less(R::lit(0.5)), stiffness, stiffness * length) / length;
        [pull * dx, pull * dy]
    }
}

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

/// A model of masses that are joined by springs.
#[derive(Clone)]
struct Truss(Graph);

const EDGES: [[usize; 2]; 5] = [[0, 1], [1, 2], [0, 2], [1, 3], [2, 3]];
/// For each node, the node before it, if there is one.
const BEFORE: [Option<usize>; 4] = [None, Some(0), Some(1), Some(2)];

impl Model for Truss {
    fn record(&self, program: &mut Program) {
        let stiffness = program.parameter(self.0.slots());
        let state = [(); 2].map(|()| program.state(self.0.nodes()));
        let forces = program.map_edges(&self.0, Spring, state, &[stiffness], &[]);
        let next = [0, 1].map(|k| {
            let neighbour = program.gather(state[k], &BEFORE);
            program.map(Move, [state[k], forces[k], neighbour], &[])[0]
        });
        for (state, next) in state.into_iter().zip(next) {
            program.advance(state, next);
        }
    }
}

impl Step for Truss {
    fn shapes(&self) -> Vec<usize> {
        vec![8, 5]
    }

    fn parameters<R: Real>(&self, given: &[&[R]]) -> Vec<Vec<R>> {
        vec![self.0.to_slots(given[0])]
    }

    fn written_out<R: Real>(&self, state: &[R], parameters: &[&[R]]) -> Vec<R> {
        let mut forces = [R::zero(); 8];
        for (&[i, j], &stiffness) in EDGES.iter().zip(parameters[0]) {
            let d = [0, 4].map(|k| state[k + j] - state[k + i]);
            for (k, pull) in [0, 4]
                .into_iter()
                .zip(Spring.eval([d[0], d[1], stiffness], &[]))
            {
                forces[k + i] += pull;
                forces[k + j] -= pull;
            }
        }
        let moved = |k: usize| {
            let before = BEFORE[k % 4].map_or(R::zero(), |i| state[k / 4 * 4 + i]);
            Move.eval([state[k], forces[k], before], &[])[0]
        };
        (0..8).map(moved).collect()
    }
}

/// Values, gradients and second derivatives must agree with those of the step in plain code. Floats run in lanes, and
/// duals and tapes of duals replay recordings.
#[test]
fn steps_are_the_steps_written_out() {
    assert_same(Truss(Graph::new(4, &EDGES)));
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

#[derive(Clone)]
struct Rooted;

impl Model for Rooted {
    fn record(&self, program: &mut Program) {
        let x = program.state(1);
        let [next] = program.map(ByRule, [x], &[]);
        program.advance(x, next);
    }
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn a_kernel_that_cannot_be_recorded_runs_on_floats_and_is_refused_elsewhere() {
    let rollout = Rollout::new(Rooted, 2);
    assert_eq!(rollout.run(&[16.0], &[]), [2.0]);
    let dual = || rollout.run(&[Dual::<f64, 1>::variable(16.0, 0)], &[]);
    let refused = catch_unwind(AssertUnwindSafe(dual)).unwrap_err();
    let says = refused.downcast_ref::<String>().expect("a sentence");
    assert!(
        says.contains("ByRule, mapped at")
            && says.contains(file!())
            && says.contains("it needs f64 or f32"),
        "{says}"
    );
}
