//! Misuse that a tape must refuse, naming the line of the caller, and operations that it must not record.

// Each spelling of an operation is tested, also the ones that lints would shorten.
#![allow(clippy::op_ref, clippy::redundant_closure)]

use std::cell::Cell;

use crate::common::{Refusal, Sym, assert_named, assert_refused, panic_message};
use autodiff::custom::{Rule, apply};
use autodiff::fused::dense;
use autodiff::real::Accepts;
use autodiff::sparse::{Pattern, Undecided, sparse_hessian};
use autodiff::{
    Dual, Element, Real, Tape, Var, gradient, hessian, hessian_vector, jacobian_reverse, parallel,
    value_and_gradient, value_and_gradient_into, value_gradient_hessian, vjp,
};

#[test]
fn variables_are_small_and_go_anywhere() {
    fn goes_anywhere<T: Copy + Send + Sync + 'static>() {}
    fn is_send<T: Send>() {}
    goes_anywhere::<Var<f64>>();
    goes_anywhere::<Var<Var<Dual<f32, 3>>>>();
    is_send::<Tape<Dual<f64, 2>>>();
    assert_eq!(size_of::<Var<f64>>(), 16);
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn a_variable_on_another_thread_is_refused() {
    Tape::new().record(&[1.0], |x| {
        let x = x[0];
        let stale = move || assert_refused("its tape is not recording", move || x * x);
        let elsewhere = std::thread::spawn(stale);
        elsewhere.join().expect("the panic is caught over there");
    });
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn variables_of_two_tapes_do_not_mix() {
    type Join = fn(Var<f64>, Var<f64>) -> Var<f64>;
    for join in [|x, y| x * y, |x, y| Var::sum_of(&[x, y])] as [Join; 2] {
        assert_refused("to nest tapes", || {
            let inner = |x| gradient(|y| join(x, y[0]), &[1.0])[0];
            gradient(|x| Var::constant(inner(x[0])), &[1.0]);
        });
    }
}

#[test]
fn an_outer_tape_of_the_same_type_still_records_inside() {
    let outer = gradient(
        |x| {
            let inner = gradient(|y| y[0] * y[0], &[3.0]);
            let mut product = x[0];
            Tape::new().record(&inner, |_| product *= x[0]);
            product * Var::constant(inner[0])
        },
        &[5.0],
    );
    assert_eq!(outer, [60.0]);
}

thread_local! {
    static HELD: Cell<Var<f64>> = Cell::new(Var::constant(0.0));
}

/// A conversion that records on the tape of the product: it returns the square of the variable that the thread holds.
impl Accepts<Sym> for Var<f64> {
    fn accept(_: Sym) -> Self {
        let x = HELD.get();
        Var::dot(&[x], &[x])
    }
}

#[test]
fn a_conversion_may_record() {
    let cube = |x: &[Var<f64>]| {
        HELD.set(x[0]);
        Var::dot(x, &[Sym::lit(0.0)])
    };
    assert_eq!(gradient(cube, &[3.0]), [27.0]);
}

/// A recording and its sweep must not use the stack for each operation.
#[test]
fn a_chain_of_a_million_operations_needs_no_stack() {
    const LENGTH: usize = if cfg!(miri) { 1000 } else { 1_000_000 };
    let chain = |x: &[Var<f64>]| (0..LENGTH).fold(x[0], |y, _| -y);
    assert_eq!(gradient(chain, &[1.0]), [1.0]);
    let sum = |x: &[Var<f64>]| (0..LENGTH).map(|_| x[0]).sum();
    assert_eq!(gradient(sum, &[1.0]), [LENGTH as f64]);
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn a_panic_inside_leaves_the_outer_recording_current() {
    let gradient = gradient(
        |x| {
            let inner = || gradient(|_| panic!("on purpose"), &[1.0]);
            assert_eq!(panic_message(inner), "on purpose");
            x[0] * x[0]
        },
        &[2.0],
    );
    assert_eq!(gradient, [4.0]);
}

#[test]
#[cfg_attr(target_family = "wasm", ignore = "no threads")]
fn a_tape_moves_between_threads() {
    let mut tape = Tape::new();
    let y = tape.record(&[2.0], |x| x[0] * x[0]);
    let there = std::thread::spawn(move || tape.pullback(&[y], &[1.0]).to_vec());
    assert_eq!(there.join().expect("no panic"), [4.0]);
}

#[test]
fn constants_are_not_recorded() {
    let mut tape = Tape::new();
    let y = tape.record(&[2.0], |x| {
        let constant = Var::lit(3.0).sqrt() * Var::lit(2.0) + x[0].detach();
        let _ = Var::select(x[0].less(constant), x[0], constant);
        let _ = Var::dot(&[constant, constant], &[constant, constant]);
        constant
    });
    assert_eq!(tape.len(), 1, "the input alone");
    assert_eq!(tape.pullback(&[y], &[1.0]), [0.0]);
    tape.record(&[2.0], |x| x[0] * Var::lit(3.0) + Var::lit(1.0));
    assert_eq!(
        tape.len(),
        2,
        "input, product; the sum is the product, moved"
    );
    tape.record(&[2.0], |x| (x[0] - Var::lit(3.0)) * (Var::lit(1.0) + x[0]));
    assert_eq!(tape.len(), 2, "input, product of one parent");
    tape.record(&[2.0, 3.0], |x| Var::dot(&[x[0]; 50], &[x[1]; 50]));
    assert_eq!(tape.len(), 3, "two inputs, one dot product");
}

#[test]
fn an_empty_tape_says_so() {
    let mut tape = Tape::new();
    assert!(tape.is_empty());
    tape.record(&[2.0], |_| ());
    assert!(!tape.is_empty(), "an input is an entry");
    tape.record(&[] as &[f64], |_| ());
    assert!(tape.is_empty(), "the last recording counts");
}

type Join = fn(Var<f64>, Var<f64>) -> Var<f64>;

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn variables_of_two_recordings_name_the_line_of_the_operation() {
    let old = Tape::new().record(&[1.0], |x| x[0]);
    let joined = |join: Join| gradient(|x| join(x[0], old), &[1.0]);
    // A variable of the running recording is used too, so the message names both possible causes.
    let both = |refusal: Refusal| refusal.says("to an earlier recording").says("two tapes");
    both(assert_named(|| joined(|x, old| x + old)));
    assert_named(|| joined(|x, old| x - old));
    assert_named(|| joined(|x, old| x * old));
    assert_named(|| joined(|x, old| x / old));
    assert_named(|| joined(|x, old| &x * &old));
    assert_named(|| joined(|x, old| x.powf(old)));
    assert_named(|| joined(|x, old| x.xlogy(old)));
    assert_named(|| joined(|x, old| x.fma(old, x)));
    assert_named(|| joined(|x, old| x.fma(x, old)));
    both(assert_named(|| joined(|x, old| Var::dot(&[x], &[old]))));
    assert_named(|| joined(|x, old| Var::dot(&[x, x], &[x, old])));
    both(assert_named(|| joined(|x, old| Var::sum_of(&[x, old]))));
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
    let undecided = Tape::new().record(&Undecided::lits(&[1.0]), |x| x[0]);
    assert_named(|| Pattern::traced(|_| vec![undecided], &[1.0]));
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
    let stale = "its tape is not recording";
    assert_named(|| old + old).says(stale);
    assert_named(|| Tape::new().record(&[1.0], |_| old + old)).says(stale);
    assert_named(|| -old);
    assert_named(|| old * 2.0);
    assert_named(|| 2.0 / old);
    assert_named(|| old.sqrt()).says(stale);
    assert_named(|| old.cbrt());
    assert_named(|| old.abs());
    assert_named(|| old.powi(3));
    assert_named(|| old.powf(0.5));
    assert_named(|| old.scale(3.0));
    assert_named(|| Var::logsumexp(&[old, old]));
    assert_named(|| Var::dot(&[old], &[2.0]));
    assert_named(|| Var::sum_of(&[old, old])).says(stale);
    assert_named(|| dense(&[old], &[Var::lit(1.0)], &[Var::lit(1.0)]));
    let mut y = old;
    assert_named(|| y *= old);
    assert_named(|| y += old * old);
    assert_named(|| y -= &(old * old));
    assert_named(|| y /= old);
    assert_named(|| y *= 2.0);
    let mut tape = Tape::new();
    tape.record(&[1.0], |_| ());
    let refusal = assert_named(|| tape.pullback(&[old], &[1.0]).len())
        .says("a variable of another tape or of an earlier recording");
    assert!(!refusal.0.contains("left:"), "{}", refusal.0);
    assert_named(|| tape.pullback(&[], &[1.0]).len()).says("one cotangent for each output");
}
