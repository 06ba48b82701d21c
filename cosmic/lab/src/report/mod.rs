//! Reports on finished runs: one page of HTML, a picture and an animation of a run, and tables of several runs.
//!
//! A report reads the files of a run's folder and runs no simulation. There are two renderers. `page/drawing.js` draws
//! on the canvases of all pages, including the page in the folder `web`; `page/painter.js` has the projection and the
//! painter of robots. `Picture` is a list of shapes that becomes an SVG file or a frame of an animation.

mod animation;
mod compare;
mod convergence;
mod data;
pub mod eye;
mod files;
pub mod gait;
pub mod motion;
mod page;
pub mod picture;
mod pixels;
mod robot;
pub mod sheet;
mod space;
mod tiles;
mod verdict;
mod view;
mod work;

pub use animation::{FRAME_WIDTH, frame};
pub use compare::Comparison;
pub use files::{RobotFiles, RunFiles};
pub use page::player_page;
pub use verdict::verdict_of;
pub use work::{write, write_animation, write_page, write_walk};
