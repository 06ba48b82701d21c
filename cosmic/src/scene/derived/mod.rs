//! What follows from the settings of a scene: numbers whose setting is "auto", stable time steps, what the parts can do, and
//! what the world asks of a robot.

mod stable_step;
mod any_design;
mod follow;
mod world;
mod data_sheet;
mod margins;

pub use any_design::AnyDesign;
pub(crate) use data_sheet::SLENDERNESS;
pub use data_sheet::{DataSheet, DeviceLength};
pub use margins::Riser;
pub(crate) use stable_step::{STABLE_SHARE, stable_step_off_bars};
pub use stable_step::{phase_limit, stable_step};
