//! A panic about wrong arguments must say what is wrong, and name the line of the caller, not a line of this crate.

use autodiff::{Dual, Function, Real, Var, gradient};
use autodiff_programs::data::{Recorded, Sum, Summand};
use autodiff_programs::{
    Array, CotangentBound, Given, Graph, Kernel, Memory, Model, Program, Rollout, emit, kernel,
};

use crate::common::assert_named;
use crate::steps::{Product, Pushed};

/// `x -> x * factor`, in every step.
#[derive(Clone)]
struct Scaled;

impl Model for Scaled {
    fn record(&self, program: &mut Program) {
        let (x, factor) = (program.state(1), program.parameter(1));
        let [next] = program.map(Product, [x, factor], &[]);
        program.advance(x, next);
    }
}

/// A model with an input and a matrix.
#[derive(Clone)]
struct Fed;

impl Model for Fed {
    fn record(&self, program: &mut Program) {
        let (x, matrix, input) = (program.state(1), program.matrix(1, 1), program.input(1));
        let next = program.dense(matrix, &[x], input);
        program.advance(x, next);
    }
}

/// A kernel without results.
#[derive(Clone)]
struct Nothing;

#[kernel]
impl Kernel<1, 0> for Nothing {
    fn eval<R: Real>(&self, _: [R; 1], _: &[R]) -> [R; 0] {
        []
    }
}

/// A model that forgets to advance its state.
#[derive(Clone)]
struct Stuck;

