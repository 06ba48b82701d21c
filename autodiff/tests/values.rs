//! Drivers that return the value with the derivatives: they evaluate the function no more often than the derivatives
//! alone, and buffers of the caller get the same bits.

use std::cell::Cell;

use autodiff::{
    Real, gradient, hessian, jacobian, value_and_gradient, value_and_gradient_into,
    value_and_jacobian, value_and_jacobian_into, value_gradient_hessian,
    value_gradient_hessian_into,
};

/// Three functions of all arguments.
fn several<R: Real>(x: &[R]) -> Vec<R> {
    let sum = R::sum_of(x);
    vec![sum.sin(), (sum * sum).exp_m1(), R::dot(x, x)]
}

fn scalar<R: Real>(x: &[R]) -> R {
    several(x).into_iter().product()
}

/// The numbers of arguments need no pass, part of a pass, one pass and several passes.
fn points() -> impl Iterator<Item = Vec<f64>> {
    let point = |n: usize| (0..n).map(|i| 0.3 - 0.1 * i as f64).collect();
    [0, 1, 3, 4, 9].into_iter().map(point)
}

#[test]
fn values_come_with_their_derivatives() {
    for x in points() {
        let (values, entries) = value_and_jacobian(several, &x);
        assert_eq!((values, entries), (several(&x), jacobian(several, &x)));
        let (value, slopes, second) = value_gradient_hessian(scalar, &x);
        assert_eq!((value, second), (scalar(&x), hessian(scalar, &x)));
        // The rules round differently on duals than on floats. A slope is a product of three factors of a few operations.
        let expected = gradient(scalar, &x);
        let close = |(a, b): (&f64, &f64)| (a - b).abs() <= 64.0 * f64::EPSILON * b.abs();
        assert!(
            slopes.iter().zip(&expected).all(close),
            "{slopes:?}, {expected:?}"
        );
    }
}

#[test]
fn buffers_of_the_caller_get_the_same_bits() {
    for x in points() {
        let n = x.len();
        let (mut values, mut entries) = ([f64::NAN; 3], vec![f64::NAN; 3 * n]);
        value_and_jacobian_into(several, &x, &mut values, &mut entries);
        let expected = value_and_jacobian(several, &x);
        assert_eq!(
            (values.to_vec(), entries),
            (expected.0, expected.1.into_vec())
        );
        let mut slopes = vec![f64::NAN; n];
        let value = value_and_gradient_into(scalar, &x, &mut slopes);
        assert_eq!((value, slopes.clone()), value_and_gradient(scalar, &x));
        let mut second = vec![f64::NAN; n * n];
        let value = value_gradient_hessian_into(scalar, &x, &mut slopes, &mut second);
        let expected = value_gradient_hessian(scalar, &x);
        assert_eq!((value, slopes), (expected.0, expected.1));
        assert_eq!(second, expected.2.into_vec());
    }
}

/// A Newton step with two arguments must evaluate the function once, not once for the value and once for the
/// derivatives.
#[test]
fn the_value_takes_no_evaluation_of_its_own() {
    let calls = Cell::new(0);
    let count = || calls.set(calls.get() + 1);
    let x = [0.5, 0.25];
    value_and_jacobian(|x| (count(), several(x)).1, &x);
    assert_eq!(calls.take(), 1);
    value_gradient_hessian(|x| (count(), scalar(x)).1, &x);
    assert_eq!(calls.take(), 1);
}

#[test]
fn drivers_with_values_nest() {
    let outer = gradient(
        |x| {
            value_gradient_hessian(|x| x[0].powi(4), x).2[0][0]
                + value_and_jacobian(several, x).0[2]
        },
        &[2.0],
    );
    assert_eq!(outer, [4.0 * 3.0 * 2.0 * 2.0 + 4.0]);
}
