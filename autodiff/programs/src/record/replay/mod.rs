//! Replays recordings: runs their operations forward and in reverse, at many points at once. No other module executes
//! recordings.
//!
//! The replay does not depend on the recorded code, so it is compiled in this crate for `f64` and `f32`.

mod block;
mod plan;
mod buffers;
mod elementwise;
mod functions;
mod layer;
mod sweep;
mod points;
mod evaluate;

pub(crate) use evaluate::computed;
pub(crate) use plan::Plan;
pub(crate) use points::{PointInputs, Points, Replayed, Wanted};