impl Model for Stuck {
    fn record(&self, program: &mut Program) {
        program.state(1);
    }
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn rollouts_name_the_line_of_their_caller() {
    let rollout = Rollout::new(Scaled, 3);
    let none_each: &[&[f64]] = &[&[]];
    let (two, none): ([&[f64]; 2], &[&[f64]]) = ([&[1.0], &[1.0, 2.0]], &[]);
    assert_named(|| rollout.run(&[1.0], none));
    assert_named(|| rollout.run(&[1.0, 2.0], &two[..1]))
        .says("has 2 numbers, but the model's state has 1");
    assert_named(|| rollout.run(&[1.0], &two[1..]));
    assert_named(|| rollout.run(&[Dual::<_, 2>::variable(1.0, 0)], &[]));
    assert_named(|| gradient(|x| rollout.run(x, &[])[0], &[1.0]));
    assert_named(|| rollout.run_batch(&two, &[Given::Shared(&[1.0])]))
        .says("the first start has 1 numbers, but another has 2");
    assert_named(|| rollout.run_batch(&[two[0]; 2], &[Given::Each(&two)]));
    let other = [&[1.0, 2.0][..]; 2];
    assert_named(|| rollout.run_batch(&[two[0]; 2], &[Given::Each(&other)]))
        .says("parameter 0 of the program has 1 numbers, but 2 were given");
    assert_named(|| rollout.run_batch(&[two[0]; 2], &[Given::Each(&two[..1])]))
        .says("Given::Each must have one slice for each start");
    assert_named(|| Rollout::new(Stuck, 3).run(&[1.0], none));
    assert_named(|| set(|late| late.observed = vec![4]).run(&[1.0], &two[..1]))
        .says("step 4 cannot be observed: the rollout has 3 steps");
    assert_named(|| set(|back| back.observed = vec![2, 1]).run(&[1.0], &two[..1]))
        .says("`observed` is [2, 1]; the steps must be in ascending order");
    assert_named(|| set(|far| far.entries = Some(vec![1])).run(&[1.0], &two[..1]))
        .says("each must be less than 1,");
    assert_named(|| set(|bad| bad.cotangent_units = Some([].into())).run(&[1.0], &two[..1]));
    for bound in [-1.0, f64::NAN] {
        let bad = set(|bad| bad.state_bound = Some(bound));
        assert_named(|| bad.run(&[1.0], &two[..1])).says(&format!("`state_bound` is {bound}"));
        assert_named(|| gradient(|x| bad.run(x, &[x])[0], &[1.0]));
    }
    for (norm, every) in [(1.0, 0), (-1.0, 1), (f64::NAN, 1)] {
        let bad = set(|bad| bad.cotangent_bound = Some(CotangentBound { norm, every }));
        assert_named(|| bad.run(&[1.0], &two[..1])).says(&format!(
            "`cotangent_bound` has `norm` = {norm} and `every` = {every}"
        ));
        assert_named(|| gradient(|x| bad.run(x, &[x])[0], &[1.0]));
    }
    for (len, few) in [
        (2, "but `inputs` has only 2"),
        (0, "but `inputs` has only 0"),
    ] {
        let fed = Rollout {
            inputs: vec![0.0; len].into(),
            ..Rollout::new(Fed, 3)
        };
        assert_named(|| fed.run(&[1.0], &two[..1]))
            .says("3 steps with 1 inputs each need 3 numbers")
            .says(few);
        assert_named(|| gradient(|x| fed.run(x, &[x])[0], &[1.0]));
    }
    let fed = Rollout::new(Fed, 0);
    assert_named(|| fed.run_batch(&[two[0]; 2], &[Given::Each(&[two[0]; 2])]))
        .says("parameter 0 is a matrix, which all starts must share: use `Given::Shared`");
    assert_named(|| Rollout::new(Pushed, 3).run(&[1.0; 2], &two[..1])).says(" over 3 steps, but ");
    // So many steps have more controls than memory could hold.
    let steps = 1 << (usize::BITS - 1);
    assert_named(|| Rollout::new(Pushed, steps).run(&[1.0; 2], none_each)).says(&format!(
        "{} numbers over {steps} steps, but 0 were given",
        usize::MAX
    ));
    let few = set(|few| few.memory = Memory::States(1));
    let factor: &[Var<f64>] = &[Var::lit(1.0)];
    assert_named(|| gradient(|x| few.run(x, &[factor])[0], &[1.0]));
    let shared = [Given::Shared(factor)];
    assert_named(|| gradient(|x| few.run_batch(&[x; 3], &shared)[0][0], &[1.0]));
}

/// Changes a setting of a rollout of three steps.
fn set(change: impl FnOnce(&mut Rollout<Scaled>)) -> Rollout<Scaled> {
    let mut rollout = Rollout::new(Scaled, 3);
    change(&mut rollout);
    rollout
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn programs_name_the_line_of_their_caller() {
    let graph = Graph::new(2, &[[0, 1]]);
    let mut p = Program::default();
    let [one, two, three] = [1, 2, 3].map(|len| p.state(len));
    let slots = p.parameter(graph.slots());
    let (matrix, none): (_, [Array; 0]) = (p.matrix(2, 2), []);
    assert_named(|| p.map(Product, [one, two], &[]));
    assert_named(|| p.map(Nothing, [two], &[]))
        .says("map: the kernel must have at least one result");
    assert_named(|| p.dense(matrix, &[three], two));
    assert_named(|| p.dense_tanh(matrix, &[two], three));
    assert_named(|| p.gather(two, &[Some(2)]));
    assert_named(|| p.map_edges(&graph, Product, [three], &none, &[]));
    assert_named(|| p.solve(&graph, &[two], &none, &[], [two]));
    assert_named(|| p.solve(&graph, &[three], &[slots], &[], [two]));
    assert_named(|| p.advance(two, three));
    assert_named(|| p.advance(slots, three));
    p.advance(three, three);
    assert_named(|| p.advance(three, three)).says("already advanced");
    assert_named(|| p.map(Product, [two, two], &[one]));
    assert_named(|| p.map(Product, [two, two], &[two]));
    assert_named(|| p.map_edges(&graph, Product, [two], &none, &[]));
    assert_named(|| p.map_each_edge(&graph, Product, [two], &[two], &[]));
    assert_named(|| p.sum_at_nodes(&graph, two));
    assert_named(|| p.solve(&graph, &[two], &[slots], &[three], [two]));
    assert_named(|| p.state(usize::MAX));
    assert_named(|| p.input(usize::MAX));
    assert_named(|| p.control(usize::MAX));
    assert_named(|| p.parameter(usize::MAX));
    assert_named(|| Graph::new(2, &[[1, 0]]));
    assert_named(|| Graph::new(2, &[[0, 1]; 2]));
    assert_named(|| graph.without(&[])).says("`marked` must have one value for each edge");
    assert_named(|| graph.to_slots::<f64>(&[]));
    let another = "belongs to another program";
    let mut other = Program::default();
    for shape in [(2, 2), (1, 2), (2, 2)] {
        let foreign = other.matrix(shape.0, shape.1);
        assert_named(|| p.dense(foreign, &[two], two)).says(another);
    }
    // Its length and its place in its program are those of an array of this program.
    let foreign = (0..9).map(|_| other.parameter(2)).last().expect("nine");
    assert_named(|| p.map(Product, [two, foreign], &[])).says(another);
    assert_named(|| p.gather(foreign, &[Some(0)])).says(another);
    assert_named(|| p.map_edges(&graph, Product, [foreign], &[slots], &[])).says(another);
    assert_named(|| p.dense(matrix, &[foreign], two)).says(another);
    assert_named(|| p.advance(two, foreign)).says(another);
}

/// A kernel whose operations depend on a field.
#[derive(Clone)]
struct Power(f64);

#[kernel]
impl Kernel<1, 1> for Power {
    fn eval<R: Real>(&self, [x]: [R; 1], _: &[R]) -> [R; 1] {
        [x.powi(self.0.abs().min(9.0) as i32)]
    }
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn printers_name_the_line_of_their_caller() {
    assert_named(|| emit::adjoint("Power", &["self.0"], |fields| Power(fields[0])));
    assert_named(|| emit::assert_fresh("no/such/file", "", &[]));
}

struct First;

impl Summand for First {
    fn eval<R: Real>(&self, shared: &[R], datum: &[R]) -> R {
        shared[0] * datum[0]
    }
}

struct Total;

impl Function for Total {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        x[0] + x[1]
    }
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn data_name_the_line_of_their_caller() {
    assert_named(|| Sum::new(First, &[vec![1.0], vec![]])).says("must all have the same length");
    let x = [1.0, 2.0];
    let recorded = Recorded::new(&Total, 2).expect("no branch");
    assert_named(|| recorded.values_and_gradients(&[[1.0]]))
        .says("a point has 1 numbers, but the function has 2 arguments");
    assert_named(|| recorded.total(&[&x[..]]))
        .says("given 1 columns, but the function has 2 arguments");
    assert_named(|| recorded.total(&[&x[..], &x[1..]]));
}
