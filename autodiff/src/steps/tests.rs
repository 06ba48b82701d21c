//! Compares rollouts on all instruction sets of the machine. Builds of tests have the widest registers only here.

use std::array::from_fn;

use super::instance::Instance;
use crate::simd::{Level, at_most, lanes, level};
use crate::{Graph, Kernel, Model, Program, Real, Rollout, Tape, Var, kernel};

/// More nodes than two of the widest registers have lanes, and not a multiple of any number of lanes.
const NODES: usize = 37;
const HIDDEN: usize = 27;

/// A chain of springs whose rest lengths a network drives.
#[derive(Clone)]
struct Driven(Graph);

#[derive(Clone, Copy)]
struct Spring;

#[kernel]
impl Kernel<2, 1> for Spring {
    fn eval<R: Real>(&self, [d, u]: [R; 2], _: &[R]) -> [R; 1] {
        let length = (d * d + R::lit(1e-3)).sqrt();
        [(length - R::lit(0.1) * (R::one() + u)) * d / length]
    }
}

#[derive(Clone, Copy)]
struct Move;

#[kernel]
impl Kernel<3, 2> for Move {
    fn eval<R: Real>(&self, [x, v, force]: [R; 3], _: &[R]) -> [R; 2] {
        let v = v * R::lit(0.99) + force * R::lit(0.05);
        let v = R::select(x.less(-0.5), v.max(R::zero()), v);
        [x + R::lit(0.05) * v, v]
    }
}

impl Model for Driven {
    fn record(&self, p: &mut Program) {
        let (graph, slots) = (&self.0, self.0.slots());
        let (inner, bias) = (p.matrix(HIDDEN, NODES), p.parameter(HIDDEN));
        let (outer, none) = (p.matrix(slots, HIDDEN), p.parameter(slots));
        let [x, v] = [(); 2].map(|()| p.state(NODES));
        let hidden = p.dense_tanh(inner, &[x], bias);
        let driven = p.dense(outer, &[hidden], none);
        let [force] = p.map_edges(graph, Spring, [x], &[driven], &[]);
        let turned: Vec<_> = (0..NODES).map(|i| Some((i + 5) % NODES)).collect();
        let force = p.gather(force, &turned);
        let [next_x, next_v] = p.map(Move, [x, v, force], &[]);
        p.advance(x, next_x);
        p.advance(v, next_v);
    }
}

/// Irregular numbers of order one.
fn numbers<R: Real>(count: usize, by: f64) -> Vec<R> {
    let number = |i: usize| R::lit(0.4 * (by * (i * i) as f64 + by).sin());
    (0..count).map(number).collect()
}

/// Returns the states of `starts` starts and their gradient with respect to the starts and the shared parameters. If
/// `together` is true, the starts run as a batch.
fn states_and_gradient<R: Real>(starts: usize, together: bool) -> [Vec<R>; 2] {
    let edges: Vec<[usize; 2]> = (1..NODES).map(|i| [i - 1, i]).collect();
    let graph = Graph::new(NODES, &edges);
    let slots = graph.slots();
    let shapes = [HIDDEN * NODES, HIDDEN, slots * HIDDEN, slots];
    let rollout = Rollout::new(Driven(graph), 19);
    let of_starts = 2 * NODES * starts;
    let x = [numbers(of_starts, 0.7), numbers(shapes.iter().sum(), 0.3)].concat();
    let mut tape = Tape::new();
    let seen = tape.record(&x, |x: &[Var<R>]| {
        let (starts, mut rest) = x.split_at(of_starts);
        let starts: Vec<&[Var<R>]> = starts.chunks(2 * NODES).collect();
        let parameters: [&[Var<R>]; 4] =
            from_fn(|k| rest.split_off(..shapes[k]).expect("as long as its parts"));
        if together {
            let shared = parameters.map(crate::Given::Shared);
            return rollout.run_batch(&starts, &shared).concat();
        }
        let alone = starts
            .iter()
            .flat_map(|start| rollout.run(start, &parameters));
        alone.collect()
    });
    let values = seen.iter().map(|x| x.value()).collect();
    let bars = numbers(seen.len(), 1.1);
    [values, tape.pullback(&seen, &bars).to_vec()]
}

/// On every instruction set, a batch must have the states and the cotangents of each start alone, to the bit, and the
/// states and gradients must be those of scalars except for rounding.
#[test]
fn all_registers_agree() {
    fn check<R: Real + PartialEq + Into<f64>>(tolerance: f64) {
        let scalars = at_most(Level::Baseline, || states_and_gradient::<R>(17, false));
        for cap in [Level::Baseline, Level::Avx2, level()] {
            for starts in [1, 2, 3, 17] {
                let [together, alone] = [true, false]
                    .map(|together| at_most(cap, || states_and_gradient::<R>(starts, together)));
                let of_starts = ..2 * NODES * starts;
                assert!(together[0] == alone[0], "{starts} starts, {cap:?}");
                assert!(
                    together[1][of_starts] == alone[1][of_starts],
                    "{starts}, {cap:?}"
                );
                if starts < 17 {
                    continue;
                }
                for (found, expected) in together.iter().zip(&scalars) {
                    let size = |x: &R| (*x).into().abs();
                    let most = expected.iter().map(size).fold(0.0, f64::max);
                    for (&a, &b) in found.iter().zip(expected) {
                        let off: f64 = (a - b).into();
                        assert!(
                            off.abs() <= tolerance * most,
                            "{a:?} {b:?} of {most}, {cap:?}"
                        );
                    }
                }
            }
        }
    }
    // Each derivative is a sum of hundreds of terms, some of which may be larger than the sum.
    check::<f64>(1e-12);
    check::<f32>(1e-4);
}

/// The lanes of a program are planned when it is recorded.
#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn lanes_that_differ_from_the_plan_panic() {
    let graph = Graph::new(3, &[[0, 1]]);
    let mut program = Program::side_by_side(1, lanes::<f64>());
    let [x, u] = [3, graph.slots()].map(|len| program.state(len));
    let [next] = program.map_edges(&graph, Spring, [x], &[u], &[]);
    program.advance(x, next);
    program.advance(u, u);
    let mut program = Instance::new(program);
    let mut row = vec![0.0_f64; program.row_len()];
    let mut step = || program.step(&[], &mut row, None);
    step();
    let planned = level();
    let done = at_most(Level::Baseline, || {
        std::panic::catch_unwind(std::panic::AssertUnwindSafe(step))
    });
    // On a machine without wider lanes nothing changes and the step must succeed.
    assert_eq!(done.is_err(), planned != Level::Baseline);
}
