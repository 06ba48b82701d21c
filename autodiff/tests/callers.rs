//! A panic about wrong arguments must say what is wrong, and name the line of the caller, not a line of this crate.

// Each spelling of an operation is tested, also the ones that lints would shorten.
#![allow(clippy::op_ref, clippy::redundant_closure)]

use std::cell::Cell;

use autodiff::check::{Claim, Options, check_directions, check_gradient};
use autodiff::custom::{Rule, apply};
use autodiff::data::{Recorded, Sum, Summand};
use autodiff::fused::{dense, dense_batch};
use autodiff::implicit::{Residual, root, root_within};
use autodiff::matrices;
use autodiff::simd::Lane;
use autodiff::sparse::{Pattern, sparse_hessian, sparse_jacobian};
use autodiff::wgsl::{self, print};
use autodiff::{
    Array, CotangentBound, Dense, DoubleDouble, Dual, Element, Function, Given, Graph, Kernel,
    Memory, Model, Parameters, Program, Real, Rollout, Tape, Var, derivatives_along, emit,
    gradient, hessian_vector, jacobian, jvp, kernel, parallel, parameters, third_derivatives,
    value_and_gradient_into, value_and_jacobian, value_and_jacobian_into,
    value_gradient_hessian_into, vjp,
};
use nalgebra::DMatrix;

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

const NO_BOUND: CotangentBound = CotangentBound {
    norm: 1.0,
    every: 0,
};

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
    assert_named(|| p.weighted(two, &[three], &[], &[]));
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
    assert_named(|| p.weighted(two, &[foreign], &[], &[])).says(another);
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
    let with = |change: fn(&mut wgsl::Options)| {
        let mut options = wgsl::Options::default();
        change(&mut options);
        options
    };
    let printed = |options: &wgsl::Options| print(&Scaled, options);
    assert!(printed(&wgsl::Options::default()).is_ok());
    assert_named(|| print(&Stuck, &wgsl::Options::default()));
    assert_named(|| print(&Scaled, &with(|options| options.common = vec![1])));
    assert_named(|| print(&Scaled, &with(|options| options.wanted = vec![1])));
    assert_named(|| print(&Scaled, &with(|options| options.entries = Some(vec![1]))));
    assert_named(|| print(&Scaled, &with(|options| options.workgroup = 0)));
    assert_named(|| print(&Scaled, &with(|options| options.kept = 0)));
    assert_named(|| print(&Scaled, &with(|options| options.state_bound = Some(-1.0))));
    let endless = with(|options| options.cotangent_bound = Some(NO_BOUND));
    assert_named(|| print(&Scaled, &endless));
    let none = with(|options| options.cotangent_units = Some([].into()));
    assert_named(|| print(&Scaled, &none));
    assert_named(|| emit::adjoint("Power", &["self.0"], |fields| Power(fields[0])));
    assert_named(|| emit::assert_fresh("no/such/file", "", &[]));
}

fn squares<R: Real>(x: &[R]) -> Vec<R> {
    x.iter().map(|&x| x * x).collect()
}

fn product<R: Real>(x: &[R]) -> R {
    x[0] * x[1]
}

struct First;

impl Summand for First {
    fn eval<R: Real>(&self, shared: &[R], datum: &[R]) -> R {
        shared[0] * datum[0]
    }
}

/// A function of a slice with the value of each argument, and a residual and a rule of wrong lengths.
#[derive(Clone)]
struct Odd;

impl Residual for Odd {
    fn eval<R: Real>(&self, x: &[R], _: &[R]) -> Vec<R> {
        vec![x[0]; 2 * x.len()]
    }
}

impl Rule for Odd {
    fn value<R: Real>(&self, x: &[R]) -> R {
        x[0]
    }
    fn partials<R: Real>(&self, _: &[R], _: R) -> Vec<R> {
        Vec::new()
    }
}

impl Function for Odd {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        x[0] + x[1]
    }
}

