//! A panic about wrong arguments must name the line of the caller, not a line of this crate.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, Location, catch_unwind, set_hook, take_hook};
use std::sync::Once;

use autodiff::data::{Sum, Summand};
use autodiff::sparse::{Pattern, sparse_hessian, sparse_jacobian};
use autodiff::{
    Array, Dual, Given, Graph, Kernel, Model, Program, Real, Rollout, gradient, parallel,
    value_and_gradient_into,
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

impl Kernel<2, 1> for Scaled {
    #[inline(always)]
    fn eval<R: Real>(&self, [x, factor]: [R; 2]) -> [R; 1] {
        [x * factor]
    }
}

impl Model for Scaled {
    fn record<R: Real>(&self, program: &mut Program<R>) {
        let (x, factor) = (program.state(1), program.parameter(1));
        let [next] = program.map(Scaled, [x, factor]);
        program.advance(x, next);
    }
}

/// A model that forgets to advance its state.
#[derive(Clone)]
struct Stuck;

impl Model for Stuck {
    fn record<R: Real>(&self, program: &mut Program<R>) {
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
    let mut late = Rollout::new(Scaled, 3);
    late.observed = vec![4];
    assert_named(|| late.run(&[1.0], &two[..1]));
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn programs_name_the_line_of_their_caller() {
    let graph = Graph::new(2, &[[0, 1]]);
    let mut p = Program::<f64>::default();
    let [one, two, three] = [1, 2, 3].map(|len| p.state(len));
    let slots = p.parameter(graph.slots());
    let (matrix, none): (_, [Array; 0]) = (p.matrix(2, 2), []);
    assert_named(|| p.map(Scaled, [one, two]));
    assert_named(|| p.dense(matrix, &[three], two));
    assert_named(|| p.dense_tanh(matrix, &[two], three));
    assert_named(|| p.gather(two, &[Some(2)]));
    assert_named(|| p.map_edges(&graph, Scaled, [three], &none));
    assert_named(|| p.weighted(two, &[three], &[], &[]));
    assert_named(|| p.solve(&graph, &[two], &none, [two]));
    assert_named(|| p.solve(&graph, &[three], &[slots], [two]));
    assert_named(|| p.any().solve(&graph, &[three], &[slots], [two]));
    assert_named(|| p.any().gather(two, &[Some(2)]));
    assert_named(|| p.advance(two, three));
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
}
