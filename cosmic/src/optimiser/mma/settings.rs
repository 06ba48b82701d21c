//! The ranges of the method's settings.

use crate::optimiser::error::{OptimiserError, check_setting};
use crate::scene::MmaSettings;

/// Refuses values for which the method is not defined.
pub(super) fn check_settings(mma: &MmaSettings) -> Result<(), OptimiserError> {
    for (name, value) in [
        ("move_limit", mma.move_limit),
        ("asyinit", mma.asyinit),
        ("asymin", mma.asymin),
        ("raa0", mma.raa0),
        ("d", mma.d),
    ] {
        let holds = value > 0.0 && value.is_finite();
        check_setting(name, value, holds, "positive and finite")?;
    }
    let (incr, decr, far) = (mma.asyincr, mma.asydecr, mma.asymax);
    let ranges = [
        (
            "asyincr",
            incr,
            1.0 <= incr && incr.is_finite(),
            "finite and at least 1",
        ),
        (
            "asydecr",
            decr,
            0.0 < decr && decr <= 1.0,
            "above 0 and at most 1",
        ),
        (
            "asymax",
            far,
            mma.asymin <= far && far.is_finite(),
            "finite and at least asymin",
        ),
        (
            "albefa",
            mma.albefa,
            0.0 < mma.albefa && mma.albefa < 1.0,
            "above 0 and below 1",
        ),
        (
            "c",
            mma.c,
            0.0 <= mma.c && mma.c.is_finite(),
            "finite and at least 0",
        ),
    ];
    for (name, value, holds, allowed) in ranges {
        check_setting(name, value, holds, allowed)?;
    }
    Ok(())
}
