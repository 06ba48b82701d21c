//! Programs of shapes that the net of springs has not, against the same steps written out.

use autodiff::{
    Adjoint, Dual, Function, Given, Graph, Kernel, Memory, Model, Program, Real, Rollout, Tape,
    Var, gradient, gradient_of,
};

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
    /// The inputs of all steps: the same in each.
    fn inputs(&self) -> Vec<f64> {
        Vec::new()
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
        let rollout = Rollout {
            inputs: self.model.inputs().repeat(STEPS).into(),
            ..Rollout::new(self.model.clone(), STEPS)
        };
        rollout.run(start, &parameters)
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

/// Sums over a node's edges are made for up to four directions at once: fewer, none, and some left
/// over.
#[test]
fn edges_may_have_any_number_of_directions() {
    for count in 0..=6 {
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

/// A layer that sees an array twice, and adds it once more.
#[derive(Clone)]
struct Echo;

impl Model for Echo {
    fn record<R: Real>(&self, p: &mut Program<R>) {
        let matrix = p.matrix(NODES, 3 * NODES);
        let (x, y) = (p.state(NODES), p.state(NODES));
        let next = p.dense(matrix, &[x, y, x], x);
        p.advance(x, next);
        p.advance(y, x);
    }
}

impl Step for Echo {
    fn shapes(&self) -> Vec<usize> {
        vec![2 * NODES, 3 * NODES * NODES]
    }
    fn written_out<R: Real>(&self, state: &[R], given: &[&[R]]) -> Vec<R> {
        let x = &state[..NODES];
        let seen = [state, x].concat();
        let rows = given[0].chunks_exact(3 * NODES).zip(x);
        let next: Vec<R> = rows.map(|(row, &x)| R::dot(row, &seen) + x).collect();
        [&next, x].concat()
    }
}

#[test]
fn a_layer_may_see_an_array_twice() {
    assert_same(Echo);
}

/// Arrays that several operations read, in every order, or none; the new state is made of two
/// operations, of which one reads what the other gives, and so lies where the next row begins.
#[derive(Clone)]
struct Crossroads {
    graph: Graph,
    /// Of them the graph has but the last.
    edges: Vec<[usize; 2]>,
}

impl Crossroads {
    /// In whole lanes.
    const NODES: usize = 16;

    fn new() -> Self {
        let edges = vec![[0, 1], [3, 5], [9, 11], [14, 15]];
        let graph = Graph::new(Self::NODES, &edges);
        Self {
            graph: graph.without(&[true, true, true, false]),
            edges,
        }
    }
}

impl Model for Crossroads {
    fn record<R: Real>(&self, p: &mut Program<R>) {
        let (nodes, slots) = (Self::NODES, self.graph.slots());
        let of_slots: Vec<_> = (0..slots).map(|slot| Some(slot % nodes)).collect();
        let of_nodes: Vec<_> = (0..nodes).map(|node| Some(slots - 1 - node)).collect();
        let matrix = p.matrix(nodes, 2 * nodes);
        let (x, y) = (p.state(nodes), p.state(nodes));
        let [a] = p.map(Turn, [x, y]);
        let [before, after] = [(); 2].map(|()| p.gather(a, &of_slots));
        let [twice] = p.map(Plus, [before, before]);
        let [f] = p.map_edges(&self.graph, Pull, ([a], &[before]));
        let [g] = p.map_edges(&self.graph, Pull, ([f], &[after]));
        let [unread] = p.map(Turn, [after, twice]);
        let _unread = p.gather(unread, &of_nodes);
        let [sum] = p.map(Plus, [after, twice]);
        let picked = p.gather(sum, &of_nodes);
        let layer = p.dense_tanh(matrix, &[picked, g], a);
        let [next_x] = p.map(Turn, [layer, a]);
        let [next_y] = p.map(Plus, [next_x, f]);
        p.advance(x, next_x);
        p.advance(y, next_y);
    }
}

impl Step for Crossroads {
    fn shapes(&self) -> Vec<usize> {
        vec![2 * Self::NODES, 2 * Self::NODES * Self::NODES]
    }
    fn written_out<R: Real>(&self, state: &[R], given: &[&[R]]) -> Vec<R> {
        let nodes = Self::NODES;
        let turn = |(&x, &y): (&R, &R)| Kernel::eval(&Turn, [x, y])[0];
        let a: Vec<R> = state[..nodes]
            .iter()
            .zip(&state[nodes..])
            .map(turn)
            .collect();
        let slot = *self.graph.slot_of_edge().last().unwrap();
        let &[tail, head] = self.edges.last().unwrap();
        let pulled = |x: &[R]| {
            let mut pulls = vec![R::zero(); nodes];
            let [pull] = Kernel::eval(&Pull, [x[head] - x[tail], a[slot % nodes]]);
            (pulls[tail], pulls[head]) = (pull, -pull);
            pulls
        };
        let f = pulled(&a);
        let picked = (0..nodes).map(|node| a[(self.graph.slots() - 1 - node) % nodes]);
        let picked: Vec<R> = picked.map(|a| a * R::lit(3.0)).collect();
        let seen = [picked, pulled(&f)].concat();
        let rows = given[0].chunks_exact(2 * nodes).zip(&a);
        let layer = rows.map(|(row, &a)| (R::dot(row, &seen) + a).tanh());
        let layer: Vec<R> = layer.collect();
        let next_x: Vec<R> = layer.iter().zip(&a).map(turn).collect();
        let next_y: Vec<R> = next_x.iter().zip(&f).map(|(&x, &f)| x + f).collect();
        [next_x, next_y].concat()
    }
}

#[test]
fn cotangents_of_all_that_read_an_array_add_up() {
    assert_same(Crossroads::new());
}

/// A state, an input and a state; and in the same places of the next row the new state with an
/// array between, which a gather reads or a kernel.
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
        let next_y = match self.gathered {
            true => p.gather(between, &shift),
            false => p.map(Turn, [seen, between])[0],
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

/// A state that becomes a parameter, and one that becomes the other.
#[derive(Clone)]
struct Reset;

impl Model for Reset {
    fn record<R: Real>(&self, p: &mut Program<R>) {
        let [k, to] = [(); 2].map(|()| p.parameter(NODES));
        let (x, y) = (p.state(NODES), p.state(NODES));
        let [next] = p.map(Turn, [x, k]);
        p.advance(x, to);
        p.advance(y, next);
    }
}

impl Step for Reset {
    fn shapes(&self) -> Vec<usize> {
        vec![2 * NODES, NODES, NODES]
    }
    fn written_out<R: Real>(&self, state: &[R], given: &[&[R]]) -> Vec<R> {
        let x = state.iter().zip(given[0]);
        let turned = x.map(|(&x, &k)| Kernel::eval(&Turn, [x, k])[0]);
        given[1].iter().copied().chain(turned).collect()
    }
}

#[test]
fn a_state_may_become_a_parameter() {
    assert_same(Reset);
}

/// Arrays and matrices without any number beside some that have them.
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
        let zeros = p.dense_tanh_spread((narrow, none), &[x], &[false; NODES]);
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

/// A chain of one link has no edges, a robot without sensors no rows of them.
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
        assert_eq!(rollout.run_each(&slices, &given), alone);
        let gradient = |together: bool| {
            gradient_of(
                |x: &[Var<f64>]| {
                    let bias = [Var::lit(0.4); NODES];
                    let parameters: [&[Var<f64>]; 4] = [&[], &bias, &[], &[]];
                    let starts: Vec<&[Var<f64>]> = x.chunks(NODES).collect();
                    let seen = match together {
                        true => rollout.run_many(&starts, &parameters),
                        false => (starts.iter().map(|s| rollout.run(s, &parameters))).collect(),
                    };
                    Var::sum(&seen.concat())
                },
                &starts.concat(),
            )
        };
        assert_eq!(gradient(true), gradient(false));
    }
}

/// No state at all, whatever the memory.
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
                .run_many(&[&[], &[] as &[f64]], &[])
                .concat()
                .is_empty()
        );
    }
}
