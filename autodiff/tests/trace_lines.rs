//! The line that a trace reports must be the caller's, for every spelling of an operation. Methods that one macro defines
//! have one row.

// Each spelling of an operation is tested, also the ones that lints would shorten.
#![allow(clippy::op_ref, clippy::redundant_closure)]

use std::panic::Location;

use autodiff::custom::{Rule, apply};
use autodiff::fused::{dense, dense_batch};
use autodiff::trace::{Traced, first_non_finite};
use autodiff::{Element, Real, Var, gradient, lit};
use nalgebra::{ComplexField, RealField};
use num_traits::{Float, Signed};

type Number = Traced<f64>;

/// Asserts that a trace of the closure, which must be on the line of this call, reports this line.
#[track_caller]
fn assert_named(at: f64, function: fn(Number) -> Number) {
    let here = Location::caller();
    let found = first_non_finite(|x| vec![function(x[0])], &[at]).expect("an infinity or NaN");
    let named = (found.place.file(), found.place.line());
    assert_eq!(named, (here.file(), here.line()), "{found}");
}

fn c(value: f64) -> Number {
    Number::lit(value)
}

/// An element of a matrix; the short name keeps each call on the line of its assertion.
fn e(x: Number) -> Element<Number> {
    Element(x)
}

const NAN: f64 = f64::NAN;
const HUGE: f64 = 1e308;

#[test]
fn functions_of_one_number() {
    assert_named(0.0, |x| x.sqrt());
    assert_named(0.0, |x| (x + NAN).sin_cos().1);
    assert_named(0.0, |x| (x + NAN).atan());
    assert_named(0.0, |x| (x + NAN).abs());
    assert_named(1.0, |x| x.asin());
    assert_named(0.0, |x| x.elementary(autodiff::Elementary::Cbrt));
}

#[test]
fn functions_of_several_numbers() {
    assert_named(0.0, |x| x.powi(-2));
    assert_named(0.0, |x| x.powf(0.5));
    assert_named(HUGE, |x| x.scale(10.0));
    assert_named(HUGE, |x| x.fma(x, x));
    assert_named(0.0, |x| x.xlogy(0.0));
    assert_named(2.0, |x| x.xlogy(0.0));
    assert_named(0.0, |x| x.xlogy(x));
    assert_named(0.0, |x| c(2.0).xlogy(x));
    assert_named(0.0, |x| x.ln_beta(2.0));
    assert_named(HUGE, |x| x.ln_beta(x));
    assert_named(HUGE, |x| Number::chain(x, x));
    assert_named(HUGE, |x| Number::chain_add(x, x, x));
    assert_named(HUGE, |x| Number::dot(&[x, x], &[x, x]));
    assert_named(HUGE, |x| Number::dot(&[x], &[10.0]));
    assert_named(HUGE, |x| Number::sum_of(&[x, x]));
    assert_named(HUGE, |x| Number::norm(&[x; 4]));
    assert_named(HUGE, |x| Number::logsumexp(&[x * 0.5 + NAN, x]));
    assert_named(HUGE, |x| dense(&[x], &[x], &[x])[0]);
    assert_named(HUGE, |x| dense_batch(&[x], &[x; 9], &[x])[8]);
    assert_named(0.0, |x| apply(Reciprocal, &[x]));
}

/// The reciprocal, with a value and partials that are computed here.
#[derive(Clone)]
struct Reciprocal;

impl Rule for Reciprocal {
    #[track_caller]
    fn value<R: Real>(&self, _: &[R]) -> R {
        R::zero()
    }
    fn partials<R: Real>(&self, x: &[R], _: R) -> Vec<R> {
        vec![-(x[0] * x[0]).recip()]
    }
}

