//! Gradient checking: is a gradient right? If differences disagree, is the gradient wrong or are they?
//!
//! [`check_gradient`] takes a generic function and compares its reverse mode with forward mode and finite
//! differences. [`check_directions`] compares any gradient with differences of a plain function. Both look
//! along random directions. Every component has a part in each direction, so a wrong component shows in all of
//! them, and bisection of the direction finds it.
//!
//! Differences can be wrong too. A step that is too long crosses a kink nearby, a step that is too short drowns
//! in rounding, and at a kink no step is right. So the step is swept over all magnitudes, and the left and the
//! right slope are kept apart. The gradient is called wrong only if neither a smaller step nor a kink explains
//! the disagreement.
//!
//! The same values show two more things. The Taylor order is the order at which the remainder
//! `f(x + h d) - f(x) - h g.d` falls with the step: 2 if the gradient is right, 1 if it is wrong. The negative
//! control is a gradient that is wrong on purpose, by [`WRONG_BY`], and is judged by the same differences. If it
//! is not called wrong, the check proves nothing.
//!
//! A plateau is a range of steps over which the central slope stays the same. It is trusted if the left and the
//! right slope come together as the step shrinks. The verdicts follow:
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
//! At a stationary point the slope cannot set the scale of the tolerance. There the change of the slope over the
//! middle step does. `x * x.abs()` is smooth at zero. `x.max(0).powf(1.5)` is a kink, because its slope shrinks
//! more slowly than the step.
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
