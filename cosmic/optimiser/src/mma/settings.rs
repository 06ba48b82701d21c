//! The settings of MMA.

use crate::error::{OptimiserError, require};

/// The settings of the method. The defaults are those of Svanberg's own programs.
#[derive(Debug, Clone, PartialEq)]
pub struct MmaSettings {
    /// Largest change of a variable in an update, divided by its range. Above 0; 0.5 by default.
    pub move_limit: f64,
    /// Distance of the first asymptotes, divided by the range. Above 0; 0.5 by default.
    pub asyinit: f64,
    /// Factor on the distance of the asymptotes if a variable keeps its direction. At least 1; 1.2 by default.
    pub asyincr: f64,
    /// Factor on the distance of the asymptotes if a variable changes its direction. From above 0 to 1; 0.7 by default.
    pub asydecr: f64,
    /// Least distance of the asymptotes, divided by the range. Above 0; 0.01 by default.
    pub asymin: f64,
    /// Largest distance of the asymptotes, divided by the range. At least `asymin`; 10 by default.
    pub asymax: f64,
    /// Part of the distance to an asymptote that a variable keeps from it. Between 0 and 1; 0.1 by default.
    pub albefa: f64,
    /// Curvature that is added to every model, in units of the function. Above 0; 1e-5 by default.
    /// [`Variant::Conservative`](super::Variant::Conservative) chooses curvatures itself and does not use it.
    pub raa0: f64,
    /// Linear cost of the elastic variables. It must exceed all multipliers of the solution. At least 0; 1000 by
    /// default.
    pub c: f64,
    /// Quadratic cost of the elastic variables. Above 0; 1 by default.
    pub d: f64,
}

impl Default for MmaSettings {
    fn default() -> Self {
        MmaSettings {
            move_limit: 0.5,
            asyinit: 0.5,
            asyincr: 1.2,
            asydecr: 0.7,
            asymin: 0.01,
            asymax: 10.0,
            albefa: 0.1,
            raa0: 1e-5,
            c: 1000.0,
            d: 1.0,
        }
    }
}

/// Refuses settings with which the method would not work.
pub(super) fn check_settings(mma: &MmaSettings) -> Result<(), OptimiserError> {
    let check = |name: &str, value: f64, holds: bool, allowed: &str| {
        require(holds && value.is_finite(), || {
            format!("{name} is {value}; it must be {allowed}")
        })
    };
    for (name, value) in [
        ("move_limit", mma.move_limit),
        ("asyinit", mma.asyinit),
        ("asymin", mma.asymin),
        ("raa0", mma.raa0),
        ("d", mma.d),
    ] {
        check(name, value, value > 0.0, "positive and finite")?;
    }
    let (incr, decr, near, far) = (mma.asyincr, mma.asydecr, mma.asymin, mma.asymax);
    check("asyincr", incr, incr >= 1.0, "finite and at least 1")?;
    let falls = decr > 0.0 && decr <= 1.0;
    check("asydecr", decr, falls, "above 0 and at most 1")?;
    check("asymax", far, far >= near, "finite and at least asymin")?;
    let keeps = mma.albefa > 0.0 && mma.albefa < 1.0;
    check("albefa", mma.albefa, keeps, "above 0 and below 1")?;
    check("c", mma.c, mma.c >= 0.0, "finite and at least 0")
}
