//! Derivatives of derivatives: no mode may confuse its own perturbation with another's.

use crate::common::{
    assert_close, assert_gradient, differences, forward_gradient, gradients, unit,
};
use autodiff::{
    Dual, Function, Real, Tape, Var, VectorFunction, gradient, gradient_of, hessian,
    hessian_vector, jacobian, jvp, vjp,
};

/// Smooth, not separable, with every second derivative different.
struct Mixed;

impl Function for Mixed {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let wave = (x[0] * x[1]).sin() + x[2].exp() / x[0];
        wave * x[1].tanh() + x[2].powf(x[1]) + R::dot(x, x).sqrt() + x[0].atan2(x[2])
    }
}

/// Three functions of two variables, or the other way round.
struct Rectangle {
    values: usize,
}

impl VectorFunction for Rectangle {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let sum = R::sum_of(x);
        let value = |i: usize| (sum * R::lit(i as f64 + 1.0)).sin() * x[i % x.len()];
        (0..self.values).map(value).collect()
    }
}

const POINT: [f64; 3] = [0.7, 1.3, 2.1];

/// Rounding of a dozen operations, none of which cancels much at `POINT`.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

#[test]
fn the_outer_mode_leaves_the_inner_result_alone() {
    let reference = gradient(&Mixed, &POINT);
    for (_, gradient) in gradients(&Mixed, &POINT) {
        assert_close(&gradient, &reference, ROUNDING);
    }
}

/// `d/dx (x d/dy (x + y)) = 1`; a confused implementation says 2.
#[test]
fn perturbations_are_not_confused() {
    let forward = |x: Dual<f64, 1>| {
        let inner = Dual::<_, 1>::constant(x) + Dual::variable(Dual::lit(1.0), 0);
        x * inner.tangent[0]
    };
    assert_eq!(forward(Dual::variable(1.0, 0)).tangent, [1.0]);

    let reverse = |x: Var<f64>| {
        let outer = x;
        x * gradient_of(|y| Var::constant(outer) + y[0], &[Var::lit(1.0)])[0]
    };
    assert_eq!(gradient_of(|x| reverse(x[0]), &[1.0]), [1.0]);
}

#[test]
fn hessians_agree_in_all_four_nestings() {
    let forward_over_reverse = hessian(&Mixed, &POINT);
    struct Slope<const FORWARD: bool>;
    impl<const FORWARD: bool> VectorFunction for Slope<FORWARD> {
        fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
            if FORWARD {
                forward_gradient(&Mixed, x)
            } else {
                gradient(&Mixed, x)
            }
        }
    }
    for i in 0..POINT.len() {
        let unit = unit(POINT.len(), i);
        let row = &forward_over_reverse[i];
        assert_close(&hessian_vector(&Mixed, &POINT, &unit).1, row, 0.0);
        assert_close(&jvp(&Slope::<true>, &POINT, &unit).1, row, ROUNDING);
        assert_close(&vjp(&Slope::<true>, &POINT, &unit).1, row, ROUNDING);
        assert_close(&vjp(&Slope::<false>, &POINT, &unit).1, row, ROUNDING);

        let slopes = differences(|x| gradient(&Mixed, x), &POINT, i, f64::EPSILON.cbrt());
        // Truncation h^2 and rounding eps / h, 4e-11 each, times derivatives of order 10.
        assert_close(&slopes, row, 1e-9);
    }
}

#[test]
fn jacobians_agree_by_rows_and_by_columns() {
    // Sizes on both sides of the switch, and beyond one chunk of columns.
    for (values, arguments) in [(2, 3), (3, 2), (9, 9), (1, 6), (11, 6)] {
        let function = Rectangle { values };
        let x: Vec<f64> = (0..arguments).map(|i| 0.3 + 0.1 * i as f64).collect();
        let jacobian = jacobian(&function, &x);
        assert_eq!(jacobian.rows(), values);
        for i in 0..values {
            assert_close(
                &vjp(&function, &x, &unit(values, i)).1,
                &jacobian[i],
                ROUNDING,
            );
        }
        for j in 0..arguments {
            let column: Vec<f64> = jacobian.iter().map(|row| row[j]).collect();
            assert_close(
                &jvp(&function, &x, &unit(arguments, j)).1,
                &column,
                ROUNDING,
            );
        }
    }
}

#[test]
fn several_directions_at_once_are_several_single_ones() {
    let x: Vec<Dual<f64, 3>> = (0..3).map(|i| Dual::variable(POINT[i], i)).collect();
    let together = Mixed.eval(&x).tangent;
    assert_eq!(together.to_vec(), forward_gradient(&Mixed, &POINT));
}

#[test]
fn straight_through_and_detach_hold_at_every_level() {
    struct Stepped;
    impl Function for Stepped {
        fn eval<R: Real>(&self, x: &[R]) -> R {
            let hard = R::select(R::zero().less(x[0]), R::one(), R::zero());
            hard.straight_through(x[0] * x[0]) * x[0].detach()
        }
    }
    assert_gradient(&Stepped, &[3.0], &[18.0]);
    // The slope 2 x of the soft part, times a constant 3.
    assert_eq!(hessian(&Stepped, &[3.0]), [[6.0]]);
}

#[test]
fn a_tape_may_be_swept_again_and_recorded_again() {
    let mut tape = Tape::new();
    for scale in [1.0, 2.0] {
        let y = tape.record(&[scale, 3.0], |x| [x[0] * x[1], x[0] / x[1]]);
        assert_eq!(tape.pullback(&y, &[1.0, 0.0]), [3.0, scale]);
        assert_eq!(tape.pullback(&y, &[0.0, 9.0]), [3.0, -scale]);
        assert_eq!(tape.pullback(&y[..1], &[1.0]), [3.0, scale]);
    }
}

/// Sums with constants, and squares, take a shorter way onto the tape.
struct Moved;

impl Function for Moved {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let (half, three) = (R::lit(0.5), R::lit(3.0));
        let square = (x[0] + half) * (x[0] - three) * (three - x[0]);
        let joined = x[0].fma(x[0] + half, x[1]) + x[1].fma(x[1], three);
        square * joined * (half + x[1]) + x[0] * x[0]
    }
}

#[test]
fn numbers_moved_by_constants_keep_their_derivative() {
    let x = [0.75, -1.25];
    let expected = forward_gradient::<f64>(&Moved, &x);
    // The argument's halves and quarters: every product is exact.
    assert_gradient(&Moved, &x, &expected);
    let rows = [0, 1].map(|i| {
        let mut point = x.map(Dual::<f64, 1>::constant);
        point[i].tangent[0] = 1.0;
        let row = forward_gradient(&Moved, &point);
        [0, 1].map(|j| row[j].tangent[0])
    });
    assert_eq!(hessian(&Moved, &x), rows);
}

/// Passes have a fixed number of directions, which the arguments need not fill.
#[test]
fn a_hessian_has_a_row_for_each_argument() {
    struct Product;
    impl Function for Product {
        fn eval<R: Real>(&self, x: &[R]) -> R {
            x.iter().fold(R::one(), |product, &x| product * x)
        }
    }
    for n in [1, 4, 5, 9] {
        let rows = hessian(&Product, &vec![1.0; n]);
        for i in 0..n {
            let expected = |j| if i == j { 0.0 } else { 1.0 };
            assert_eq!(rows[i], (0..n).map(expected).collect::<Vec<_>>());
        }
    }
}
