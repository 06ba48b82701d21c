//! A rollout for the tests of drivers: a net of springs that a small network controls.

use std::sync::Arc;

use autodiff::{Function, Real};
use autodiff_programs::{Graph, Kernel, Model, Program, Rollout, kernel};

/// A model of springs between neighbours on a 4 x 3 grid. A small network senses the nodes and drives the springs.
#[derive(Clone)]
pub(crate) struct Net {
    pub(crate) graph: Graph,
    pub(crate) hidden: usize,
}

/// Returns a function that splits a slice into parts: each call returns the next `len` numbers.
pub(crate) fn taken_from<'a, R>(mut rest: &'a [R]) -> impl FnMut(usize) -> &'a [R] {
    move |len| rest.split_off(..len).expect("as long as its parts")
}

pub(crate) const NODES: usize = 12;

impl Net {
    pub(crate) fn new() -> Self {
        let mut edges = Vec::new();
        for node in 0..NODES {
            for (right, up) in [(1, 0), (0, 1), (1, 1)] {
                if node % 4 + right < 4 && node / 4 + up < 3 {
                    edges.push([node, node + right + 4 * up]);
                }
            }
        }
        Self {
            graph: Graph::new(NODES, &edges),
            hidden: 5,
        }
    }
    pub(crate) fn edges(&self) -> usize {
        self.graph.slot_of_edge().len()
    }
    /// Returns indices for a gather that rotates the nodes by `by` places. There are `NODES + 1` places, one of which
    /// is empty.
    fn turn(by: usize) -> Vec<Option<usize>> {
        let place = |k| Some((k + by) % (NODES + 1)).filter(|&from| from < NODES);
        (0..NODES).map(place).collect()
    }
    /// Returns the lengths of the parameters, in the order of their declaration.
    pub(crate) fn shapes(&self) -> [usize; 6] {
        let slots = self.graph.slots();
        [
            slots,
            NODES,
            self.hidden * (NODES + 1),
            self.hidden,
            self.edges() * self.hidden,
            self.edges(),
        ]
    }
}

#[derive(Clone, Copy)]
struct Spring;
#[kernel]
impl Kernel<3, 1> for Spring {
    fn eval<R: Real>(&self, [d, k, u]: [R; 3], _: &[R]) -> [R; 1] {
        let length = (d * d + R::lit(1e-3)).sqrt();
        [k * (length - R::lit(0.1) * (R::one() + u)) * d / length]
    }
}

#[derive(Clone, Copy)]
struct Move;
#[kernel]
impl Kernel<4, 2> for Move {
    fn eval<R: Real>(&self, [x, v, f, w]: [R; 4], _: &[R]) -> [R; 2] {
        let v = v * R::lit(0.99) + f * w * R::lit(0.01);
        let v = R::select(x.less(R::lit(-0.2)), v.max(R::zero()), v);
        [x + R::lit(0.01) * v, v]
    }
}

impl Model for Net {
    fn record(&self, p: &mut Program) {
        let k = p.parameter(self.graph.slots());
        let w = p.parameter(NODES);
        let w1 = p.matrix(self.hidden, NODES + 1);
        let b1 = p.parameter(self.hidden);
        let w2 = p.matrix(self.edges(), self.hidden);
        let b2 = p.parameter(self.edges());
        let (x, v) = (p.state(NODES), p.state(NODES));
        let clock = p.input(1);
        let h = p.dense_tanh(w1, &[x, clock], b1);
        let of_edges = p.dense_tanh(w2, &[h], b2);
        let u = p.gather(of_edges, &self.graph.edge_of_slot());
        let [f] = p.map_edges(&self.graph, Spring, [x], &[k, u], &[]);
        // These gathers move the numbers one way and back. They contain single entries, runs of entries, and empty
        // places.
        let turned = p.gather(f, &Self::turn(1));
        let f = p.gather(turned, &Self::turn(NODES));
        let [x_next, v_next] = p.map(Move, [x, v, f, w], &[]);
        p.advance(x, x_next);
        p.advance(v, v_next);
    }
}

/// Returns a weighted sum of squares.
pub(crate) fn weighted_squares<R: Real>(of: &[R]) -> R {
    let terms = of.iter().enumerate();
    terms.fold(R::zero(), |sum, (i, &x)| {
        sum + x * x * R::lit(1.0 + 0.1 * i as f64)
    })
}

/// A loss of the observed states of a rollout. Its argument is a vector that holds the start and all parameters.
#[derive(Clone)]
pub(crate) struct Loss {
    pub(crate) rollout: Rollout<Net>,
}

impl Loss {
    pub(crate) fn new(steps: usize) -> Self {
        let inputs: Arc<[f64]> = (0..steps).map(|n| (0.3 * n as f64).sin()).collect();
        let observed = vec![0, steps / 2, steps / 2, steps];
        Self {
            rollout: Rollout {
                inputs,
                observed,
                ..Rollout::new(Net::new(), steps)
            },
        }
    }
    pub(crate) fn point(&self) -> Vec<f64> {
        let len = 2 * NODES + self.rollout.model.shapes().iter().sum::<usize>();
        // These are irregular numbers of order one.
        (0..len)
            .map(|i| ((i * i) as f64 * 0.7).sin() * 0.8)
            .collect()
    }
}

impl Function for Loss {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let (start, rest) = x.split_at(2 * NODES);
        let parameters = self.rollout.model.shapes().map(taken_from(rest));
        let seen = self.rollout.run(start, &parameters);
        weighted_squares(&seen)
    }
}
