//! Derivatives of derivatives: a mode must not confuse its own derivatives with those of another mode.

use crate::common::{
    Formula, Sym, assert_close, assert_gradient, differences, formula, formulas, forward_gradient,
    hessian_rows, unit,
};
use autodiff::{
    Dual, Function, Real, Tape, Var, gradient, hessian, hessian_vector, jacobian, jacobian_reverse,
    jvp, vjp,
};

/// A smooth function that is not a sum of functions of single arguments. All its second derivatives differ.
fn mixed() -> Formula {
    formula(3, |x| {
        let wave = (x[0] * x[1]).sin() + x[2].exp() / x[0];
        wave * x[1].tanh() + x[2].powf(x[1]) + Sym::dot(x, x).sqrt() + x[0].atan2(x[2])
    })
}

/// Returns a vector function with the given numbers of values and arguments.
fn rectangle(values: usize, arguments: usize) -> Formula {
    formulas(arguments, |x| {
        let sum = Sym::sum_of(x);
        let value = |i: usize| (sum * Sym::lit(i as f64 + 1.0)).sin() * x[i % x.len()];
        (0..values).map(value).collect()
    })
}

const POINT: [f64; 3] = [0.7, 1.3, 2.1];

/// The rounding error of a dozen operations at `POINT`, where little cancels.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// `d/dx (x d/dy (x + y))` must be 1. An implementation that confuses perturbations returns 2.
#[test]
fn perturbations_are_not_confused() {
    let forward = |x: Dual<f64, 1>| {
        let inner = Dual::<_, 1>::constant(x) + Dual::variable(Dual::lit(1.0), 0);
        x * inner.tangent[0]
    };
    assert_eq!(forward(Dual::variable(1.0, 0)).tangent, [1.0]);

    let reverse = |x: Var<f64>| {
        let outer = x;
        x * gradient(|y| Var::constant(outer) + y[0], &[Var::lit(1.0)])[0]
    };
    assert_eq!(gradient(|x| reverse(x[0]), &[1.0]), [1.0]);
}

#[test]
fn hessians_agree_in_all_four_nestings() {
    let mixed = mixed();
    let forward_over_reverse = hessian_rows(&mixed, &POINT);
    for (i, row) in forward_over_reverse.iter().enumerate() {
        let unit = unit(POINT.len(), i);
        let (_, forward) = jvp(|x| forward_gradient(&mixed, x), &POINT, &unit);
        assert_close(&forward, row, ROUNDING);
        let (_, over_forward) = vjp(|x| forward_gradient(&mixed, x), &POINT, &unit);
        assert_close(&over_forward, row, ROUNDING);
        let (_, reverse) = vjp(|x| gradient(|x| mixed.eval(x), x), &POINT, &unit);
        assert_close(&reverse, row, ROUNDING);
        let slopes = |x: &[f64]| gradient(|x| mixed.eval(x), x);
        let slopes = differences(slopes, &POINT, i, f64::EPSILON.cbrt());
        // The truncation error is h^2 and the rounding error is eps / h, about 4e-11 each. The derivatives of order 10
        // multiply both.
        assert_close(&slopes, row, 1e-9);
    }
}

#[test]
fn jacobians_agree_by_rows_and_by_columns() {
    // In some cases the arguments fill less than one pass of columns, and in others more than one.
    for (values, arguments) in [(2, 3), (3, 2), (9, 9), (1, 6), (11, 6)] {
        let function = rectangle(values, arguments);
        let x: Vec<f64> = (0..arguments).map(|i| 0.3 + 0.1 * i as f64).collect();
        let jacobian = jacobian(|x| function.values(x), &x);
        assert_eq!(jacobian.rows(), values);
        let reverse = jacobian_reverse(|x| function.values(x), &x);
        assert_close(reverse.as_slice(), jacobian.as_slice(), ROUNDING);
        for i in 0..values {
            let (_, row) = vjp(|x| function.values(x), &x, &unit(values, i));
            assert_eq!(row, reverse[i]);
        }
        for j in 0..arguments {
            let column: Vec<f64> = jacobian.iter().map(|row| row[j]).collect();
            let (_, single) = jvp(|x| function.values(x), &x, &unit(arguments, j));
            assert_eq!(single, column);
        }
    }
}

#[test]
fn several_directions_at_once_are_several_single_ones() {
    let x: Vec<Dual<f64, 8>> = (0..3).map(|i| Dual::variable(POINT[i], i)).collect();
    let together = mixed().eval(&x).tangent;
    assert_eq!(together[..3], forward_gradient(&mixed(), &POINT));
}

#[test]
fn straight_through_and_detach_hold_at_every_level() {
    let stepped = formula(1, |x| {
        let hard = Sym::select(Sym::lit(0.0).less(x[0]), Sym::lit(1.0), Sym::lit(0.0));
        hard.straight_through(x[0] * x[0]) * x[0].detach()
    });
    assert_gradient(&stepped, &[3.0], &[18.0]);
    // The constant 3 is multiplied by the slope of the soft part, which is 2 x.
    assert_eq!(hessian_rows(&stepped, &[3.0]), [[6.0]]);
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

/// The tape records sums with constants, and squares, in a special form. Their derivatives must still be right.
#[test]
fn numbers_moved_by_constants_keep_their_derivative() {
    let moved = formula(2, |x| {
        let (half, three) = (Sym::lit(0.5), Sym::lit(3.0));
        let square = (x[0] + half) * (x[0] - three) * (three - x[0]);
        let joined = x[0].fma(x[0] + half, x[1]) + x[1].fma(x[1], three);
        square * joined * (half + x[1]) + x[0] * x[0]
    });
    let x = [0.75, -1.25];
    let expected = forward_gradient::<f64>(&moved, &x);
    // The arguments are halves and quarters, so every product is exact.
    assert_gradient(&moved, &x, &expected);
    let rows = [0, 1].map(|i| {
        let mut point = x.map(Dual::<f64, 1>::constant);
        point[i].tangent[0] = 1.0;
        let row = forward_gradient(&moved, &point);
        [0, 1].map(|j| row[j].tangent[0])
    });
    assert_eq!(hessian_rows(&moved, &x), rows);
}

/// A pass has a fixed number of directions. The Hessian must be right even if the arguments do not fill the last pass.
#[test]
fn a_hessian_has_a_row_for_each_argument() {
    for n in [1, 4, 5, 9] {
        let rows = hessian(|x| x.iter().product(), &vec![1.0; n]);
        for i in 0..n {
            let expected = |j| if i == j { 0.0 } else { 1.0 };
            assert_eq!(rows[i], (0..n).map(expected).collect::<Vec<_>>());
            let product = hessian_vector(|x| x.iter().product(), &vec![1.0; n], &unit(n, i));
            assert_eq!(rows[i], product.1);
        }
    }
}
