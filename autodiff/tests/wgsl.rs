//! Programs printed as WGSL. The numbers are compared on a device by the package `cosmic-gpu`; here the text is checked.

use autodiff::arrays::{UniformKernel, Uniforms};
use autodiff::wgsl::{Options, Printed, print};
use autodiff::{Array, Elementary, Graph, Kernel, Model, Program, Real, lit};

/// A spring that also turns its ends, with a stiffness of its own and a common damping.
struct Spring;

impl UniformKernel<3, 2> for Spring {
    const UNIFORMS: usize = 1;

    #[inline(always)]
    fn eval_with<R: Real>(&self, [dx, dv, k]: [R; 3], u: &Uniforms<R>) -> [R; 2] {
        [k * dx.tanh() + u[0] * dv, R::select(dx.less(0.0), dv, dv * dx.exp())]
    }
}

/// The elongation of a bar.
struct Elongation;

impl Kernel<2, 1> for Elongation {
    #[inline(always)]
    fn eval<R: Real>(&self, [dx, rest]: [R; 2]) -> [R; 1] {
        [(dx * dx + lit(1e-6)).sqrt() - rest]
    }
}

/// Moves a node.
struct Move;

impl Kernel<4, 2> for Move {
    #[inline(always)]
    fn eval<R: Real>(&self, [x, v, force, push]: [R; 4]) -> [R; 2] {
        let v = (v + lit(0.01) * (force + push)).max(-10.0);
        [x + lit(0.01) * v, v]
    }
}

/// A program with every operation that can be printed.
#[derive(Clone)]
struct Every(Graph);

impl Every {
    fn new() -> Self {
        Self(Graph::new(5, &[[0, 1], [1, 2], [2, 3], [3, 4], [0, 2]]))
    }
}

impl Model for Every {
    fn record<R: Real>(&self, p: &mut Program<R>) {
        let (nodes, slots) = (self.0.nodes(), self.0.slots());
        let [stiffness, rest] = [(); 2].map(|()| p.parameter(slots));
        let (damping, weights) = (p.parameter(1), p.parameter(nodes));
        let (first, bias) = (p.matrix(8, 2 * nodes + 2), p.parameter(8));
        let (second, zeros) = (p.matrix(3, 8), p.parameter(3));
        let [x, v] = [(); 2].map(|()| p.state(nodes));
        let clock = p.input(2);

        let [seen, _] = p.weighted(weights, &[x], &[v], &[clock]);
        let hidden = p.dense_tanh(first, &[seen], bias);
        let push: Array = p.dense_tanh_spread(second, &[hidden], zeros, &[true, false, true, true, false]);
        let all: Vec<Option<usize>> = [Some(0), None, Some(1), Some(1), Some(4)].to_vec();
        let push = p.gather(push, &all);
        let [pull, _] = p.map_edges_with(&self.0, Spring, [x, v], &[stiffness], &[damping]);
        let [longer] = p.map_each_edge(&self.0, Elongation, [x], &[rest], &[]);
        let sum = p.sum_at_nodes(&self.0, longer);
        let [x_next, v_next] = p.map(Move, [x, v, pull, push]);
        let [_, v_next] = p.map(Move, [x_next, v_next, sum, push]);
        p.advance(x, x_next);
        p.advance(v, v_next);
    }
}

/// Parses and checks a text as a device would.
fn check(printed: &Printed) {
    let module = naga::front::wgsl::parse_str(&printed.source)
        .unwrap_or_else(|error| panic!("{}\n{}", error.emit_to_string(&printed.source), printed.source));
    let (flags, all) = (naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty());
    let checked = naga::valid::Validator::new(flags, all).validate(&module);
    checked.unwrap_or_else(|error| panic!("{}", error.emit_to_string(&printed.source)));
}

#[test]
fn every_operation_is_printed() {
    for (common, wanted) in [
        (vec![], vec![]),
        (vec![], (0..8).collect()),
        (vec![4, 5, 6, 7], vec![0, 2]),
        (vec![0, 1, 2, 3, 4, 5, 6, 7], (0..8).collect()),
    ] {
        for workgroup in [4, 64] {
            let options = Options {
                workgroup,
                common: common.clone(),
                wanted: wanted.clone(),
                ..Options::default()
            };
            check(&print(&Every::new(), &options).unwrap());
        }
    }
}

/// Applies an elementary function and powers to every number.
#[derive(Clone)]
struct Applied(Elementary);

impl Kernel<1, 1> for Applied {
    #[inline(always)]
    fn eval<R: Real>(&self, [x]: [R; 1]) -> [R; 1] {
        [x.elementary(self.0) + x.powi(-3) + x.atan2(2.0) + x.powf(0.5) + x.hypot(1.0) + x.cos()]
    }
}

impl Model for Applied {
    fn record<R: Real>(&self, p: &mut Program<R>) {
        let x = p.state(3);
        let [next] = p.map(self.clone(), [x]);
        p.advance(x, next);
    }
}

#[test]
fn every_function_is_printed() {
    for function in Elementary::ALL {
        check(&print(&Applied(*function), &Options::default()).unwrap());
    }
}
