//! Derivative rules that a user writes for a function.
//!
//! There are three ways to give a rule, from the shortest code to the longest:
//!
//! - [`Real::straight_through`]: the value of one expression with the derivative of another.
//!   `hard.straight_through(soft)` is a step function that learns like a sigmoid.
//! - [`Rule`], called through [`apply`]: a function with one output and known partials. You write the value and the
//!   partials once, and forward, reverse and nested derivatives all use them.
//! - [`Fused`]: a function with any number of inputs and outputs. Its reverse rule is free code, so it can do more than
//!   multiply by partials: for example, it can bound the cotangent.
//!
//! A rule is not checked. [`check_gradient`](crate::check::check_gradient) tests whether it is correct.
//!
//! ```
//! use autodiff::{Real, gradient};
//!
//! /// Rounds a number in [0, 1] with the derivative of the number itself.
//! fn round<R: Real>(x: R) -> R {
//!     let above = R::lit(0.5).less(x);
//!     R::select(above, R::one(), R::zero()).straight_through(x)
//! }
//!
//! fn loss<R: Real>(x: &[R]) -> R {
//!     R::lit(3.0) * round(x[0])
//! }
//! assert_eq!(loss(&[0.7]), 3.0);
//! assert_eq!(gradient(loss, &[0.7]), [3.0]);
//! ```

use crate::dual::Dual;
use crate::real::{Fused, Real};

/// A scalar function of a vector, with partials that you give. The tape keeps the rule, so the rule must own its data
/// or share them through an `Arc`.
///
/// Use it for code that should not be differentiated itself. Examples are an iterative solver, whose partials follow
/// from the equation that it solves, and a special function: the error function can be computed as a series, and its
/// partial is known to be `2 / sqrt(pi) exp(-x^2)`. There is an example in `examples/custom_rule.rs`. The value must be
/// computed with operations of `R`, because a function of floats would not work in every mode.
pub trait Rule: Clone + Send + 'static {
    /// Returns the value at `x`. It is never differentiated, in any mode or nesting.
    fn value<R: Real>(&self, x: &[R]) -> R;

    /// Returns the partials at `x`, one for each argument. `value` is the value at `x`. Nested derivatives
    /// differentiate the partials.
    fn partials<R: Real>(&self, x: &[R], value: R) -> Vec<R>;
}

/// Evaluates a rule in any mode. On the reverse tape the call is one fused entry.
///
/// ```
/// use autodiff::custom::{Rule, apply};
/// use autodiff::{Real, gradient};
///
/// /// `ln(e^a + e^b)`. Its partials are weights with the sum 1.
/// #[derive(Clone)]
/// struct LogSumExp;
/// impl Rule for LogSumExp {
///     fn value<R: Real>(&self, x: &[R]) -> R {
///         let top = x[0].max(x[1]);
///         top + ((x[0] - top).exp() + (x[1] - top).exp()).ln()
///     }
///     fn partials<R: Real>(&self, x: &[R], value: R) -> Vec<R> {
///         vec![(x[0] - value).exp(), (x[1] - value).exp()]
///     }
/// }
/// assert_eq!(gradient(|x| apply(LogSumExp, x), &[900.0, -900.0]), [1.0, 0.0]);
/// ```
#[track_caller]
pub fn apply<R: Real>(rule: impl Rule, x: &[R]) -> R {
    R::fused(Single(rule), &[x])[0]
}

/// Wraps a rule as a fused function that has one input slice and one output.
///
/// Each mode calls the rule with its inner number type. So if modes are nested, every one of them uses the rule's
/// partials.
struct Single<T>(T);

impl<T: Rule> Single<T> {
    #[track_caller]
    fn value_and_partials<R: Real>(&self, x: &[R]) -> (R, Vec<R>) {
        let value = R::fused(Single(self.0.clone()), &[x])[0];
        let partials = self.0.partials(x, value);
        assert_eq!(
            partials.len(),
            x.len(),
            "`Rule::partials` must return one partial for each argument"
        );
        (value, partials)
    }
}

impl<T: Rule> Fused for Single<T> {
    type Saved<R: Real> = Vec<R>;

    fn eval<R: Real>(&self, inputs: &[&[R]]) -> Vec<R> {
        vec![self.0.value(inputs[0])]
    }

    fn forward<R: Real, const N: usize>(&self, inputs: &[&[Dual<R, N>]]) -> Vec<Dual<R, N>> {
        let x: Vec<R> = inputs[0].iter().map(|x| x.value).collect();
        let (value, partials) = self.value_and_partials(&x);
        let mut y = Dual::constant(value);
        for (partial, x) in partials.into_iter().zip(inputs[0]) {
            for i in 0..N {
                y.tangent[i] += R::chain(partial, x.tangent[i]);
            }
        }
        vec![y]
    }

    fn record<R: Real>(&self, inputs: &[&[R]]) -> (Vec<R>, Vec<R>) {
        let (value, partials) = self.value_and_partials(inputs[0]);
        (vec![value], partials)
    }

    fn reverse<R: Real>(&self, partials: &mut Vec<R>, y_bar: &[R], _: &[bool]) -> Vec<Vec<R>> {
        vec![
            partials
                .iter()
                .map(|&partial| R::chain(partial, y_bar[0]))
                .collect(),
        ]
    }
}
