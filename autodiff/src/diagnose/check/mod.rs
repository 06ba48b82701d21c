//! Checks gradients. If difference quotients disagree with a gradient, the check also decides which of the two is
//! wrong.
//!
//! [`check_gradient`] takes a generic function and compares its reverse mode with forward mode and finite
//! differences. [`check_directions`] compares any gradient with differences of a plain function. Both look
//! along random directions. Every component has a part in each direction, so a wrong component shows in all of
//! them, and bisection of the direction finds it.
//!
//! Differences can be wrong too. A step that is too long crosses a kink nearby, with a step that is too short, rounding
//! errors exceed the difference, and at a kink no step is right. So the check tries steps of all magnitudes, and looks
//! at the left and the right slope separately. The gradient is called wrong only if neither a smaller step nor a kink
//! explains the disagreement.
//!
//! The same values show two more things. The Taylor order is the order at which the remainder `f(x + h d) - f(x) - h
//! g.d` falls with the step: 2 if the gradient is right, 1 if it is wrong. The negative control is a gradient that was
//! made wrong on purpose, by the relative error [`WRONG_BY`]. The same differences judge it. If they do not call it
//! wrong, the check proves nothing.
//!
//! A plateau is a range of steps over which the central slope stays the same. The check trusts a plateau if the left
//! and the right slope approach each other as the step shrinks. The verdict depends on the function at the point and on
//! the claimed slope:
//!
//! | at the point | the claimed slope is right | it is wrong |
//! | --- | --- | --- |
//! | smooth, a minimum of exactly zero included | smooth | wrong |
//! | a kink, `x.abs()`: the two sides have different slopes | kink for any slope between them | wrong |
//! | a cusp or a spike, `x.abs().powf(0.6)` or a single outlying value: the sides grow apart | kink | kink, or wrong if they grow apart slowly |
//! | anything | | wrong if the claimed slope is NaN, as reverse mode gives for `(x * x).sqrt()` at zero |
//! | a narrow term, a few hundred smallest steps wide or wider | smooth | wrong, also if the term was forgotten |
//! | a narrower term | kink or smooth | kink or wrong |
//!
//! At a stationary point the slope is zero and cannot set the scale of the tolerance. There the scale is the change of
//! the slope over the middle one of the steps. `x * x.abs()` is smooth at zero. `x.max(0).powf(1.5)` is a kink, because
//! its slope shrinks more slowly than the step.
//!
//! The check cannot see two things. A jump at the point looks like noise if it is small compared to the change of
//! the value over the largest steps. A term that varies over less than the smallest step, such as `1 / x` at 1e-9,
//! looks like a spike for any gradient; it needs a smaller step.

mod report;
mod slopes;
mod taylor;
mod checker;

pub use checker::{Along, Claim, Options, check_directions, check_gradient};
pub use report::{Component, Direction, Report, Verdict, WRONG_BY};
