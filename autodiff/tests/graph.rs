//! Graphs that leave out some of their edges, and graphs whose edges are springs in the plane.

use crate::steps::{Step, Turn, assert_same};
use autodiff::{
    Function, Given, Graph, Kernel, Model, Program, Real, Rollout, kernel, value_and_gradient,
};

const NODES: usize = 40;

/// A model of a chain of nodes. Springs join each node to the next one and to the third one after it.
#[derive(Clone)]
struct Chain(Graph);

fn edges() -> Vec<[usize; 2]> {
    let springs = |reach: usize| (0..NODES - reach).map(move |i| [i, i + reach]);
    springs(1).chain(springs(3)).collect()
}

/// Returns which edges to leave out: first so many in a row that they fill whole registers, and then every third edge.
fn marked() -> Vec<bool> {
    (0..edges().len())
        .map(|e| e < 17 || (e > 30 && e % 3 == 0))
        .collect()
}

#[derive(Clone, Copy)]
struct Spring;
#[kernel]
impl Kernel<2, 1> for Spring {
    fn eval<R: Real>(&self, [d, k]: [R; 2], _: &[R]) -> [R; 1] {
        [k * d / (d * d + R::lit(1e-3)).sqrt()]
    }
}

#[derive(Clone, Copy)]
struct Move;
#[kernel]
impl Kernel<3, 2> for Move {
    fn eval<R: Real>(&self, [x, v, f]: [R; 3], _: &[R]) -> [R; 2] {
        let v = v * R::lit(0.99) + f * R::lit(0.05);
        [x + R::lit(0.05) * v, v]
    }
}

impl Model for Chain {
    fn record(&self, p: &mut Program) {
        let k = p.parameter(self.0.slots());
        let (x, v) = (p.state(NODES), p.state(NODES));
        let [f] = p.map_edges(&self.0, Spring, [x], &[k], &[]);
        let [x_next, v_next] = p.map(Move, [x, v, f], &[]);
        p.advance(x, x_next);
        p.advance(v, v_next);
    }
}

/// The weighted sum of squares of the observed numbers, as a function of the start and of the stiffness in each slot.
struct Loss(Rollout<Chain>);

impl Loss {
    fn of(graph: Graph) -> Self {
        Self(Rollout {
            observed: vec![10, 25],
            ..Rollout::new(Chain(graph), 25)
        })
    }
}

impl Function for Loss {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let (start, stiffness) = x.split_at(2 * NODES);
        let moved: Vec<R> = start.iter().map(|&x| x * R::lit(1.1)).collect();
        let seen = self
            .0
            .run_batch(&[start, &moved], &[Given::Shared(stiffness)])
            .concat();
        let weights = (0..seen.len()).map(|i| R::lit(1.0 + 0.01 * i as f64));
        let weighted: Vec<R> = seen.iter().zip(weights).map(|(&s, w)| s * w).collect();
        R::dot(&seen, &weighted)
    }
}

/// An edge without stiffness exerts no force, and adding zeros does not change the bits of a sum. So leaving the edge
/// out must not change the value. It must change no derivative except the one with respect to the edge's own stiffness.
#[test]
fn edges_that_are_left_out_are_as_edges_that_give_zero() {
    let (full, marked) = (Graph::new(NODES, &edges()), marked());
    let less = full.without(&marked);
    let stiffness = |graph: &Graph| {
        let of_edge = |(e, &left_out): (usize, &bool)| {
            if left_out {
                0.0
            } else {
                1.0 + (e as f64).sin()
            }
        };
        graph.to_slots(&marked.iter().enumerate().map(of_edge).collect::<Vec<f64>>())
    };
    let start = (0..2 * NODES).map(|i| ((i * i) as f64 * 0.7).sin());
    let x: Vec<f64> = start.chain(stiffness(&full)).collect();
    assert_eq!(stiffness(&full), stiffness(&less));
    let (value, gradient) = value_and_gradient(|x| Loss::of(full.clone()).eval(x), &x);
    let (value_less, gradient_less) = value_and_gradient(|x| Loss::of(less).eval(x), &x);
    assert_eq!(value, value_less);
    assert_eq!(gradient[..2 * NODES], gradient_less[..2 * NODES]);
    for (edge, &slot) in full.slot_of_edge().iter().enumerate() {
        let place = 2 * NODES + slot;
        if marked[edge] {
            assert!(gradient[place] != 0.0 && gradient_less[place] == 0.0)
        } else {
            assert_eq!(gradient[place], gradient_less[place], "edge {edge}")
        }
    }
}

