//! Sizes that a workshop chooses.

use cosmic::error::Error;

/// The sizes that a workshop chooses, in millimetres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sizes {
    /// Width of a flat bar.
    pub width: f64,
    /// Diameter of the holes at the nodes.
    pub hole: f64,
    /// The least distance of two bars in one layer, of the pattern and of the solid.
    pub gap: f64,
    /// Thickness of the plate that the bars are cut from.
    pub thickness: f64,
    /// Radius of the solid's skeleton struts. Those of actuators follow from the line densities.
    pub radius: f64,
}

/// An error about sizes or robots that do not fit one another.
pub(super) fn misfit(says: String) -> Error {
    Error::Usage(format!("cannot export: {says}"))
}
