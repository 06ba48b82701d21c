//! A panic about wrong arguments must say what is wrong, and name the line of the caller, not a line of this crate.

// Each spelling of an operation is tested, also the ones that lints would shorten.
#![allow(clippy::op_ref, clippy::redundant_closure)]

use std::cell::Cell;

use autodiff::check::{Claim, Options, check_directions, check_gradient};
use autodiff::custom::{Rule, apply};
use autodiff::fused::{dense, dense_batch};
use autodiff::implicit::{Residual, root, root_within};
use autodiff::matrices;
use autodiff::simd::Lane;
use autodiff::sparse::{Pattern, sparse_hessian, sparse_jacobian};
use autodiff::{
    Dense, DoubleDouble, Dual, Element, Function, Parameters, Real, Tape, Var, derivatives_along,
    gradient, hessian_vector, jacobian, jvp, parallel, parameters, third_derivatives,
    value_and_gradient_into, value_and_jacobian, value_and_jacobian_into,
    value_gradient_hessian_into, vjp,
};
use nalgebra::DMatrix;

use crate::common::assert_named;

fn squares<R: Real>(x: &[R]) -> Vec<R> {
    x.iter().map(|&x| x * x).collect()
}

fn product<R: Real>(x: &[R]) -> R {
    x[0] * x[1]
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
