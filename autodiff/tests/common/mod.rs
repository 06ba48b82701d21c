//! One function, differentiated in every mode the crate has.

use autodiff::{Dual, Function, Real, Tape, VectorFunction, gradient, jvp};

/// A scalar function as a vector function of one value.
struct Scalar<'a, F>(&'a F);

impl<F: Function> VectorFunction for Scalar<'_, F> {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        vec![self.0.eval(x)]
    }
}

/// The gradient by forward mode, one direction at a time.
pub(crate) fn forward_gradient<R: Real>(function: &impl Function, x: &[R]) -> Vec<R> {
    let along = |i: usize| {
        let direction: Vec<R> = (0..x.len())
            .map(|j| if i == j { R::one() } else { R::zero() })
            .collect();
        jvp(&Scalar(function), x, &direction).1[0]
    };
    (0..x.len()).map(along).collect()
}

/// The gradient by forward, reverse, and both again with the derivative of each part nested in
/// another mode: the outer mode must not change what the inner one returns.
pub(crate) fn gradients(function: &impl Function, x: &[f64]) -> Vec<(&'static str, Vec<f64>)> {
    let duals: Vec<Dual<f64, 1>> = x.iter().map(|&x| Dual::variable(x, 0)).collect();
    let primal = |gradient: Vec<Dual<f64, 1>>| gradient.iter().map(|g| g.value).collect();
    let mut tape = Tape::new();
    vec![
        ("forward", forward_gradient(function, x)),
        ("reverse", gradient(function, x)),
        (
            "forward in forward",
            primal(forward_gradient(function, &duals)),
        ),
        ("reverse in forward", primal(gradient(function, &duals))),
        (
            "forward in reverse",
            tape.record(x, |x| {
                forward_gradient(function, x)
                    .iter()
                    .map(|g| g.value())
                    .collect()
            }),
        ),
        (
            "reverse in reverse",
            tape.record(x, |x| {
                gradient(function, x).iter().map(|g| g.value()).collect()
            }),
        ),
    ]
}

/// Asserts that every mode returns exactly this gradient; NaN equals NaN.
#[track_caller]
pub(crate) fn assert_gradient(function: &impl Function, x: &[f64], expected: &[f64]) {
    for (mode, gradient) in gradients(function, x) {
        let same = |(a, b): (&f64, &f64)| a == b || a.is_nan() && b.is_nan();
        let same = gradient.iter().zip(expected).all(same);
        assert!(same, "{mode} at {x:?}: {gradient:?}, expected {expected:?}");
    }
}
