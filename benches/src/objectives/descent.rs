//! Minimises functions by gradient descent. The gradients come from forward or reverse mode, which may be nested.

use autodiff::{Dual, Mask, Real, Var, gradient};

use super::work::Error;

/// A scalar function of `x`. It may also read given numbers, which are not varied.
pub(super) trait Objective {
    /// Returns the value at `x`.
    fn eval<R: Real>(&self, given: &[R], x: &[R]) -> R;
}

/// The mode of differentiation.
#[derive(Clone, Copy)]
pub(super) enum Mode {
    /// Forward mode, one argument at a time.
    Forward,
    /// Reverse mode.
    Reverse,
}

impl Mode {
    /// Returns the outer and the inner mode. GradBench names them by two letters, such as `rf` for reverse over forward
    /// mode.
    pub(super) fn pair(function: &str) -> Result<[Self; 2], Error> {
        use Mode::{Forward, Reverse};
        Ok(match function {
            "rr" => [Reverse, Reverse],
            "ff" => [Forward, Forward],
            "fr" => [Forward, Reverse],
            "rf" => [Reverse, Forward],
            _ => return Error::function(function),
        })
    }

    /// Returns the gradient with respect to `x`. The numbers in `given` may carry the derivatives of an outer mode.
    pub(super) fn gradient<R: Real>(self, of: &impl Objective, given: &[R], x: &[R]) -> Vec<R> {
        if let Self::Reverse = self {
            let given: Vec<Var<R>> = given.iter().map(|&number| Var::constant(number)).collect();
            return gradient(|x| of.eval(&given, x), x);
        }
        let constant = |&number: &R| Dual::<R, 1>::constant(number);
        let given: Vec<_> = given.iter().map(constant).collect();
        let partial = |i: usize| {
            let mut moving: Vec<_> = x.iter().map(constant).collect();
            moving[i] = Dual::variable(x[i], 0);
            of.eval(&given, &moving).tangent[0]
        };
        (0..x.len()).map(partial).collect()
    }
}

/// Minimises an objective by gradient descent that starts at `x`. Returns the minimum point.
pub(super) fn argmin<R: Real>(
    mode: Mode,
    objective: &impl Objective,
    given: &[R],
    x: &[R],
) -> Vec<R> {
    /// The number of accepted steps in a row after which the step length grows.
    const STREAK: usize = 10;
    let mut x = x.to_vec();
    let mut value = objective.eval(given, &x);
    let mut slope = mode.gradient(objective, given, &x);
    let (mut rate, mut taken) = (1e-5, 0);
    loop {
        if is_short(&slope) {
            return x;
        }
        if taken == STREAK {
            (rate, taken) = (2.0 * rate, 0);
            continue;
        }
        let step: Vec<R> = slope.iter().map(|&g| R::lit(rate) * g).collect();
        let next: Vec<R> = x.iter().zip(&step).map(|(&x, &step)| x - step).collect();
        if is_short(&step) {
            return x;
        }
        let next_value = objective.eval(given, &next);
        if next_value.less(value).any() {
            slope = mode.gradient(objective, given, &next);
            (x, value) = (next, next_value);
            taken += 1;
        } else {
            (rate, taken) = (0.5 * rate, 0);
        }
    }
}

/// Returns whether a gradient or a step is so short that the descent stops.
fn is_short<R: Real>(v: &[R]) -> bool {
    const TOLERANCE: f64 = 1e-5;
    let v: Vec<R> = v.iter().map(|entry| entry.detach()).collect();
    R::dot(&v, &v).sqrt().less_equal(R::lit(TOLERANCE)).any()
}
