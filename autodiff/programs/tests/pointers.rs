//! Small cases of all code that holds raw pointers: programs, graphs and rollouts. Miri runs them, which takes
//! some thousand times as long as the processor; see `check-heavy.sh`.

use crate::common::{assert_close, forward_gradient};
use crate::net::taken_from;
use crate::steps::{Product, Turn};
use autodiff::{Function, Real, Var, gradient};
use autodiff_programs::{Given, Graph, Memory, Model, Program, Rollout};

/// More nodes than a register has lanes, and no multiple of them; under Miri, whose register is a scalar, a few.
const NODES: usize = if cfg!(miri) { 3 } else { 19 };
const STEPS: usize = if cfg!(miri) { 5 } else { 40 };

/// A chain of nodes. Each part of a step is an operation with pointers.
#[derive(Clone)]
struct Chain(Graph);

impl Chain {
    fn new() -> Self {
        let edges: Vec<[usize; 2]> = (1..NODES).map(|node| [node - 1, node]).collect();
        Self(Graph::new(NODES, &edges))
    }

    /// The lengths of the start and of the parameters.
    fn lengths(&self) -> [usize; 6] {
        let slots = self.0.slots();
        [NODES, slots, 2 * NODES, 2, NODES, slots]
    }
}

impl Model for Chain {
    fn record(&self, p: &mut Program) {
        let (graph, x) = (&self.0, p.state(NODES));
        let stiffness = p.parameter(graph.slots());
        let [force] = p.map_edges(graph, Product, [x], &[stiffness], &[]);
        let (matrix, bias) = (p.matrix(2, NODES), p.parameter(2));
        let (capacity, conductance) = (p.parameter(NODES), p.parameter(graph.slots()));
        let two = p.dense_tanh(matrix, &[x], bias);
        let push: Vec<Option<usize>> = (0..NODES).map(|node| Some(node % 2)).collect();
        let push = p.gather(two, &push);
        let [at_edges] = p.map_each_edge(graph, Product, [push], &[stiffness], &[]);
        let at_nodes = p.sum_at_nodes(graph, at_edges);
        let [moved] = p.map(Turn, [x, force], &[]);
        let [moved] = p.map(Turn, [moved, at_nodes], &[]);
        let [heat] = p.map(Product, [capacity, moved], &[]);
        let [smooth] = p.solve(graph, &[capacity], &[conductance], &[], [heat]);
        let [products] = p.map(Product, [capacity, smooth], &[]);
        let own: Vec<Option<usize>> = (0..NODES).map(Some).collect();
        let weighed = p.gather(products, &own);
        let [next] = p.map(Turn, [smooth, weighed], &[]);
        p.advance(x, next);
    }
}

/// The sum of the squares of the states in the middle and at the end.
struct Squares(Rollout<Chain>);

impl Squares {
    fn new(memory: Memory) -> Self {
        Self(Rollout {
            observed: vec![STEPS / 2, STEPS],
            memory,
            ..Rollout::new(Chain::new(), STEPS)
        })
    }

    fn point(&self) -> Vec<f64> {
        let count = self.0.model.lengths().iter().sum();
        (0..count).map(|k| 0.6 + 0.3 * (k as f64).sin()).collect()
    }

    fn parts<'a, R>(&self, x: &'a [R]) -> [&'a [R]; 6] {
        self.0.model.lengths().map(taken_from(x))
    }
}

impl Function for Squares {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let parts = self.parts(x);
        let seen = self.0.run(parts[0], &parts[1..]);
        R::dot(&seen, &seen)
    }
}

/// The sums have some hundred terms of magnitude 1, which are added in another order.
const TOLERANCE: f64 = 1e-12;

#[test]
fn programs_on_graphs() {
    let squares = Squares::new(Memory::All);
    let x = squares.point();
    // A direction for each argument takes too long under Miri.
    let shown = if cfg!(miri) { 2 } else { x.len() };
    struct First<'a>(&'a Squares, Vec<f64>);
    impl Function for First<'_> {
        fn eval<R: Real>(&self, x: &[R]) -> R {
            let mut all = R::lits(&self.1);
            all[..x.len()].copy_from_slice(x);
            self.0.eval(&all)
        }
    }
    let forward = forward_gradient(&First(&squares, x.clone()), &x[..shown]);
    let reverse = gradient(|x| squares.eval(x), &x);
    assert_close(&reverse[..shown], &forward, TOLERANCE);
}

#[test]
fn rollouts_with_checkpoints() {
    let [all, few] = [Memory::All, Memory::Bytes(0)].map(Squares::new);
    let x = all.point();
    assert_eq!(gradient(|x| few.eval(x), &x), gradient(|x| all.eval(x), &x));
}

#[test]
fn rollouts_of_batches() {
    let squares = Squares::new(Memory::All);
    let x = squares.point();
    let alone = gradient(|x| squares.eval(x), &x);
    let together = |x: &[Var<f64>]| {
        let [start, shared @ ..] = squares.parts(x);
        let ends = (squares.0).run_batch(&[start; 3], &shared.map(Given::Shared));
        Var::dot(&ends[0], &ends[0]) + Var::dot(&ends[2], &ends[2])
    };
    let twice: Vec<f64> = alone.iter().map(|slope| 2.0 * slope).collect();
    assert_close(&gradient(together, &x), &twice, TOLERANCE);
}
