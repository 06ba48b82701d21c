//! Where did the NaN come from? [`Traced`] numbers know.
//!
//! Run the function that returns NaN, or whose gradient does, once more on traced numbers:
//! [`first_non_finite`] names the operation that first produced what reaches the result, with its
//! operands and its line. An infinity that a [`select`](crate::Real::select) leaves aside is not
//! blamed. Other modes pay nothing for this.
//!
//! Where the function itself takes a derivative, by [`gradient`](crate::gradient) say, the line
//! found is in this crate: trace the inner function alone.

mod origin;
mod traced;
mod search;

pub use origin::NonFinite;
pub use search::first_non_finite;
pub use traced::Traced;
