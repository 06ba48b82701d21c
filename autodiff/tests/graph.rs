//! Graphs that leave out some of their edges.

use crate::steps::{Step, Turn, assert_same};
use autodiff::{Graph, Kernel, Model, Program, Real, kernel};

const NODES: usize = 40;

/// Springs join each node of a chain to the next one and to the third one after it.
fn edges() -> Vec<[usize; 2]> {
    let springs = |reach: usize| (0..NODES - reach).map(move |i| [i, i + reach]);
    springs(1).chain(springs(3)).collect()
}

/// Returns which edges to leave out: first so many in a row that they fill whole registers, and then every third edge.
fn marked(count: usize) -> Vec<bool> {
    (0..count)
        .map(|e| e < 17 || (e > 30 && e % 3 == 0))
        .collect()
}

#[test]
fn what_is_left_out_is_a_ghost() {
    let (full, marked) = (Graph::new(NODES, &edges()), marked(edges().len()));
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

#[test]
#[should_panic(expected = "`marked` must have one value for each edge")]
fn every_edge_has_its_truth_value() {
    let _ = Graph::new(NODES, &edges()).without(&[true]);
}

/// A model of springs in the plane, some of which are left out. The kernel gets two differences between the ends of an
/// edge, and has three results.
#[derive(Clone)]
struct Plane {
    edges: Vec<[usize; 2]>,
    graph: Graph,
}

impl Plane {
    fn new(nodes: usize) -> Self {
        let edges: Vec<_> = (edges().into_iter().filter(|[_, head]| *head < nodes)).collect();
        let graph = Graph::new(nodes, &edges).without(&marked(edges.len()));
        Self { graph, edges }
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
        let marked = marked(self.edges.len());
        let all = self.edges.iter().zip(given[0]).zip(marked);
        for ((&[tail, head], &k), _) in all.filter(|(_, is_left_out)| !is_left_out) {
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
fn left_out_edges_do_not_act_and_others_have_several_ends_and_results() {
    // In one case the nodes fill whole registers, and in the other they fill the last register only in part.
    for nodes in [NODES, NODES - 3] {
        assert_same(Plane::new(nodes));
    }
}
