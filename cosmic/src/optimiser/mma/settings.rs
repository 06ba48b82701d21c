//! The check of the settings of MMA.

use crate::optimiser::error::{OptimiserError, require};
use crate::scene::MmaSettings;

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
