//! Kernels with uniform inputs: numbers that are the same for all nodes or edges.

use autodiff::check::{Options, Verdict, check_gradient};
use autodiff::{
    Function, Given, Graph, Kernel, Model, Program, Real, Rollout, Var, gradient, kernel,
};

/// A spring with the force `u[0] d + u[1] d^3` for an elongation `d`.
#[derive(Clone)]
struct Spring;

#[kernel]
impl Kernel<1, 1> for Spring {
    const UNIFORMS: usize = 2;

    fn eval<R: Real>(&self, [d]: [R; 1], u: &[R]) -> [R; 1] {
        [u[0] * d + u[1] * d * d * d]
    }
}

/// A kernel that moves a node: it adds to the position the force and a wind of strength `u[0]`, which depends on
/// the position.
#[derive(Clone)]
struct Move;

#[kernel]
impl Kernel<2, 1> for Move {
    const UNIFORMS: usize = 1;

    fn eval<R: Real>(&self, [x, force]: [R; 2], u: &[R]) -> [R; 1] {
        [x + force + u[0] * x.sin()]
    }
}

/// The number of nodes: more than a register has lanes, and not a multiple of the number of lanes.
const NODES: usize = 19;

#[derive(Clone)]
struct Chain(Graph);

impl Model for Chain {
    fn record(&self, p: &mut Program) {
        let [stiffness, cubic, wind] = [(); 3].map(|()| p.parameter(1));
        let x = p.state(NODES);
        let [force] = p.map_edges(&self.0, Spring, [x], &[], &[stiffness, cubic]);
        let [next] = p.map(Move, [x, force], &[wind]);
        p.advance(x, next);
    }
}

fn rollout() -> Rollout<Chain> {
    let edges: Vec<[usize; 2]> = (1..NODES).map(|i| [i - 1, i]).collect();
    Rollout::new(Chain(Graph::new(NODES, &edges)), 5)
}

fn start<R: Real>() -> Vec<R> {
    (0..NODES).map(|i| R::lit((0.7 * i as f64).sin())).collect()
}

/// A weighted sum of the last state, as a function of the uniform inputs.
struct Weighted;

fn weighted<R: Real>(end: &[R]) -> R {
    let terms = end.iter().enumerate();
    terms.map(|(i, &x)| R::lit(1.0 + 0.1 * i as f64) * x).sum()
}

impl Function for Weighted {
    fn eval<R: Real>(&self, u: &[R]) -> R {
        let uniforms: Vec<&[R]> = u.chunks(1).collect();
        weighted(&rollout().run(&start(), &uniforms))
    }
}

#[test]
fn uniform_inputs_have_derivatives() {
    let report = check_gradient(&Weighted, &[0.2, 0.1, 0.3], &Options::default());
    assert_eq!(report.verdict, Verdict::Smooth, "{report}");
    assert_eq!(report.control, Some(Verdict::Wrong), "{report}");
}

/// Batches of 2, 8 and 11 starts run in pairs, in whole registers and alone. Every gradient must equal the one from
/// single runs.
#[test]
fn uniform_inputs_of_a_batch_have_the_bits_of_single_runs() {
    for count in [2, 8, 11] {
        let of_robots: Vec<f64> = (0..3 * count).map(|k| 0.1 + 0.01 * k as f64).collect();
        let alone = |u: &[Var<f64>]| u.chunks(3).map(|u| Weighted.eval(u)).sum();
        let together = |u: &[Var<f64>]| {
            let own = |k: usize| -> Vec<&[Var<f64>]> { u[k..].chunks(1).step_by(3).collect() };
            let own = [own(0), own(1), own(2)];
            let given: Vec<Given<Var<f64>>> = own.iter().map(|own| Given::Each(own)).collect();
            let start = start();
            let ends = rollout().run_batch(&vec![&start[..]; count], &given);
            ends.iter().map(|end| weighted(end)).sum()
        };
        let [alone, together] = [gradient(alone, &of_robots), gradient(together, &of_robots)];
        assert_eq!(alone, together);
    }
}
