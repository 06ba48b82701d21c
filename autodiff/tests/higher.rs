//! Derivatives of the third and of higher orders.

use autodiff::{
    DoubleDouble, Real, derivatives, derivatives_along, gradient, hessian, jvp, third_derivatives,
    value_and_derivative, value_gradient_hessian,
};

use crate::common::{assert_close, differences};

#[test]
fn functions_of_one_number_have_derivatives_of_every_order() {
    let power = 0.5_f64.exp();
    let found = derivatives(|x| (2.0 * x).exp(), 0.25);
    assert_close(&found, &[1.0, 2.0, 4.0, 8.0].map(|k| k * power), 1e-15);
    assert_eq!(value_and_derivative(|x| x.sqrt(), 4.0_f32), (2.0, 0.25));
    // Inside another derivative, in both modes: the slope of a third derivative is a fourth derivative.
    let outer = |x: &[_]| derivatives(|x| (2.0 * x).exp(), x[0])[3];
    assert_close(&gradient(outer, &[0.25]), &[16.0 * power], 1e-15);
    let (third, fourth) = value_and_derivative(|x| derivatives(|x| (2.0 * x).exp(), x)[3], 0.25);
    assert_close(&[third, fourth], &[8.0 * power, 16.0 * power], 1e-15);
    // A function without an argument is constant.
    assert_eq!(derivatives(|_| Real::lit(3.0), 1.0), [3.0, 0.0, 0.0, 0.0]);
}

/// The values of two functions of three arguments.
fn pair<R: Real>(x: &[R]) -> Vec<R> {
    vec![coupled(x), (x[0] * x[1]).exp() - x[2].powi(4)]
}

#[test]
fn derivatives_along_a_direction_are_contractions() {
    let (x, along) = ([0.7, -0.4, 1.1], [1.5, -2.0, 0.5]);
    let found = derivatives_along(pair, &x, &along);
    let (values, slopes) = jvp(pair, &x, &along);
    assert_close(&found[0], &values, 1e-15);
    assert_close(&found[1], &slopes, 1e-14);
    for i in 0..2 {
        let all = third_derivatives(|x| pair(x)[i], &x);
        let (mut second, mut third) = (0.0, 0.0);
        for (j, k) in (0..3).flat_map(|j| [0, 1, 2].map(|k| (j, k))) {
            second += all.hessian[j][k] * along[j] * along[k];
            let of_pair = (0..3).map(|l| all.third(j, k, l) * along[l]);
            third += of_pair.sum::<f64>() * along[j] * along[k];
        }
        // Some thirty products of up to 100 are summed.
        assert_close(&[found[2][i], found[3][i]], &[second, third], 1e-13);
    }
    let none = derivatives_along(|_| vec![Real::lit(2.0)], &[0.0; 0], &[]);
    assert_eq!(none, [[2.0], [0.0], [0.0], [0.0]]);
}

fn coupled<R: Real>(x: &[R]) -> R {
    let all = x.iter().copied().product::<R>();
    (R::dot(x, x) + all.sin()).sqrt() + x[0].powi(3) * x[1]
}

#[test]
fn third_derivatives_are_those_of_the_hessian() {
    let x = [0.7, -0.4, 1.1];
    let all = third_derivatives(coupled, &x);
    let (value, slopes, second) = value_gradient_hessian(coupled, &x);
    assert_close(&[all.value], &[value], 1e-15);
    assert_close(&all.gradient, &slopes, 1e-14);
    assert_close(all.hessian.as_slice(), second.as_slice(), 1e-14);
    for k in 0..3 {
        // With a step of 1e-5 a difference is off by 1e-10 times fifth derivatives, which are about 10.
        let slopes = differences(|x| hessian(coupled, x).into_vec(), &x, k, 1e-5);
        for (ij, slope) in slopes.into_iter().enumerate() {
            let (i, j) = (ij / 3, ij % 3);
            assert_close(&[all.third(i, j, k)], &[slope], 1e-8);
            assert_eq!(all.third(i, j, k), all.third(k, j, i));
            assert_eq!(all.hessian[i][j], all.hessian[j][i]);
        }
    }
}

#[test]
fn third_derivatives_of_few_arguments() {
    let none = third_derivatives(|_| Real::lit(2.0), &[0.0; 0]);
    assert_eq!(
        (none.value, none.gradient.len(), none.hessian.rows()),
        (2.0, 0, 0)
    );
    let wide = third_derivatives(|x| x[0].exp(), &[DoubleDouble::from(1.0)]);
    let error = (wide.third(0, 0, 0) - DoubleDouble::from(1.0).exp()).to_f64();
    assert!(error.abs() < 1e-30, "{error:e}");
}
