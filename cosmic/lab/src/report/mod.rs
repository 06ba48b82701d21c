//! Reports on finished runs: pictures, an animation, one page of HTML, and tables of several runs.
//!
//! A report reads what a run left in its folder and simulates nothing.

mod animation;
mod bars;
mod canvas;
pub mod chart;
mod compare;
mod convergence;
mod data;
mod evolution;
mod files;
mod gait;
mod html;
mod layout;
mod lettering;
mod loads;
mod motion;
mod numbers;
mod page;
mod picture;
mod plot;
mod race;
mod robot;
pub mod sheet;
mod svg;
mod ternary;
mod work;

pub use animation::{FRAME_WIDTH, frame};
pub use bars::{Bar, bars};
pub use compare::Comparison;
pub use files::{ForeignScene, RobotFiles, RunFiles};
pub(crate) use loads::loads;
pub use numbers::departures;
pub use page::player_page;
pub(crate) use picture::PICTURES;
pub use work::{Animations, write};
