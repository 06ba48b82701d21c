//! Reports on finished runs: pictures, an animation, one page of HTML, and tables of several runs.
//!
//! A report reads what a run left in its folder and simulates nothing.

mod animation;
mod bars;
pub mod chart;
mod compare;
mod convergence;
mod html;
mod layout;
mod motion;
mod numbers;
mod page;
mod plot;
mod results;
mod robot;
pub mod sheet;
mod svg;
mod ternary;

pub use bars::{Bar, bars};
pub use compare::Comparison;
pub use results::Results;

use std::path::PathBuf;

use cosmic::error::Result;
use cosmic::record::files::write_atomic;
use motion::Motion;

/// A picture of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Picture {
    /// The robot at several moments, coloured by strain, and the path of its payload.
    Robot,
    /// Displacement, volumes, measures and gradients over the iterations.
    Convergence,
    /// The paths of the design vectors between the materials.
    Ternary,
}

impl Picture {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Robot, Self::Convergence, Self::Ternary];

    /// What a file of it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Robot => "robot",
            Self::Convergence => "convergence",
            Self::Ternary => "ternary",
        }
    }

    /// The picture as SVG.
    pub fn draw(self, run: &Results) -> String {
        match self {
            Self::Robot => robot::draw(&Motion::new(run)),
            Self::Convergence => convergence::draw(run),
            Self::Ternary => ternary::draw_paths(run),
        }
    }
}

/// Writes `report.html`, `robot.svg`, `convergence.svg` and `gait.gif` into a run's folder and
/// says which files these are. The page holds all of its pictures and fetches nothing.
///
/// # Errors
/// [`Error::Write`](cosmic::Error::Write).
pub fn write(run: &Results) -> Result<Vec<PathBuf>> {
    let motion = Motion::new(run);
    let robot = robot::draw(&motion);
    let convergence = convergence::draw(run);
    let page = page::render(&motion, [&robot, &convergence]);
    let texts = [
        ("report.html", &page),
        ("robot.svg", &robot),
        ("convergence.svg", &convergence),
    ];
    let mut written = Vec::new();
    for (name, text) in texts {
        let path = run.folder.join(name);
        write_atomic(&path, |file| file.write_all(text.as_bytes()))?;
        written.push(path);
    }
    let path = run.folder.join("gait.gif");
    write_atomic(&path, |file| animation::write(&motion, file))?;
    written.push(path);
    Ok(written)
}
