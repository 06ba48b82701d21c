//! Programs of shapes that neither the net of springs nor the drawn programs have. They must agree with the same steps
//! written out in plain code.

use crate::common::gradients;
use crate::steps::{STEPS, Step, Turn, assert_same};
use autodiff::check::{Options, Verdict, check_gradient};
use autodiff::{
    Function, Given, Graph, Kernel, Memory, Model, Program, Real, Rollout, Tape, Var, gradient,
    kernel,
};

// Miri is slow, so it gets the fewest nodes that suffice.
const NODES: usize = if cfg!(miri) { 7 } else { 11 };

/// A kernel that computes the force of an edge from the difference of its ends and its stiffness.
#[derive(Clone, Copy)]
struct Pull;

#[kernel]
impl Kernel<2, 1> for Pull {
    fn eval<R: Real>(&self, [d, k]: [R; 2]) -> [R; 1] {
        [k * d * R::lit(0.1)]
    }
}

/// A kernel that adds two numbers.
#[derive(Clone, Copy)]
struct Plus;

#[kernel]
impl Kernel<2, 1> for Plus {
    fn eval<R: Real>(&self, [x, f]: [R; 2]) -> [R; 1] {
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
    fn record<R: Real>(&self, p: &mut Program<R>) {
        let k = p.parameter(self.graph.slots());
        let x = p.state(NODES);
        let [f] = p.map_edges(&self.graph, Pull, [x], &[k]);
        let [next] = p.map(Plus, [x, f]);
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
            let [pull] = Kernel::eval(&Pull, [x[head] - x[tail], k]);
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

/// A model that declares a state, an input and a second state. In the next row, these places hold the new states with
/// an array between them. A gather or a kernel reads that array.
#[derive(Clone)]
struct Between {
    gathered: bool,
}

impl Between {
    const LEN: usize = 16;
}

impl Model for Between {
    fn record<R: Real>(&self, p: &mut Program<R>) {
        let x = p.state(Self::LEN);
        let input = p.input(Self::LEN);
        let y = p.state(Self::LEN);
        let [seen] = p.map(Turn, [y, input]);
        let [next_x] = p.map(Turn, [x, seen]);
        let [between] = p.map(Plus, [seen, next_x]);
        let shift: Vec<_> = (0..Self::LEN).map(|i| i.checked_sub(1)).collect();
        let next_y = if self.gathered {
            p.gather(between, &shift)
        } else {
            p.map(Turn, [seen, between])[0]
        };
        p.advance(x, next_x);
        p.advance(y, next_y);
    }
}

impl Step for Between {
    fn shapes(&self) -> Vec<usize> {
        vec![2 * Self::LEN]
    }
    fn inputs(&self) -> Vec<f64> {
        (0..Self::LEN).map(|i| 0.1 * i as f64).collect()
    }
    fn written_out<R: Real>(&self, state: &[R], _: &[&[R]]) -> Vec<R> {
        let (x, y) = state.split_at(Self::LEN);
        let turn = |x: R, y: R| Kernel::eval(&Turn, [x, y])[0];
        let inputs = self.inputs().into_iter().map(R::lit);
        let seen: Vec<R> = y.iter().zip(inputs).map(|(&y, i)| turn(y, i)).collect();
        let mut next: Vec<R> = x.iter().zip(&seen).map(|(&x, &s)| turn(x, s)).collect();
        let between: Vec<R> = seen.iter().zip(&next).map(|(&s, &x)| s + x).collect();
        if self.gathered {
            next.push(R::zero());
            next.extend(&between[..Self::LEN - 1]);
        } else {
            next.extend(seen.iter().zip(between).map(|(&s, b)| turn(s, b)));
        }
        next
    }
}

#[test]
fn an_array_may_lie_between_the_parts_of_the_new_state() {
    for gathered in [true, false] {
        assert_same(Between { gathered });
    }
}

/// A model that declares its arrays only where it needs them.
#[derive(Clone)]
struct AsNeeded;

impl Model for AsNeeded {
    fn record<R: Real>(&self, p: &mut Program<R>) {
        let (x, k) = (p.state(NODES), p.parameter(NODES));
        let [turned] = p.map(Turn, [x, k]);
        let (y, push, to) = (p.state(NODES), p.input(NODES), p.parameter(NODES));
        let [pushed] = p.map(Turn, [y, push]);
        let [next] = p.map(Turn, [pushed, to]);
        p.advance(x, next);
        p.advance(y, turned);
    }
}

impl Step for AsNeeded {
    fn shapes(&self) -> Vec<usize> {
        vec![2 * NODES, NODES, NODES]
    }
    fn inputs(&self) -> Vec<f64> {
        (0..NODES).map(|i| 0.1 * i as f64).collect()
    }
    fn written_out<R: Real>(&self, state: &[R], given: &[&[R]]) -> Vec<R> {
        let turn = |a, b| Kernel::eval(&Turn, [a, b])[0];
        let (x, y) = state.split_at(NODES);
        let push = self.inputs().into_iter().map(R::lit);
        let pushed = y.iter().zip(push).map(|(&y, push)| turn(y, push));
        let next = pushed.zip(given[1]).map(|(y, &to)| turn(y, to));
        let turned = x.iter().zip(given[0]).map(|(&x, &k)| turn(x, k));
        next.chain(turned).collect()
    }
}

#[test]
fn declarations_may_come_in_any_order() {
    assert_same(AsNeeded);
}

/// A kernel without results, which must be refused.
#[derive(Clone, Copy)]
struct Nothing;

#[kernel]
impl Kernel<1, 0> for Nothing {
    fn eval<R: Real>(&self, _: [R; 1]) -> [R; 0] {
        []
    }
}

impl Model for Nothing {
    fn record<R: Real>(&self, p: &mut Program<R>) {
        let x = p.state(NODES);
        let [] = p.map(Nothing, [x]);
        p.advance(x, x);
    }
}

#[test]
#[should_panic(expected = "map: the kernel must have at least one result")]
fn a_kernel_has_results() {
    Rollout::new(Nothing, 1).run(&[0.0; NODES], &[]);
}

/// A model with empty arrays and matrices among others that are not empty.
#[derive(Clone)]
struct Hollow;

impl Model for Hollow {
    fn record<R: Real>(&self, p: &mut Program<R>) {
        let (flat, bias) = (p.matrix(NODES, 0), p.parameter(NODES));
        let (narrow, none) = (p.matrix(0, NODES), p.parameter(0));
        let (nothing, x, nor) = (p.state(0), p.state(NODES), p.state(0));
        let input = p.input(0);
        let from_none = p.dense(flat, &[nothing, input], bias);
        let to_none = p.dense(narrow, &[x], none);
        let zeros = p.dense_tanh_spread(narrow, &[x], none, &[false; NODES]);
        let picked = p.gather(x, &[]);
        let [sum] = p.map(Plus, [picked, to_none]);
        let [next] = p.map(Turn, [x, from_none]);
        let [next] = p.map(Plus, [next, zeros]);
        p.advance(nothing, sum);
        p.advance(x, next);
        p.advance(nor, nothing);
    }
}

impl Step for Hollow {
    fn shapes(&self) -> Vec<usize> {
        vec![NODES, 0, NODES, 0, 0]
    }
    fn written_out<R: Real>(&self, x: &[R], given: &[&[R]]) -> Vec<R> {
        let pairs = x.iter().zip(given[1]);
        pairs
            .map(|(&x, &bias)| Kernel::eval(&Turn, [x, bias])[0])
            .collect()
    }
}

/// Arrays may be empty: a chain of one node has no edges, and a model without sensors has a matrix without rows.
#[test]
fn arrays_may_be_empty() {
    assert_same(Hollow);
    let rollout = Rollout::new(Hollow, STEPS);
    let bias = [0.4; NODES];
    let parameters: [&[f64]; 4] = [&[], &bias, &[], &[]];
    let mut given = parameters.map(Given::Shared);
    for count in [1, 2, 7] {
        let starts: Vec<Vec<f64>> = (0..count).map(|k| vec![k as f64; NODES]).collect();
        let slices: Vec<&[f64]> = starts.iter().map(Vec::as_slice).collect();
        let alone: Vec<Vec<f64>> = slices.iter().map(|s| rollout.run(s, &parameters)).collect();
        given[3] = Given::Each(&[&[] as &[f64]; 7][..count]);
        assert_eq!(rollout.run_batch(&slices, &given), alone);
        let gradient = |together: bool| {
            gradient(
                |x: &[Var<f64>]| {
                    let bias = [Var::lit(0.4); NODES];
                    let parameters: [&[Var<f64>]; 4] = [&[], &bias, &[], &[]];
                    let starts: Vec<&[Var<f64>]> = x.chunks(NODES).collect();
                    let seen = if together {
                        rollout.run_batch(&starts, &parameters.map(Given::Shared))
                    } else {
                        (starts.iter().map(|s| rollout.run(s, &parameters))).collect()
                    };
                    Var::sum_of(&seen.concat())
                },
                &starts.concat(),
            )
        };
        assert_eq!(gradient(true), gradient(false));
    }
}

/// A program without any state must work for every memory budget.
#[test]
fn a_program_may_have_no_state() {
    #[derive(Clone)]
    struct Stateless;
    impl Model for Stateless {
        fn record<R: Real>(&self, _: &mut Program<R>) {}
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
    fn record<R: Real>(&self, p: &mut Program<R>) {
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
