//! A panic about wrong arguments must name the line of the caller, not a line of this crate.

// Each spelling of an operation is tested, also the ones that lints would shorten.
#![allow(clippy::op_ref, clippy::redundant_closure)]

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, Location, catch_unwind, set_hook, take_hook};
use std::sync::Once;

use autodiff::check::{Claim, Options, check_directions, check_gradient};
use autodiff::custom::{Rule, apply};
use autodiff::data::{Recorded, Sum, Summand};
use autodiff::fused::{dense, dense_batch};
use autodiff::implicit::{Residual, root, root_within};
use autodiff::simd::Lane;
use autodiff::sparse::{Pattern, sparse_hessian, sparse_jacobian};
use autodiff::wgsl::{self, print};
use autodiff::{
    Array, CotangentBound, Dense, DoubleDouble, Dual, Dual2, Element, Function, Given, Graph,
    Kernel, Memory, Model, Nested, Parameters, Program, Real, Rollout, Tape, Var, emit, gradient,
    hessian, hessian_vector, jacobian, jacobian_reverse, jvp, kernel, parallel, parameters,
    third_derivatives, value_and_gradient, value_and_gradient_into, value_and_jacobian,
    value_and_jacobian_into, value_gradient_hessian, value_gradient_hessian_into, vjp,
};

thread_local! {
    /// The file and the line of the thread's last panic.
    static LAST: Cell<Option<(String, u32)>> = const { Cell::new(None) };
}

/// Sets a panic hook that notes the place of every panic and passes the panic on.
fn note_places() {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = take_hook();
        set_hook(Box::new(move |info| {
            LAST.set(info.location().map(|at| (at.file().to_owned(), at.line())));
            before(info);
        }));
    });
}

/// Asserts that a closure, which must be on the line of this call, panics and that the panic names this line.
#[track_caller]
fn assert_named<T>(action: impl FnOnce() -> T) {
    note_places();
    let (here, result) = (Location::caller(), catch_unwind(AssertUnwindSafe(action)));
    assert!(result.is_err(), "misuse must panic");
    let named = LAST.take().expect("every panic has a place");
    assert_eq!(named, (here.file().to_owned(), here.line()));
}

/// `x -> x * factor`, in every step.
#[derive(Clone)]
struct Scaled;

#[kernel]
impl Kernel<2, 1> for Scaled {
    fn eval<R: Real>(&self, [x, factor]: [R; 2], _: &[R]) -> [R; 1] {
        [x * factor]
    }
}

