//! Derivatives of the third and of higher orders.

use autodiff::{
    DoubleDouble, Dual, Dual2, Dual3, Real, Var, derivatives, gradient, hessian, third_derivatives,
    value_gradient_hessian,
};

use crate::common::{assert_close, differences};

#[test]
fn nested_duals_have_every_order() {
    let [value, first, second, third, fourth] =
        derivatives(|x: Dual<Dual3<f64>, 1>| (2.0 * x).exp(), 0.25);
    let power = 0.5_f64.exp();
    assert_close(
        &[value, first, second, third, fourth],
        &[1.0, 2.0, 4.0, 8.0, 16.0].map(|k| k * power),
        1e-15,
    );
    let [value, first] = derivatives(|x: Dual<f32, 1>| x.sqrt(), 4.0);
    assert_eq!([value, first], [2.0, 0.25]);
    // Inside another derivative: the slope of a second derivative is a third derivative.
    let slope = gradient(
        |x| derivatives::<Dual2<Var<f64>>, 3>(|x| x.powi(5), x[0])[2],
        &[2.0],
    );
    assert_eq!(slope, [240.0]);
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
