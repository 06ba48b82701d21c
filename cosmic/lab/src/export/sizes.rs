//! The sizes of bars, holes and struts, which a workshop chooses.

use cosmic::error::Error;

/// The sizes that a workshop chooses, in millimetres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sizes {
    /// Width of a flat bar.
    pub width: f64,
    /// Diameter of the holes at the nodes.
    pub hole: f64,
    /// The smallest distance between two bars in one layer of the pattern or one plane of the solid.
    pub gap: f64,
    /// Thickness of the plate from which the bars are cut.
    pub thickness: f64,
    /// Radius of the solid's skeleton struts. The radius of actuators follows from the line densities.
    pub radius: f64,
}

/// Returns the error for sizes that do not fit the robot.
pub(super) fn misfit(says: String) -> Error {
    Error::Usage(format!("cannot export: {says}"))
}
