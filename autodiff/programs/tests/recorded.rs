//! A function that is recorded once must agree with the tape at every point.

use crate::common::{Formula, Sym, assert_close, formula};
use autodiff::{Dual, Function, Real, lit, value_and_gradient};
use autodiff_programs::data::Recorded;

/// A function of every kind of operation. It has a kink, and some points are on either side of the kink.
fn mixed() -> Formula {
    formula(4, |x| {
        let inside = Sym::select(x[0].less(x[1]), x[0] * x[2], (x[1] / x[2]).exp());
        let sums = Sym::dot(&x[..2], &x[1..3]) + Sym::sum_of(x) + x[3].sigmoid().ln_1p();
        let bounded = x[2]
            .max(lit(0.5) * x[0])
            .straight_through(x[2] * x[0].detach());
        inside.fma(x[3], sums.tanh()) + bounded.powi(3) - x[1].hypot(x[3])
    })
}

fn points(count: usize) -> Vec<[f64; 4]> {
    let at = |k: usize| [0, 1, 2, 3].map(|i| 1.0 + ((5 * k + i * i) as f64).sin());
    (0..count).map(at).collect()
}

#[test]
fn a_recording_serves_all_points() {
    let mixed = mixed();
    let recorded = Recorded::new(&mixed, 4).expect("no values");
    // The counts are no point, less than a register, and several blocks with a rest. The points take both branches of
    // the kink.
    for count in [0, 1, 7, 100] {
        let points = points(count);
        let both = recorded.values_and_gradients(&points);
        assert_eq!(both.len(), count);
        for (x, (value, gradient)) in points.iter().zip(&both) {
            let (expected, slope) = value_and_gradient(|x| mixed.eval(x), x);
            // The tolerance is for about ten operations, in which lanes round a multiply-add once and the tape rounds
            // it twice.
            let tolerance = 20.0 * f64::EPSILON;
            assert_close(&[*value], &[expected], tolerance);
            assert_close(gradient, &slope, tolerance);
        }
    }
    // Numbers that a replay leaves in memory must not change the next replay.
    let first = Recorded::new(&formula(3, |x| x[0]), 3).expect("no values");
    assert_eq!(
        first.values_and_gradients(&[[2.0, 3.0, 4.0]]),
        [(2.0, vec![1.0, 0.0, 0.0])]
    );
}

/// Beyond 19 the slope of `layer_tanh` rounds to 0, and that of `tanh` does not.
#[test]
fn a_recording_keeps_the_slope_of_a_layer() {
    let layer = formula(1, |x| x[0].layer_tanh());
    let recorded = Recorded::new(&layer, 1).expect("no values");
    let expected = value_and_gradient(|x| layer.eval(x), &[20.0]);
    assert_eq!(expected, (1.0, vec![0.0]));
    assert_eq!(
        recorded.values_and_gradients(&[[20.0]; 9]),
        vec![expected; 9]
    );
}

#[test]
fn recordings_nest_and_run_in_singles() {
    let mixed = mixed();
    let recorded = Recorded::new(&mixed, 4).expect("no values");
    let x = points(1)[0];
    let moving = x.map(|x| Dual::<f64, 1>::variable(x, 0));
    let (_, expected) = value_and_gradient(|x| mixed.eval(x), &moving);
    let (_, second) = recorded.values_and_gradients(&[moving]).remove(0);
    for (a, b) in second.iter().zip(expected) {
        assert_close(&[a.value, a.tangent[0]], &[b.value, b.tangent[0]], 1e-13);
    }
    let singles = x.map(|x| x as f32);
    let (_, slope) = recorded.values_and_gradients(&[singles]).remove(0);
    let slope: Vec<f64> = slope.into_iter().map(f64::from).collect();
    assert_close(&slope, &value_and_gradient(|x| mixed.eval(x), &x).1, 1e-4);
}

/// The tape treats a constant factor of zero as a choice. A replay must do the same.
#[test]
fn a_constant_factor_of_zero_stops_an_infinite_cotangent() {
    let zero = || Sym::lit(0.0);
    for function in [
        formula(2, |x| (zero() * x[0] + x[1]).ln()),
        formula(2, |x| (x[0] * zero() + x[1]).ln()),
        formula(2, |x| zero().fma(x[0], x[1]).ln()),
        formula(2, |x| x[0].fma(zero(), x[1]).ln()),
    ] {
        let recorded = Recorded::new(&function, 2).expect("no values");
        let x = [1.0, 0.0];
        let expected = value_and_gradient(|x| function.eval(x), &x);
        assert_eq!(expected.1, [0.0, f64::INFINITY]);
        for both in recorded.values_and_gradients(&[x; 9]) {
            assert_eq!(both, expected);
        }
    }
}

/// The sum of `mixed` over points that are variables. The argument holds the points column by column.
struct Summed(Recorded);

impl Function for Summed {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let columns: Vec<&[R]> = x.chunks(x.len() / 4).collect();
        self.0.total(&columns)
    }
}

/// Returns the same sum, computed point by point.
fn one_by_one(count: usize) -> Formula {
    let mixed = mixed();
    formula(4 * count, |x| {
        let term = |k: usize| mixed.eval(&[0, 1, 2, 3].map(|i| x[i * count + k]));
        Sym::sum_of(&(0..count).map(term).collect::<Vec<_>>())
    })
}

#[test]
fn a_total_is_the_sum_over_points_that_are_variables() {
    let mixed = mixed();
    let recorded = Recorded::new(&mixed, 4).expect("no values");
    for count in [1, 7, 50] {
        let points = points(count);
        let column = |i: usize| points.iter().map(move |x| x[i]);
        let x: Vec<f64> = (0..4).flat_map(column).collect();
        let (summed, one_by_one) = (Summed(recorded.clone()), one_by_one(count));
        let (expected, slope) = value_and_gradient(|x| one_by_one.eval(x), &x);
        let (value, gradient) = value_and_gradient(|x| summed.eval(x), &x);
        // The two results add the same fifty terms in a different order.
        assert_close(&[value, summed.eval(&x)], &[expected; 2], 1e-13);
        assert_close(&gradient, &slope, 1e-13);
        let moving: Vec<_> = (x.iter().zip(&slope))
            .map(|(&value, &tangent)| Dual {
                value,
                tangent: [tangent],
            })
            .collect();
        let second = |f: &dyn Fn() -> Vec<Dual<f64, 1>>| -> Vec<f64> {
            f().iter().map(|bar| bar.tangent[0]).collect()
        };
        let expected = second(&|| value_and_gradient(|x| one_by_one.eval(x), &moving).1);
        let got = second(&|| value_and_gradient(|x| summed.eval(x), &moving).1);
        assert_close(&got, &expected, 1e-12);
    }
    assert_eq!(recorded.total(&[&[] as &[f64]; 4]), 0.0);
}

#[test]
fn a_recorded_function_may_be_constant() {
    let recorded = Recorded::new(&formula(2, |_| Sym::lit(2.5)), 2).expect("no values");
    let many = recorded.values_and_gradients(&[[1.0, 2.0], [3.0, 4.0]]);
    assert_eq!(many, [(2.5, vec![0.0; 2]), (2.5, vec![0.0; 2])]);
}

/// A function with a loop whose length depends on the argument.
struct Halving;

impl Function for Halving {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let mut y = x[0];
        while y.primal() > 1.0 {
            y = lit(0.5) * y;
        }
        y
    }
}

#[test]
fn what_depends_on_values_is_refused() {
    let error = Recorded::new(&Halving, 1).expect_err("a loop over values");
    assert!(error.to_string().contains("primal"), "{error}");
}
