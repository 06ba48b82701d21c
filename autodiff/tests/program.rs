//! Programs of shapes that neither the net of springs nor the drawn programs have. They must agree with the same steps
//! written out in plain code.

use crate::common::gradients;
use crate::steps::{STEPS, Step, assert_same};
use autodiff::check::{Options, Verdict, check_gradient};
use autodiff::{Function, Graph, Kernel, Memory, Model, Program, Real, Rollout, Tape, kernel};

// Miri is slow, so it gets the fewest nodes that suffice.
const NODES: usize = if cfg!(miri) { 7 } else { 11 };

/// A kernel that computes the force of an edge from the difference of its ends and its stiffness.
#[derive(Clone, Copy)]
struct Pull;

#[kernel]
impl Kernel<2, 1> for Pull {
    fn eval<R: Real>(&self, [d, k]: [R; 2], _: &[R]) -> [R; 1] {
        [k * d * R::lit(0.1)]
    }
}

/// A kernel that adds two numbers.
#[derive(Clone, Copy)]
struct Plus;

#[kernel]
impl Kernel<2, 1> for Plus {
    fn eval<R: Real>(&self, [x, f]: [R; 2], _: &[R]) -> [R; 1] {
        [x + f]
    }
}

/// A model whose edges have several directions. The edges of one direction are a group.
#[derive(Clone)]
struct Directions {
    edges: Vec<[usize; 2]>,
    graph: Graph,
}

impl Directions {
    fn new(count: usize) -> Self {
        let of = |by: usize| (0..NODES - by).map(move |tail| [tail, tail + by]);
        let edges: Vec<[usize; 2]> = (1..=count).flat_map(of).collect();
        Self {
            graph: Graph::new(NODES, &edges),
            edges,
        }
    }
}

impl Model for Directions {
    fn record(&self, p: &mut Program) {
        let k = p.parameter(self.graph.slots());
        let x = p.state(NODES);
        let [f] = p.map_edges(&self.graph, Pull, [x], &[k], &[]);
        let [next] = p.map(Plus, [x, f], &[]);
        p.advance(x, next);
    }
}

impl Step for Directions {
    fn shapes(&self) -> Vec<usize> {
        vec![NODES, self.edges.len()]
    }
    fn parameters<R: Real>(&self, given: &[&[R]]) -> Vec<Vec<R>> {
        vec![self.graph.to_slots(given[0])]
    }
    fn written_out<R: Real>(&self, x: &[R], given: &[&[R]]) -> Vec<R> {
        let mut next = x.to_vec();
        for (&[tail, head], &k) in self.edges.iter().zip(given[0]) {
            let [pull] = Kernel::eval(&Pull, [x[head] - x[tail], k], &[]);
            next[tail] += pull;
            next[head] -= pull;
        }
        next
    }
}

/// The sum over a node's edges is computed for up to four directions at once. It must be right for fewer directions,
/// for none, and if the number of directions is not a multiple of four.
#[test]
fn edges_may_have_any_number_of_directions() {
    for count in 0..=6 {
        assert_same(Directions::new(count));
    }
}

/// A kernel without results, which must be refused.
#[derive(Clone, Copy)]
struct Nothing;

#[kernel]
impl Kernel<1, 0> for Nothing {
    fn eval<R: Real>(&self, _: [R; 1], _: &[R]) -> [R; 0] {
        []
    }
}

impl Model for Nothing {
    fn record(&self, p: &mut Program) {
        let x = p.state(NODES);
        let [] = p.map(Nothing, [x], &[]);
        p.advance(x, x);
    }
}

#[test]
#[should_panic(expected = "map: the kernel must have at least one result")]
fn a_kernel_has_results() {
    Rollout::new(Nothing, 1).run(&[0.0; NODES], &[]);
}

/// A program without any state must work for every memory budget.
#[test]
fn a_program_may_have_no_state() {
    #[derive(Clone)]
    struct Stateless;
    impl Model for Stateless {
        fn record(&self, _: &mut Program) {}
    }
    for memory in [Memory::All, Memory::States(3)] {
        let rollout = Rollout {
            memory,
            ..Rollout::new(Stateless, STEPS)
        };
        let mut tape = Tape::<f64>::new();
        assert!(tape.record(&[], |x| rollout.run(x, &[])).is_empty());
        assert!(
            rollout
                .run_batch(&[&[], &[] as &[f64]], &[])
                .concat()
                .is_empty()
        );
    }
}

/// A model of one number that goes through a `tanh` layer. The layer's weight is a parameter.
#[derive(Clone)]
struct Saturated;

impl Model for Saturated {
    fn record(&self, p: &mut Program) {
        let (weight, bias) = (p.matrix(1, 1), p.parameter(1));
        let x = p.state(1);
        let next = p.dense_tanh(weight, &[x], bias);
        p.advance(x, next);
    }
}

struct ThroughLayer(Rollout<Saturated>);

impl Function for ThroughLayer {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        self.0.run(&x[..1], &[&x[1..2], &x[2..]])[0]
    }
}

/// The layer's reverse sweep knows only the results, so every mode must compute the slope from the results.
#[test]
fn a_saturated_layer_has_one_slope_in_all_modes() {
    let layer = ThroughLayer(Rollout::new(Saturated, 1));
    for bias in [0.0, 0.7, -3.0, 9.0, 15.0, 20.0] {
        let x = [0.25, 2.0, bias];
        let by_modes = gradients(&layer, &x).into_iter();
        let slopes: Vec<f64> = by_modes.map(|(_, gradient)| gradient[2]).collect();
        let y = layer.eval(&x);
        let expected = 1.0 - y * y;
        // Lanes use a fused multiply-add, while other numbers round the square and the difference, so they differ by an
        // ulp of 1. If the result is near 1, the difference is exact, and the error of the square is (1 - y)^2, which
        // is below 1e-12 times the slope.
        let error = if bias < 10.0 {
            2.0 * f64::EPSILON
        } else {
            1e-12 * expected
        };
        let close = |slope: &f64| (slope - expected).abs() <= error;
        assert!(slopes.iter().all(close), "{bias}: {slopes:?}, {expected}");
        // Further out, the slope has fewer digits than the tolerance of a check.
        if bias < 5.0 {
            let report = check_gradient(&layer, &x, &Options::default());
            assert_eq!(report.verdict, Verdict::Smooth, "{bias}: {report}");
        }
    }
}
