//! Finds the operation where a NaN or an infinity comes from. The function runs on [`Traced`] numbers.
//!
//! If a function or its gradient returns NaN, pass the function to [`first_non_finite`]. It names the first operation
//! whose infinity or NaN reaches the result, with its operands and its line. An infinity that a
//! [`select`](crate::Real::select) drops is not reported. Tracing costs nothing in other modes.
//!
//! If the function itself takes a derivative, for example by [`gradient`](crate::gradient), or runs a `Sum` of
//! `autodiff_programs`, the reported line is in these crates. Then trace the inner function, or the summand at a datum,
//! by itself.

mod line;
mod step;
mod origin;
mod traced;
mod search;

#[doc(hidden)]
pub use line::{Line, begin_line, replaying};
pub use origin::NonFinite;
pub use search::first_non_finite;
#[doc(hidden)]
pub use step::{begin_step, running};
pub use traced::Traced;
