//! Programs of shapes that the net of springs has not, against the same steps written out.

use autodiff::{Adjoint, Dual, Function, Graph, Kernel, Model, Program, Real, Rollout, gradient};

// As few as do where Miri interprets them.
const NODES: usize = if cfg!(miri) { 7 } else { 11 };
const STEPS: usize = if cfg!(miri) { 2 } else { 5 };

/// A step, as a program and written out.
trait Step: Model {
    /// Lengths of the state and of the parameters.
    fn shapes(&self) -> Vec<usize>;
    /// The parameters as the program takes them.
    fn parameters<R: Real>(&self, given: &[&[R]]) -> Vec<Vec<R>> {
        given.iter().map(|part| part.to_vec()).collect()
    }
    fn written_out<R: Real>(&self, state: &[R], parameters: &[&[R]]) -> Vec<R>;
}

struct Steps<M> {
    model: M,
    as_program: bool,
}

impl<M: Step> Function for Steps<M> {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let mut rest = x;
        let mut parts = Vec::new();
        for len in self.model.shapes() {
            let (part, others) = rest.split_at(len);
            parts.push(part);
            rest = others;
        }
        let (start, given) = (parts[0], &parts[1..]);
        let last = match self.as_program {
            true => self.rollout(start, given),
            false => (0..STEPS).fold(start.to_vec(), |state, _| {
                self.model.written_out(&state, given)
            }),
        };
        let weighted = last.iter().enumerate();
        weighted.fold(R::zero(), |sum, (i, &s)| {
            sum + s * s * R::lit(1.0 + 0.1 * i as f64)
        })
    }
}

impl<M: Step> Steps<M> {
    fn rollout<R: Real>(&self, start: &[R], given: &[&[R]]) -> Vec<R> {
        let parameters = self.model.parameters(given);
        let parameters: Vec<&[R]> = parameters.iter().map(Vec::as_slice).collect();
        Rollout::new(self.model.clone(), STEPS).run(start, &parameters)
    }
}

#[track_caller]
fn assert_close(a: &[f64], b: &[f64]) {
    assert_eq!(a.len(), b.len());
    let size = b.iter().fold(1.0_f64, |size, x| size.max(x.abs()));
    for (a, b) in a.iter().zip(b) {
        // The same terms in another order: some hundreds of them.
        assert!((a - b).abs() <= 1e-13 * size, "{a} and {b} of {size}");
    }
}

/// Value, gradient and the derivative of the gradient in one direction, of both.
#[track_caller]
fn assert_same(model: impl Step) {
    let len = model.shapes().iter().sum();
    let x: Vec<f64> = (0..len).map(|i| (1.3 * i as f64 + 0.4).sin()).collect();
    let along: Vec<Dual<f64, 1>> = (x.iter().rev().zip(&x))
        .map(|(&tangent, &value)| Dual {
            value,
            tangent: [tangent],
        })
        .collect();
    let of = |as_program| Steps {
        model: model.clone(),
        as_program,
    };
    let (program, plain) = (of(true), of(false));
    assert_close(&[program.eval(&x)], &[plain.eval(&x)]);
    let [ours, plains] = [&program, &plain].map(|steps| (steps.eval(&along), gradient(steps, &x)));
    assert_close(&ours.0.tangent, &plains.0.tangent);
    assert_close(&ours.1, &plains.1);
    let second = |steps| -> Vec<f64> {
        let gradient = gradient(steps, &along);
        gradient.iter().map(|g| g.tangent[0]).collect()
    };
    assert_close(&second(&program), &second(&plain));
}

/// A rotation of `(x, y)`.
#[derive(Clone, Copy)]
struct Turn;

impl Kernel<2, 1> for Turn {
    fn eval<R: Real>(&self, [x, y]: [R; 2]) -> [R; 1] {
        [x * R::lit(0.9) + y.sin() * R::lit(0.3)]
    }
}
impl Adjoint<2, 1> for Turn {}

/// States that become other states: nothing computes them, they are moved.
#[derive(Clone)]
struct Exchange;

impl Model for Exchange {
    fn record<R: Real>(&self, p: &mut Program<R>) {
        let [x, y, z] = [(); 3].map(|()| p.state(NODES));
        let [next] = p.map(Turn, [x, z]);
        p.advance(x, y);
        p.advance(y, next);
        p.advance(z, x);
    }
}

impl Step for Exchange {
    fn shapes(&self) -> Vec<usize> {
        vec![3 * NODES]
    }
    fn written_out<R: Real>(&self, state: &[R], _: &[&[R]]) -> Vec<R> {
        let (x, y, z) = (
            &state[..NODES],
            &state[NODES..2 * NODES],
            &state[2 * NODES..],
        );
        let next = (0..NODES).map(|i| Kernel::eval(&Turn, [x[i], z[i]])[0]);
        let next: Vec<R> = next.collect();
        [y, &next, x].concat()
    }
}

#[test]
fn states_may_become_one_another() {
    assert_same(Exchange);
}

/// The pull of an edge, from the difference of its ends and its stiffness.
#[derive(Clone, Copy)]
struct Pull;

impl Kernel<2, 1> for Pull {
    fn eval<R: Real>(&self, [d, k]: [R; 2]) -> [R; 1] {
        [k * d * R::lit(0.1)]
    }
}
impl Adjoint<2, 1> for Pull {}

/// Adds.
#[derive(Clone, Copy)]
struct Plus;

impl Kernel<2, 1> for Plus {
    fn eval<R: Real>(&self, [x, f]: [R; 2]) -> [R; 1] {
        [x + f]
    }
}
impl Adjoint<2, 1> for Plus {}

/// Edges of so many directions, each a group of its own.
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
        let [f] = p.map_edges(&self.graph, Pull, ([x], &[k]));
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

/// Sums over a node's edges are made for up to four directions at once: fewer, and some left over.
#[test]
fn edges_may_have_any_number_of_directions() {
    for count in 1..=6 {
        assert_same(Directions::new(count));
    }
}

/// A layer without tanh, which feeds itself.
#[derive(Clone)]
struct Linear;

impl Model for Linear {
    fn record<R: Real>(&self, p: &mut Program<R>) {
        let (matrix, bias) = (p.matrix(NODES, NODES), p.parameter(NODES));
        let x = p.state(NODES);
        let next = p.dense(matrix, &[x], bias);
        p.advance(x, next);
    }
}

impl Step for Linear {
    fn shapes(&self) -> Vec<usize> {
        vec![NODES, NODES * NODES, NODES]
    }
    fn written_out<R: Real>(&self, x: &[R], given: &[&[R]]) -> Vec<R> {
        let rows = given[0].chunks_exact(NODES).zip(given[1]);
        rows.map(|(row, &bias)| R::dot(row, x) + bias).collect()
    }
}

#[test]
fn a_layer_may_be_linear() {
    assert_same(Linear);
}
