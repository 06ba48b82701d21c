//! Gradient checking: is a gradient right, and if differences say no, is it the gradient's fault?
//!
//! [`check_gradient`] takes a generic function and compares its reverse mode with forward mode and
//! finite differences. [`check_directions`] compares a gradient from anywhere with differences of a plain
//! function. Both look along random directions, in which every component takes part: a wrong one
//! shows in each of them, and bisection of the direction then finds it.
//!
//! Differences can be wrong too: too long a step crosses a kink nearby, too short a step drowns
//! in rounding, and at a kink no step is right. So the step is swept over all magnitudes, the
//! left and the right slope are kept apart, and a disagreement is blamed on the gradient only
//! when neither a smaller step nor a kink explains it.
//!
//! The values of the sweep tell two more things at no cost. The Taylor slope is the order at which
//! the remainder `f(x + h d) - f(x) - h g.d` falls with the step: 2 where the gradient is right, 1
//! where it is not. And a negative control, a gradient that is wrong on purpose by [`WRONG_BY`], is
//! judged by the same differences: a check that does not call it wrong proves nothing.
//!
//! A plateau, a range of steps over which the central slope stays the same, is believed where the
//! left and the right slope come together as the step shrinks. What follows from that:
//!
//! | at the point | right slope claimed | another one |
//! | --- | --- | --- |
//! | smooth, a minimum of exactly zero included | smooth | wrong |
//! | a kink, `x.abs()`: each side has a slope of its own | kink for any slope between them | wrong |
//! | a cusp or a spike, `x.abs().powf(0.6)` or a single value off the rest: the sides grow apart | kink | kink, or wrong where they do so slowly |
//! | anything | | wrong if the claimed slope is NaN, as reverse mode gives for `(x * x).sqrt()` at zero |
//! | a narrow term, of a few hundred smallest steps or more | smooth | wrong, a forgotten term too |
//! | a narrower one | kink or smooth | kink or wrong |
//!
//! At a stationary point there is no slope to set a scale for the tolerance: instead, the slope's change
//! over the middle one of the steps does. `x * x.abs()` is smooth at zero, whatever its second
//! derivative; `x.max(0).powf(1.5)`, whose slope shrinks more slowly than the step, is a kink.
//!
//! Two things cannot be seen. A jump at the point that is small beside the value's change over
//! the largest steps looks like noise. And what varies over less than the smallest step, `1 / x` at
//! 1e-9, looks like a spike whatever its gradient: it needs a smaller step.

mod report;
mod slopes;
mod taylor;
mod checker;

pub use checker::{Along, Claim, Options, check_directions, check_gradient};
pub use report::{Component, Direction, Report, Verdict, WRONG_BY};
