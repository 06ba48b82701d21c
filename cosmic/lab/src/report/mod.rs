//! Reports on finished runs: pictures, an animation, one page of HTML, and tables of several runs.
//!
//! A report reads the files of a run's folder. It simulates only the ways to nine goals, for robots that take goals,
//! with [`walk`](crate::walk). There are two renderers. `page/drawing.js` draws on the canvases of all pages, including
//! the page in the folder `web`. `Picture` is a list of shapes that becomes an SVG file or a frame of an animation.

mod animation;
mod bars;
mod compare;
mod convergence;
mod data;
mod evolution;
mod files;
pub mod gait;
mod layout;
pub mod lettering;
mod loads;
pub mod motion;
mod numbers;
mod page;
pub mod picture;
mod pixels;
pub mod plot;
mod robot;
pub mod sheet;
mod svg;
mod ternary;
mod tiles;
mod verdict;
mod view;
mod ways;
mod work;

pub use animation::{FRAME_WIDTH, frame};
pub use bars::{Bar, bars};
pub use compare::Comparison;
pub use files::{ForeignScene, RobotFiles, RunFiles};
pub(crate) use loads::loads;
pub use page::player_page;
pub use verdict::verdict_of;
pub use work::{Animations, write, write_walk};

/// A kind of picture of a run: the name of its files, and the function that draws it as SVG.
pub(crate) type RunPicture = (&'static str, fn(&RunFiles) -> String);

/// The three pictures: the robot at several moments with the path of its payload; charts over the iterations; and, for
/// every edge, the path of its mixture in the triangle of void, skeleton and actuator.
pub(crate) const PICTURES: [RunPicture; 3] = [
    ("robot", |run| {
        robot::draw(&motion::Motion::new(&run.robot, &run.trajectory))
    }),
    ("convergence", convergence::draw),
    ("ternary", ternary::draw_paths),
];
