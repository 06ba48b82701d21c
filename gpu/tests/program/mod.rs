//! A program with every operation that can be printed. Tests check its text and run it on a device.

use autodiff::{Real, lit};
use autodiff_programs::{Graph, Kernel, Model, Program};
use cosmic::kernel;
use cosmic::policy::Weighted;

/// A spring with two results. Each has its own stiffness; all have the same damping.
struct Spring;

#[kernel]
impl Kernel<3, 2> for Spring {
    const UNIFORMS: usize = 1;

    fn eval<R: Real>(&self, [dx, dv, k]: [R; 3], u: &[R]) -> [R; 2] {
        [
            k * dx.tanh() + u[0] * dv,
            R::select(dx.less(0.0), dv, dv * dx.exp()),
        ]
    }
}

/// The elongation of a bar.
struct Elongation;

#[kernel]
impl Kernel<2, 1> for Elongation {
    fn eval<R: Real>(&self, [dx, rest]: [R; 2], _: &[R]) -> [R; 1] {
        [(dx * dx + lit(1e-6)).sqrt() - rest]
    }
}

/// Moves a node.
struct Move;

#[kernel]
impl Kernel<4, 2> for Move {
    fn eval<R: Real>(&self, [x, v, force, push]: [R; 4], _: &[R]) -> [R; 2] {
        let v = (v + lit(0.01) * (force + push)).max(-10.0);
        [x + lit(0.01) * v, v]
    }
}

/// A program with every operation that can be printed.
#[derive(Clone)]
pub(crate) struct Every(Graph);

impl Every {
    pub(crate) fn new() -> Self {
        Self(Graph::new(5, &[[0, 1], [1, 2], [2, 3], [3, 4], [0, 2]]))
    }
}

impl Model for Every {
    fn record(&self, p: &mut Program) {
        let (nodes, slots) = (self.0.nodes(), self.0.slots());
        let [stiffness, rest] = [(); 2].map(|()| p.parameter(slots));
        let (damping, weights) = (p.parameter(1), p.parameter(nodes));
        let (first, bias) = (p.matrix(8, 2 * nodes + 2), p.parameter(8));
        let (second, zeros) = (p.matrix(3, 8), p.parameter(3));
        let [x, v] = [(); 2].map(|()| p.state(nodes));
        let clock = p.input(2);

        let weighted = Weighted {
            offsets: 1,
            weighed: 2,
        };
        let seen = p.operation(weighted, &[weights, x, v, clock], &[2 * nodes + 2, 1, 1])[0];
        let hidden = p.dense_tanh(first, &[seen], bias);
        let push = p.dense_tanh(second, &[hidden], zeros);
        let push = p.gather(push, &[Some(0), None, Some(1), Some(1), Some(2)]);
        let [pull, _] = p.map_edges(&self.0, Spring, [x, v], &[stiffness], &[damping]);
        let [longer] = p.map_each_edge(&self.0, Elongation, [x], &[rest], &[]);
        let sum = p.sum_at_nodes(&self.0, longer);
        let [x_next, v_next] = p.map(Move, [x, v, pull, push], &[]);
        let [_, v_next] = p.map(Move, [x_next, v_next, sum, push], &[]);
        p.advance(x, x_next);
        p.advance(v, v_next);
    }
}