#[test]
fn operators() {
    assert_named(HUGE, |x| x + x);
    assert_named(HUGE, |x| &x + &x);
    assert_named(HUGE, |x| x + HUGE);
    assert_named(HUGE, |x| HUGE + x);
    assert_named(HUGE, |x| x + lit(HUGE));
    assert_named(HUGE, |x| lit(HUGE) + x);
    assert_named(HUGE, |x| x - c(-HUGE));
    assert_named(HUGE, |x| x - -HUGE);
    assert_named(HUGE, |x| -HUGE - x);
    assert_named(HUGE, |x| x * x);
    assert_named(HUGE, |x| x * &x);
    assert_named(HUGE, |x| 10.0 * x);
    assert_named(HUGE, |x| 10.0 * &x);
    assert_named(HUGE, |x| lit(10.0) * x);
    assert_named(HUGE, |x| x * lit(10.0));
    assert_named(0.0, |x| 1.0 / x);
    assert_named(0.0, |x| lit(1.0) / x);
    assert_named(1.0, |x| x / 0.0);
    assert_named(1.0, |x| x / lit(0.0));
    assert_named(1.0, |x| -(&x / 0.0));
    assert_named(HUGE, |x| assigned(x, |y| *y += x));
    assert_named(HUGE, |x| assigned(x, |y| *y -= -HUGE));
    assert_named(HUGE, |x| assigned(x, |y| *y *= &x));
    assert_named(HUGE, |x| assigned(x, |y| *y /= lit(0.0)));
}

fn assigned(mut x: Number, assign: impl FnOnce(&mut Number)) -> Number {
    assign(&mut x);
    x
}

#[test]
fn spellings_of_num_traits() {
    assert_named(0.0, |x| Float::sqrt(Element(x)).0);
    assert_named(1e4, |x| Float::exp2(Element(x)).0);
    assert_named(0.0, |x| Float::log(Element(x), Element(c(3.0))).0);
    assert_named(0.0, |x| Float::powi(Element(x), -1).0);
    assert_named(0.0, |x| Float::powf(Element(x), Element(c(0.5))).0);
    assert_named(0.0, |x| Float::hypot(Element(x), Element(c(NAN))).0);
    assert_named(0.0, |x| Float::atan2(Element(x), Element(c(NAN))).0);
    assert_named(HUGE, |x| Float::mul_add(e(x), e(x), e(x)).0);
    assert_named(HUGE, |x| Float::to_degrees(Element(x)).0);
    assert_named(HUGE, |x| Float::abs_sub(Element(x), Element(c(-HUGE))).0);
    assert_named(HUGE, |x| (Element(x) * Element(x)).0);
    assert_named(HUGE, |x| (Element(x) * 10.0).0);
    assert_named(HUGE, |x| (10.0 * Element(x)).0);
    assert_named(0.0, |x| (Element(c(1.0)) / Element(x)).0);
    assert_named(HUGE, |x| Signed::abs_sub(&e(x), &e(c(-HUGE))).0);
}

#[test]
fn spellings_of_nalgebra() {
    assert_named(0.0, |x| ComplexField::sqrt(Element(x)).0);
    assert_named(0.0, |x| ComplexField::powc(Element(x), Element(c(0.5))).0);
    assert_named(0.0, |x| ComplexField::sinc(Element(x + NAN)).0);
    assert_named(1e3, |x| ComplexField::sinhc(Element(x)).0);
    assert_named(HUGE, |x| ComplexField::modulus_squared(Element(x)).0);
    assert_named(HUGE, |x| ComplexField::scale(Element(x), Element(x)).0);
    assert_named(1.0, |x| ComplexField::unscale(e(x), e(c(0.0))).0);
    assert_named(0.0, |x| RealField::atan2(Element(x), Element(c(NAN))).0);
}

/// Derivatives inside a traced function are traced too.
#[test]
fn operations_of_an_inner_tape() {
    assert_named(0.0, |x| gradient(|y| y[0].sqrt(), &[x])[0]);
    assert_named(0.0, |x| gradient(|y| y[0].cbrt(), &[x])[0]);
    assert_named(HUGE, |x| gradient(|y| y[0] * y[0] * 4.0, &[x])[0]);
    assert_named(HUGE, |x| gradient(|y| Var::dot(y, y), &[x * 2.0])[0]);
}
