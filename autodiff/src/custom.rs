//! A user's own derivative rule.
//!
//! Three ways, from the shortest:
//!
//! - [`Real::straight_through`]: the value of one expression with the derivative of another.
//!   `hard.straight_through(soft)` is a step function that learns like a sigmoid.
//! - [`Rule`], called through [`apply`]: one output whose partials are known. Value and partials
//!   are each written once; forward, reverse and nested derivatives all come from them.
//! - [`Fused`]: any number of inputs and outputs, and a reverse rule that may do what no partials
//!   can, such as bound the cotangent that passes.
//!
//! A rule is trusted as given: [`check_gradient`](crate::check::check_gradient) tells whether it is
//! right.
//!
//! ```
//! use autodiff::{Real, gradient};
//!
//! /// Rounds a number in [0, 1], and passes derivatives as if it did not.
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

/// A scalar function of a vector with its partials given. It must own its data, or share them by an
/// `Arc`, because the tape keeps it.
///
/// Use it for code that should not be differentiated through, such as an iterative solver, whose partials
/// follow from the equation it solves, and for special functions: the error function is a series over
/// `R` with the partial `2 / sqrt(pi) exp(-x^2)`. `examples/custom_rule.rs` has one. The value has to be
/// computed with the operations of `R`: a foreign function of floats could not serve every mode.
pub trait Rule: Clone + Send + 'static {
    /// The value at `x`. It is never differentiated, in any mode or nesting.
    fn value<R: Real>(&self, x: &[R]) -> R;

    /// The partials at `x`, one per argument; `value` is the value there. These are differentiated
    /// where derivatives nest.
    fn partials<R: Real>(&self, x: &[R], value: R) -> Vec<R>;
}

/// Evaluates a rule, in any mode; on the reverse tape the call is one fused entry.
///
/// ```
/// use autodiff::custom::{Rule, apply};
/// use autodiff::{Real, gradient};
///
/// /// `ln(e^a + e^b)`, whose partials are weights that sum to 1.
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

/// A rule as a fused function of one slice with one output.
///
/// Each mode peels one layer off its numbers and asks for the rule's value in the numbers inside,
/// which carries their derivatives by the rule too.
struct Single<T>(T);

impl<T: Rule> Single<T> {
    fn value_and_partials<R: Real>(&self, x: &[R]) -> (R, Vec<R>) {
        let value = R::fused(Single(self.0.clone()), &[x])[0];
        let partials = self.0.partials(x, value);
        assert_eq!(
            partials.len(),
            x.len(),
            "Rule::partials must return one partial per argument"
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
