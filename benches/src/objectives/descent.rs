//! The two modes as values, to be nested in any order.

use autodiff::{Dual, Real, Var, gradient};

/// A scalar function of `x` that other numbers are given to.
pub(super) trait Objective {
    /// The value at `x`.
    fn eval<R: Real>(&self, given: &[R], x: &[R]) -> R;
}

/// A way to differentiate.
pub(super) trait Mode {
    /// The gradient by `x`. What is given may itself carry derivatives of whatever contains this.
    fn gradient<R: Real>(objective: &impl Objective, given: &[R], x: &[R]) -> Vec<R>;
}

/// Reverse mode.
pub(super) struct Reverse;

impl Mode for Reverse {
    fn gradient<R: Real>(objective: &impl Objective, given: &[R], x: &[R]) -> Vec<R> {
        let given: Vec<Var<R>> = given.iter().map(|&number| Var::constant(number)).collect();
        gradient(|x| objective.eval(&given, x), x)
    }
}

/// Forward mode, one argument at a time.
pub(super) struct Forward;

impl Mode for Forward {
    fn gradient<R: Real>(objective: &impl Objective, given: &[R], x: &[R]) -> Vec<R> {
        let constants = |numbers: &[R]| -> Vec<Dual<R, 1>> {
            numbers
                .iter()
                .map(|&number| Dual::constant(number))
                .collect()
        };
        let given = constants(given);
        let partial = |i: usize| {
            let mut moving = constants(x);
            moving[i] = Dual::variable(x[i], 0);
            objective.eval(&given, &moving).tangent[0]
        };
        (0..x.len()).map(partial).collect()
    }
}

/// The point where an objective is least, by descent along its gradient from `x` on.
pub(super) fn argmin<R: Real, M: Mode>(objective: &impl Objective, given: &[R], x: &[R]) -> Vec<R> {
    /// How small a gradient and a step must be to stop.
    const TOLERANCE: f64 = 1e-5;
    /// After so many steps in a row that were taken, steps grow.
    const STREAK: usize = 10;
    let mut x = x.to_vec();
    let mut value = objective.eval(given, &x);
    let mut slope = M::gradient(objective, given, &x);
    let (mut rate, mut taken) = (1e-5, 0);
    loop {
        if below(length(&slope), TOLERANCE) {
            return x;
        }
        if taken == STREAK {
            (rate, taken) = (2.0 * rate, 0);
            continue;
        }
        let step: Vec<R> = slope.iter().map(|&g| R::lit(rate) * g).collect();
        let next: Vec<R> = x.iter().zip(&step).map(|(&x, &step)| x - step).collect();
        if below(length(&step), TOLERANCE) {
            return x;
        }
        let next_value = objective.eval(given, &next);
        if autodiff::Mask::any(next_value.less(value)) {
            slope = M::gradient(objective, given, &next);
            (x, value) = (next, next_value);
            taken += 1;
        } else {
            (rate, taken) = (0.5 * rate, 0);
        }
    }
}

/// The length of a vector; it decides where to stop, and carries no derivative.
fn length<R: Real>(v: &[R]) -> R {
    let v: Vec<R> = v.iter().map(|entry| entry.detach()).collect();
    R::dot(&v, &v).sqrt()
}

/// Whether a single number is at most this.
fn below<R: Real>(number: R, bound: f64) -> bool {
    autodiff::Mask::any(number.less_equal(R::lit(bound)))
}