#[test]
fn what_is_left_out_is_a_ghost() {
    let (full, marked) = (Graph::new(NODES, &edges()), marked());
    let less = full.without(&marked);
    assert_eq!(full.slots(), less.slots());
    assert_eq!(full.slot_of_edge().len(), marked.len());
    assert_eq!(full.slot_of_edge(), less.slot_of_edge());
    let of_slot = less.edge_of_slot();
    for (edge, &slot) in full.slot_of_edge().iter().enumerate() {
        let is_left = !marked[edge];
        assert_eq!(of_slot[slot], is_left.then_some(edge));
        assert_eq!(less.nodes_of_slot()[slot], is_left.then_some(edges()[edge]));
    }
    let ones = less.to_slots(&vec![1.0; marked.len()]);
    let left = marked.iter().filter(|marked| !**marked).count();
    assert_eq!(ones.iter().sum::<f64>(), left as f64);
    // The first seventeen edges of one direction fill two registers of eight or more lanes.
    assert!(less.lanes::<f64>() + 2 <= full.lanes::<f64>());
    let none = full.without(&vec![true; marked.len()]);
    assert_eq!((none.lanes::<f64>(), none.lanes::<f32>()), (0, 0));
}

/// In a graph without any edge, no force may act on the nodes.
#[test]
fn nothing_pulls_in_a_graph_without_any_edge() {
    let full = Graph::new(NODES, &edges());
    let loss = Loss::of(full.without(&vec![true; edges().len()]));
    let start: Vec<f64> = (0..2 * NODES).map(|i| (i as f64).cos()).collect();
    let seen = (loss.0).run(&start, &[&vec![1.0; full.slots()]]);
    let velocity = seen[seen.len() - NODES];
    // The tolerance is for 25 rounded products with 0.99.
    assert!((velocity - start[NODES] * 0.99f64.powi(25)).abs() < 1e-15);
}

#[test]
#[should_panic(expected = "`marked` must have one value for each edge")]
fn every_edge_has_its_truth_value() {
    let _ = Graph::new(NODES, &edges()).without(&[true]);
}

/// A model of springs in the plane. The kernel gets two differences between the ends of an edge, and has three results.
#[derive(Clone)]
struct Plane {
    edges: Vec<[usize; 2]>,
    graph: Graph,
}

impl Plane {
    fn new(nodes: usize) -> Self {
        let edges: Vec<_> = (edges().into_iter().filter(|[_, head]| *head < nodes)).collect();
        Self {
            graph: Graph::new(nodes, &edges),
            edges,
        }
    }
}

#[derive(Clone, Copy)]
struct Strut;
#[kernel]
impl Kernel<3, 3> for Strut {
    fn eval<R: Real>(&self, [dx, dy, k]: [R; 3], _: &[R]) -> [R; 3] {
        let length = (dx * dx + dy * dy + R::lit(1e-3)).sqrt();
        let pull = k * (length - R::one()) / length;
        [pull * dx, pull * dy, length]
    }
}

impl Model for Plane {
    fn record(&self, p: &mut Program) {
        let k = p.parameter(self.graph.slots());
        let (x, y) = (p.state(self.graph.nodes()), p.state(self.graph.nodes()));
        let [pull_x, pull_y, lengths] = p.map_edges(&self.graph, Strut, [x, y], &[k], &[]);
        let [x_next] = p.map(Turn, [x, pull_x], &[]);
        let [pulled] = p.map(Turn, [y, pull_y], &[]);
        let [y_next] = p.map(Turn, [pulled, lengths], &[]);
        p.advance(x, x_next);
        p.advance(y, y_next);
    }
}

impl Step for Plane {
    fn shapes(&self) -> Vec<usize> {
        vec![2 * self.graph.nodes(), self.edges.len()]
    }
    fn parameters<R: Real>(&self, given: &[&[R]]) -> Vec<Vec<R>> {
        vec![self.graph.to_slots(given[0])]
    }
    fn written_out<R: Real>(&self, state: &[R], given: &[&[R]]) -> Vec<R> {
        let (x, y) = state.split_at(self.graph.nodes());
        let mut sums = vec![[R::zero(); 3]; x.len()];
        for (&[tail, head], &k) in self.edges.iter().zip(given[0]) {
            let strut = Kernel::eval(&Strut, [x[head] - x[tail], y[head] - y[tail], k], &[]);
            for (o, result) in strut.into_iter().enumerate() {
                sums[tail][o] += result;
                sums[head][o] -= result;
            }
        }
        let turn = |x, y| Kernel::eval(&Turn, [x, y], &[])[0];
        let x_next = x.iter().zip(&sums).map(|(&x, sums)| turn(x, sums[0]));
        let y_next = y.iter().zip(&sums);
        let y_next = y_next.map(|(&y, sums)| turn(turn(y, sums[1]), sums[2]));
        x_next.chain(y_next).collect()
    }
}

#[test]
fn edges_may_have_several_ends_and_several_results() {
    // In one case the nodes fill whole registers, and in the other they fill the last register only in part.
    for nodes in [NODES, NODES - 3] {
        assert_same(Plane::new(nodes));
    }
}