impl Model for Scaled {
    fn record(&self, program: &mut Program) {
        let (x, factor) = (program.state(1), program.parameter(1));
        let [next] = program.map(Scaled, [x, factor], &[]);
        program.advance(x, next);
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
    let (two, none): ([&[f64]; 2], &[&[f64]]) = ([&[1.0], &[1.0, 2.0]], &[]);
    assert_named(|| rollout.run(&[1.0], none));
    assert_named(|| rollout.run(&[1.0, 2.0], &two[..1]));
    assert_named(|| rollout.run(&[1.0], &two[1..]));
    assert_named(|| rollout.run(&[Dual::<_, 2>::variable(1.0, 0)], &[]));
    assert_named(|| gradient(|x| rollout.run(x, &[])[0], &[1.0]));
    assert_named(|| rollout.unrolled(&[1.0], none));
    assert_named(|| rollout.run_batch(&two, &[Given::Shared(&[1.0])]));
    assert_named(|| rollout.run_batch(&[two[0]; 2], &[Given::Each(&two)]));
    assert_named(|| rollout.run_batch(&[two[0]; 2], &[Given::Each(&two[..1])]));
    assert_named(|| Rollout::new(Stuck, 3).run(&[1.0], none));
    assert_named(|| set(|late| late.observed = vec![4]).run(&[1.0], &two[..1]));
    assert_named(|| set(|back| back.observed = vec![2, 1]).run(&[1.0], &two[..1]));
    assert_named(|| set(|far| far.entries = Some(vec![1])).run(&[1.0], &two[..1]));
    assert_named(|| set(|bad| bad.state_bound = Some(-1.0)).run(&[1.0], &two[..1]));
    assert_named(|| set(|bad| bad.cotangent_units = Some([].into())).run(&[1.0], &two[..1]));
    assert_named(|| set(|bad| bad.cotangent_bound = Some(NO_BOUND)).run(&[1.0], &two[..1]));
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
    assert_named(|| p.map(Scaled, [one, two], &[]));
    assert_named(|| p.dense(matrix, &[three], two));
    assert_named(|| p.dense_tanh(matrix, &[two], three));
    assert_named(|| p.gather(two, &[Some(2)]));
    assert_named(|| p.map_edges(&graph, Scaled, [three], &none, &[]));
    assert_named(|| p.weighted(two, &[three], &[], &[]));
    assert_named(|| p.solve(&graph, &[two], &none, &[], [two]));
    assert_named(|| p.solve(&graph, &[three], &[slots], &[], [two]));
    assert_named(|| p.advance(two, three));
    assert_named(|| p.advance(slots, three));
    assert_named(|| p.map(Scaled, [two, two], &[one]));
    assert_named(|| p.map(Scaled, [two, two], &[two]));
    assert_named(|| p.map_edges(&graph, Scaled, [two], &none, &[]));
    assert_named(|| p.map_each_edge(&graph, Scaled, [two], &[two], &[]));
    assert_named(|| p.sum_at_nodes(&graph, two));
    assert_named(|| p.solve(&graph, &[two], &[slots], &[three], [two]));
    assert_named(|| p.state(usize::MAX));
    assert_named(|| p.input(usize::MAX));
    assert_named(|| p.control(usize::MAX));
    assert_named(|| p.parameter(usize::MAX));
    assert_named(|| Graph::new(2, &[[1, 0]]));
    assert_named(|| Graph::new(2, &[[0, 1]; 2]));
    assert_named(|| graph.without(&[]));
    assert_named(|| graph.to_slots::<f64>(&[]));
    let other = Program::default().matrix(3, 3);
    assert_named(|| p.dense(other, &[two], two));
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
    assert_named(|| sparse_jacobian(swapped, &x, &diagonal));
    assert_named(|| sparse_hessian(product, &x, &diagonal));
    assert_named(|| parallel::sparse_jacobian(squares, &x[..1], &diagonal));
    assert_named(|| parallel::sparse_jacobian(swapped, &x, &diagonal));
    assert_named(|| diagonal.to_dense(&[1.0]));
    assert_named(|| Pattern::new(1, &[vec![1]]));
    assert_named(|| value_and_gradient_into(product, &x, &mut [0.0]));
    assert_named(|| Sum::new(First, &[vec![1.0], vec![]]));
    let nine = [1.0; 9];
    assert_named(|| jacobian(growing(), &nine));
    assert_named(|| value_and_jacobian(growing(), &nine));
    let (mut two, mut four) = ([0.0; 2], [0.0; 4]);
    assert_named(|| value_and_jacobian_into(|x| squares(&x[1..]), &x, &mut two, &mut four));
    assert_named(|| value_and_jacobian_into(squares, &x, &mut [0.0; 2], &mut [0.0; 3]));
    assert_named(|| parallel::jacobian(|x| squares(&x[..x[0].tangent[0] as usize + 1]), &nine));
    assert_named(|| value_gradient_hessian_into(product, &x, &mut [0.0], &mut [0.0; 4]));
    assert_named(|| value_gradient_hessian_into(product, &x, &mut [0.0; 2], &mut [0.0; 3]));
    assert_named(|| jvp(squares, &x, &[1.0]));
    assert_named(|| vjp(squares, &x, &[1.0]));
    assert_named(|| hessian_vector(product, &x, &[1.0]));
    assert_named(|| third_derivatives(product, &x).third(0, 1, 2));
    assert_named(|| Dual2::<f64>::variable_at(1.0).derivative(3));
    assert_named(|| Dense::new(2, 2, vec![0.0]));
    assert_named(|| Dense::new(1, 1, vec![0.0])[1][0]);
    assert_named(|| diagonal.row(2));
    assert_named(|| root(Odd, &x, &x));
    assert_named(|| root_within(Odd, &x, &x, 1.0));
    assert_named(|| apply(Odd, &[Dual::<f64, 1>::variable(1.0, 0)]));
    assert_named(|| gradient(|x| apply(Odd, x), &x));
    assert_named(|| dense(&x, &x, &x));
    assert_named(|| dense_batch(&x, &x, &[]));
    let recorded = Recorded::new(&Odd, 2).expect("no branch");
    assert_named(|| recorded.values_and_gradients(&[[1.0]]));
    assert_named(|| recorded.total(&[&x[..]]));
    assert_named(|| recorded.total(&[&x[..], &x[1..]]));
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn checks_name_the_line_of_their_caller() {
    let (x, usual) = ([1.0, 2.0], Options::default());
    let none = Options {
        directions: 0,
        ..usual.clone()
    };
    let value = |x: &[DoubleDouble]| x[0];
    assert_named(|| check_gradient(&Odd, &x, &none));
    assert_named(|| check_gradient(&Odd, &x, &Options::named(vec![String::new()])));
    assert_named(|| check_directions(value, &Claim::new(&x, &[1.0]), &usual));
    assert_named(|| check_directions(value, &Claim::new(&[], &[]), &usual));
}

#[derive(Parameters)]
struct Pair<R>([R; 2]);

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn structures_name_the_line_of_their_caller() {
    let pair = Pair([1.0, 2.0]);
    assert_named(|| pair.with(&[1.0]));
    assert_named(|| pair.with(&[1.0; 3]));
    let old = Tape::new().record(&[1.0], |x| x[0]);
    assert_named(|| parameters::gradient(|_| old, &pair));
    assert_named(|| parameters::value_and_gradient(|_| old, &pair));
}

type Join = fn(Var<f64>, Var<f64>) -> Var<f64>;

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn variables_of_two_recordings_name_the_line_of_the_operation() {
    let old = Tape::new().record(&[1.0], |x| x[0]);
    let joined = |join: Join| gradient(|x| join(x[0], old), &[1.0]);
    assert_named(|| joined(|x, old| x + old));
    assert_named(|| joined(|x, old| x - old));
    assert_named(|| joined(|x, old| x * old));
    assert_named(|| joined(|x, old| x / old));
    assert_named(|| joined(|x, old| &x * &old));
    assert_named(|| joined(|x, old| x.hypot(old)));
    assert_named(|| joined(|x, old| x.atan2(old)));
    assert_named(|| joined(|x, old| x.powf(old)));
    assert_named(|| joined(|x, old| x.xlogy(old)));
    assert_named(|| joined(|x, old| x.fma(old, x)));
    assert_named(|| joined(|x, old| x.fma(x, old)));
    assert_named(|| joined(|x, old| Var::dot(&[x], &[old])));
    assert_named(|| joined(|x, old| Var::dot(&[x, x], &[x, old])));
    assert_named(|| joined(|x, old| Var::sum_of(&[x, old])));
    assert_named(|| joined(|x, old| Var::norm(&[x, old])));
    assert_named(|| joined(|x, old| Var::logsumexp(&[x, old])));
    assert_named(|| joined(|x, old| dense(&[x], &[old], &[x])[0]));
    assert_named(|| joined(|x, old| apply(Sound, &[x, old])));
    assert_named(|| joined(|x, old| (Element(x) * Element(old)).0));
    assert_named(|| joined(|x, old| num_traits::Float::hypot(Element(x), Element(old)).0));
    assert_named(|| joined(|x, old| Var::chain(x, old)));
    // A result of another recording is refused by the driver.
    assert_named(|| gradient(|_| old, &[1.0]));
    assert_named(|| value_and_gradient(|_| old, &[1.0]));
    assert_named(|| value_and_gradient_into(|_| old, &[1.0], &mut [0.0]));
    assert_named(|| vjp(|_| vec![old], &[1.0], &[1.0]));
    assert_named(|| jacobian_reverse(|_| vec![old], &[1.0]));
    assert_named(|| parallel::jacobian_reverse(|_| vec![old], &[1.0]));
    assert_named(|| Pattern::traced(|_| vec![old], &[1.0]));
    let outer = Tape::new().record(&[Dual::constant(1.0)], |x| x[0]);
    assert_named(|| hessian(|_| outer, &[1.0]));
    assert_named(|| hessian_vector(|_| seconds(), &[1.0], &[1.0]));
    assert_named(|| value_gradient_hessian(|_| outer, &[1.0]));
    assert_named(|| sparse_hessian(|_| outer, &[1.0], &Pattern::banded(1, 0, 0)));
}

fn seconds() -> Var<Dual<f64, 1>> {
    Tape::new().record(&[Dual::constant(1.0)], |x| x[0])
}

/// A rule of two arguments.
#[derive(Clone)]
struct Sound;

impl Rule for Sound {
    fn value<R: Real>(&self, x: &[R]) -> R {
        x[0]
    }
    fn partials<R: Real>(&self, _: &[R], _: R) -> Vec<R> {
        vec![R::one(), R::zero()]
    }
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn variables_outside_their_closure_name_the_line_of_the_operation() {
    let old = Tape::new().record(&[1.0], |x| x[0]);
    assert_named(|| old + old);
    assert_named(|| -old);
    assert_named(|| old * 2.0);
    assert_named(|| 2.0 / old);
    assert_named(|| old.sqrt());
    assert_named(|| old.cbrt());
    assert_named(|| old.ln_1p());
    assert_named(|| old.erf());
    assert_named(|| old.abs());
    assert_named(|| old.tan());
    assert_named(|| old.powi(3));
    assert_named(|| old.powf(0.5));
    assert_named(|| old.scale(3.0));
    assert_named(|| Var::logsumexp(&[old, old]));
    assert_named(|| Var::dot(&[old], &[2.0]));
    assert_named(|| Var::sum_of(&[old, old]));
    assert_named(|| dense(&[old], &[Var::lit(1.0)], &[Var::lit(1.0)]));
    let mut y = old;
    assert_named(|| y *= old);
    assert_named(|| y += old * old);
    assert_named(|| y -= &(old * old));
    assert_named(|| y /= old);
    assert_named(|| y *= 2.0);
    let mut tape = Tape::new();
    assert_named(|| tape.pullback(&[old], &[1.0]).len());
    assert_named(|| tape.pullback(&[], &[1.0]).len());
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn numbers_name_the_line_of_their_caller() {
    let (x, y) = ([1.0, 2.0], [1.0]);
    let dual = Dual::<f64, 2>::constant(1.0);
    assert_named(|| Dual::<f64, 2>::variable(1.0, 2));
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
    let (tall, far) = (nalgebra::DMatrix::zeros(2, 1), f64::INFINITY);
    assert_named(|| autodiff::matrices::exp::<f64>(&tall));
    assert_named(|| autodiff::matrices::exp(&nalgebra::DMatrix::from_element(1, 1, Element(far))));
    let vectors = [1, 2].map(nalgebra::DVector::<Element<f64>>::zeros);
    assert_named(|| autodiff::matrices::angle(&vectors[0], &vectors[1]));
}