/// A function that returns more values at every call.
fn growing<T: Copy>() -> impl Fn(&[T]) -> Vec<T> {
    let calls = Cell::new(0);
    move |x| {
        calls.set(calls.get() + 1);
        vec![x[0]; calls.get()]
    }
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn drivers_name_the_line_of_their_caller() {
    let (diagonal, x) = (Pattern::banded(2, 0, 0), [1.0, 2.0]);
    let swapped = |x: &[Dual<f64, 4>]| vec![x[1], x[0]];
    assert_named(|| sparse_jacobian(squares, &x[..1], &diagonal));
    assert_named(|| sparse_jacobian(|x| squares(&x[1..]), &x, &diagonal));
    assert_named(|| sparse_jacobian(swapped, &x, &diagonal))
        .says("value 0 depends on an argument that its row of the pattern leaves out");
    assert_named(|| sparse_hessian(product, &x, &diagonal));
    assert_named(|| parallel::sparse_jacobian(squares, &x[..1], &diagonal));
    assert_named(|| parallel::sparse_jacobian(swapped, &x, &diagonal));
    assert_named(|| diagonal.to_dense(&[1.0]));
    assert_named(|| Pattern::new(1, &[vec![1]]));
    assert_named(|| Pattern::new(3, &[vec![0, 1], vec![2, 1]])).says("row 1 of a pattern");
    assert_named(|| value_and_gradient_into(product, &x, &mut [0.0]))
        .says("`gradient` has 1 numbers; it must have 2");
    assert_named(|| Sum::new(First, &[vec![1.0], vec![]])).says("must all have the same length");
    let nine = [1.0; 9];
    assert_named(|| jacobian(growing(), &nine)).says("number of values must not");
    assert_named(|| value_and_jacobian(growing(), &nine));
    let (mut two, mut four) = ([0.0; 2], [0.0; 4]);
    assert_named(|| value_and_jacobian_into(|x| squares(&x[1..]), &x, &mut two, &mut four))
        .says("`values` has 2 numbers; it must have 1");
    assert_named(|| value_and_jacobian_into(squares, &x, &mut [0.0; 2], &mut [0.0; 3]))
        .says("`jacobian` has 3 numbers; it must have 4");
    assert_named(|| parallel::jacobian(|x| squares(&x[..x[0].tangent[0] as usize + 1]), &nine));
    assert_named(|| value_gradient_hessian_into(product, &x, &mut [0.0], &mut [0.0; 4]));
    assert_named(|| value_gradient_hessian_into(product, &x, &mut [0.0; 2], &mut [0.0; 3]))
        .says("`hessian` has 3 numbers; it must have 4");
    assert_named(|| jvp(squares, &x, &[1.0]));
    assert_named(|| vjp(squares, &x, &[1.0]));
    assert_named(|| hessian_vector(product, &x, &[1.0]));
    assert_named(|| third_derivatives(product, &x).third(0, 1, 2))
        .says("argument 2 is out of range: the function has 2 arguments");
    assert_named(|| derivatives_along(|x| x.to_vec(), &x, &[1.0]));
    assert_named(|| Dense::new(2, 2, vec![0.0]));
    assert_named(|| Dense::new(1, 1, vec![0.0])[1][0]);
    assert_named(|| diagonal.row(2));
    assert_named(|| root(Odd, &x, &x));
    assert_named(|| root_within(Odd, &x, &x, 1.0));
    assert_named(|| apply(Odd, &[Dual::<f64, 1>::variable(1.0, 0)]));
    assert_named(|| gradient(|x| apply(Odd, x), &x));
    assert_named(|| dense(&x, &x, &x));
    assert_named(|| dense_batch(&x, &x, &[]));
    assert_named(|| dense_batch(&[1.0; 6], &[1.0; 4], &[0.0; 2]))
        .says("6 weights, 4 numbers in `x` and 2 biases");
    let recorded = Recorded::new(&Odd, 2).expect("no branch");
    assert_named(|| recorded.values_and_gradients(&[[1.0]]))
        .says("a point has 1 numbers, but the function has 2 arguments");
    assert_named(|| recorded.total(&[&x[..]]))
        .says("given 1 columns, but the function has 2 arguments");
    assert_named(|| recorded.total(&[&x[..], &x[1..]]));
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn checks_name_the_line_of_their_caller() {
    let (x, usual) = ([1.0, 2.0], Options::default());
    let with = |directions, step| Options {
        directions,
        step,
        ..usual.clone()
    };
    let value = |x: &[DoubleDouble]| x[0];
    assert_named(|| check_gradient(&Odd, &x, &with(0, 1e-9))).says("it must be 1 or more");
    assert_named(|| check_gradient(&Odd, &x, &with(4, 0.0))).says("`step` is 0");
    assert_named(|| check_gradient(&Odd, &x, &with(4, f64::INFINITY))).says("`step` is inf");
    assert_named(|| check_gradient(&Odd, &x, &Options::named(vec![String::new()])))
        .says("1 names for 2 components");
    assert_named(|| check_directions(value, &Claim::new(&x, &[1.0]), &usual));
    assert_named(|| check_directions(value, &Claim::new(&[], &[]), &usual));
}

#[derive(Parameters)]
struct Pair<R>([R; 2]);

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn structures_name_the_line_of_their_caller() {
    let pair = Pair([1.0, 2.0]);
    assert_named(|| pair.with(&[1.0]))
        .says("1 numbers are too few for the structure: none is left for `0[1]`");
    assert_named(|| pair.with(&[1.0; 3])).says("1 of 3 numbers do not fit");
    let old = Tape::new().record(&[1.0], |x| x[0]);
    assert_named(|| parameters::gradient(|_| old, &pair));
    assert_named(|| parameters::value_and_gradient(|_| old, &pair));
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn numbers_name_the_line_of_their_caller() {
    let (x, y) = ([1.0, 2.0], [1.0]);
    let dual = Dual::<f64, 2>::constant(1.0);
    assert_named(|| Dual::<f64, 2>::variable(1.0, 2)).says("2 directions");
    assert_named(|| f64::dot(&x, &y));
    assert_named(|| f32::dot(&[1.0], &[1.0_f32, 2.0]));
    assert_named(|| Dual::dot(&[dual], &x));
    assert_named(|| Var::<f64>::dot(&[Var::lit(1.0)], &x));
    assert_named(|| DoubleDouble::dot(&[DoubleDouble::lit(1.0)], &x));
    assert_named(|| num_traits::Float::integer_decode(Element(1.0)));
    assert_named(|| <f64 as Lane<f64>>::load(&[]));
    assert_named(|| Lane::<f64>::store(1.0_f64, &mut []));
    assert_named(|| <f64 as Lane<f64>>::load_part(&x));
    assert_named(|| Lane::<f64>::store_part(1.0_f64, &mut [0.0]));
    let (tall, nan) = (DMatrix::zeros(2, 1), Element(f64::NAN));
    assert_named(|| matrices::exp::<f64>(&tall)).says("found 2 x 1");
    assert_named(|| matrices::determinant(&tall)).says("found 2 x 1");
    assert_named(|| matrices::exp(&DMatrix::from_element(1, 1, nan))).says("the norm is NaN");
    let vectors = [1, 2].map(nalgebra::DVector::<Element<f64>>::zeros);
    assert_named(|| matrices::angle(&vectors[0], &vectors[1])).says("differ in length");
}
