//! The only executor of recordings: their operations, forward and back, for many points at once.
//!
//! Its instances for `f64` and `f32` are compiled in this crate, whatever function was recorded.

mod block;
mod plan;
mod buffers;
mod elementwise;
mod functions;
mod layer;
mod sweep;
mod points;

pub(crate) use plan::Plan;
pub(crate) use points::{Inputs, Points, Replayed, Wanted};
