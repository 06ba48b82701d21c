//! Programs of shapes that neither the net of springs nor the drawn programs have.

use crate::common::forward_gradient;
use crate::steps::STEPS;
use autodiff::check::{Options, Verdict, check_gradient};
use autodiff::{Dual, Function, Real, Tape, gradient};
use autodiff_programs::{Memory, Model, Program, Rollout};

/// A program without any state must work for every memory budget.
#[test]
fn a_program_may_have_no_state() {
    #[derive(Clone)]
    struct Stateless;
    impl Model for Stateless {
        fn record(&self, _: &mut Program) {}
    }
    for memory in [Memory::All, Memory::States(3)] {
        let rollout = Rollout {
            memory,
            ..Rollout::new(Stateless, STEPS)
        };
        let mut tape = Tape::<f64>::new();
        assert!(tape.record(&[], |x| rollout.run(x, &[])).is_empty());
        assert!(
            rollout
                .run_batch(&[&[], &[] as &[f64]], &[])
                .concat()
                .is_empty()
        );
    }
}

/// A model of one number that goes through a `tanh` layer. The layer's weight is a parameter.
#[derive(Clone)]
struct Saturated;

impl Model for Saturated {
    fn record(&self, p: &mut Program) {
        let (weight, bias) = (p.matrix(1, 1), p.parameter(1));
        let x = p.state(1);
        let next = p.dense_tanh(weight, &[x], bias);
        p.advance(x, next);
    }
}

struct ThroughLayer(Rollout<Saturated>);

impl Function for ThroughLayer {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        self.0.run(&x[..1], &[&x[1..2], &x[2..]])[0]
    }
}

/// The layer's reverse sweep knows only the results, so each mode must compute the slope from the results, and so must
/// the modes inside another one.
#[test]
fn a_saturated_layer_has_one_slope_in_forward_and_reverse_mode() {
    let layer = ThroughLayer(Rollout::new(Saturated, 1));
    for bias in [0.0, 0.7, -3.0, 9.0, 15.0, 20.0] {
        let x = [0.25, 2.0, bias];
        // Each mode compiles all operations of a rollout for its number type, so these are not all modes.
        let slopes = [
            forward_gradient(&layer, &x)[2],
            gradient(|x| layer.eval(x), &x)[2],
            gradient(|x| layer.eval(x), &x.map(Dual::<f64, 1>::constant))[2].value,
            Tape::new().record(&x, |x| gradient(|x| layer.eval(x), x)[2].value()),
        ];
        let y = layer.eval(&x);
        let expected = 1.0 - y * y;
        // Lanes use a fused multiply-add, while other numbers round the square and the difference, so they differ by an
        // ulp of 1. If the result is near 1, the difference is exact, and the error of the square is (1 - y)^2, which
        // is below 1e-12 times the slope.
        let error = if bias < 10.0 {
            2.0 * f64::EPSILON
        } else {
            1e-12 * expected
        };
        let close = |slope: &f64| (slope - expected).abs() <= error;
        assert!(slopes.iter().all(close), "{bias}: {slopes:?}, {expected}");
        // Further out, the slope has fewer digits than the tolerance of a check.
        if bias < 5.0 {
            let report = check_gradient(&layer, &x, &Options::default());
            assert_eq!(report.verdict, Verdict::Smooth, "{bias}: {report}");
        }
    }
}
