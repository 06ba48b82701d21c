//! The pictures of a run that other documents show.

use super::files::RunFiles;
use super::motion::Motion;
use super::{convergence, robot, ternary};

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

    /// The name of its files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Robot => "robot",
            Self::Convergence => "convergence",
            Self::Ternary => "ternary",
        }
    }

    /// The picture as SVG.
    pub fn draw(self, run: &RunFiles) -> String {
        match self {
            Self::Robot => robot::draw(&Motion::new(run)),
            Self::Convergence => convergence::draw(run),
            Self::Ternary => ternary::draw_paths(run),
        }
    }
}
