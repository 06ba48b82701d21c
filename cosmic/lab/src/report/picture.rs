//! The pictures of a run that other documents show.

use super::files::RunFiles;
use super::motion::Motion;
use super::{convergence, robot, ternary};

/// A picture of a run: the name of its files, and how it is drawn as SVG.
pub(crate) type Picture = (&'static str, fn(&RunFiles) -> String);

/// The robot at several moments, coloured by strain, with the path of its payload; displacement,
/// volumes, measures and gradients over the iterations; the paths of the design vectors between the
/// materials.
pub(crate) const PICTURES: [Picture; 3] = [
    ("robot", |run| {
        robot::draw(&Motion::new(&run.robot, &run.trajectory))
    }),
    ("convergence", convergence::draw),
    ("ternary", ternary::draw_paths),
];
