//! Checks gradients. If difference quotients disagree with a gradient, the check also decides which of the two is
//! wrong.
//!
//! [`check_gradient`] takes a generic function and compares its reverse mode with forward mode and finite
//! differences. [`check_directions`] compares any gradient with differences of a generic function. Both look
//! along random directions. Every component has a part in each direction, so a wrong component shows in all of
//! them, and bisection of the direction finds it.
//!
//! The differences are taken in [`DoubleDouble`](crate::DoubleDouble), over two steps that are short enough for any
//! feature of the function, and still free of rounding errors. The **remainder** `f(x + h d) - f(x) - h g.d` of the
//! claimed slope falls with the square of the step if the slope is right, and with the step itself if it is wrong or if
//! there is a kink. A wrong slope and a kink differ in the left and the right slope, which approach each other as the
//! step shrinks unless there is a kink.
//!
//! The negative control is a gradient that was made wrong on purpose, by the relative error [`WRONG_BY`]. The same
//! differences judge it. If they do not call it wrong, the check proves nothing.
//!
//! The verdict depends on the function at the point and on the claimed slope:
//!
//! | at the point | the claimed slope is right | it is wrong |
//! | --- | --- | --- |
//! | smooth, a minimum included | smooth | wrong |
//! | a kink, `x.abs()`: the two sides have different slopes | kink for any slope between them | wrong |
//! | a cusp or a spike, `x.abs().powf(0.6)` or a single outlying value: the sides grow apart | kink | kink |
//! | an infinite slope, `x.cbrt()` | kink | kink |
//! | anything | | wrong if the claimed slope is NaN, as reverse mode gives for `(x * x).sqrt()` at zero |
//!
//! The check cannot see features that are narrower than its steps; a smaller [`step`](Options::step) shows them. If a
//! function computes a part of its value in floats, for example by a solver, that part moves in jumps; a larger step of
//! 1e-5 is right then.

mod report;
mod slopes;
mod checker;

pub use checker::{Along, Claim, Options, check_directions, check_gradient};
pub use report::{Component, Direction, Report, Verdict, WRONG_BY};
