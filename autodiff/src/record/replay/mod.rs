//! The only executor of recordings. It runs their operations forward and in reverse, at many points at once.
//!
//! Its instances for `f64` and `f32` are compiled in this crate, because they do not depend on the recorded code.

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
