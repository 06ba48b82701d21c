//! The numbers of the method and their ranges.

use serde::{Deserialize, Serialize};

use crate::optimiser::error::{OptimiserError, check_setting};

/// The numbers of the method, under the names that its literature uses.
///
/// "Range" is the distance of a variable's bounds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MmaParameters {
    /// Largest change of a variable in one update, as a share of its range; above 0.
    pub move_limit: f64,
    /// Distance of the first two updates' asymptotes, as a share of the range; above 0.
    pub asyinit: f64,
    /// Factor on the distance where a variable keeps its direction; at least 1.
    pub asyincr: f64,
    /// Factor on the distance where a variable turns; above 0, at most 1.
    pub asydecr: f64,
    /// Least distance of an asymptote, as a share of the range; above 0.
    pub asymin: f64,
    /// Largest distance of an asymptote, as a share of the range; at least `asymin`.
    pub asymax: f64,
    /// Share of the distance to an asymptote that a variable keeps from it; between 0 and 1.
    pub albefa: f64,
    /// Curvature added to every model, divided by the range; above 0.
    pub raa0: f64,
    /// Linear cost of the elastic variables; at least 0.
    pub c: f64,
    /// Quadratic cost of the elastic variables; above 0.
    pub d: f64,
}

impl Default for MmaParameters {
    /// Short, sign-following steps for noisy gradients; Svanberg's own first asymptotes and move
    /// limit are 0.5.
    fn default() -> Self {
        MmaParameters {
            move_limit: 0.02,
            asyinit: 0.05,
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

impl MmaParameters {
    /// Refuses values for which the method is not defined.
    pub(super) fn check(&self) -> Result<(), OptimiserError> {
        for (name, value) in [
            ("move_limit", self.move_limit),
            ("asyinit", self.asyinit),
            ("asymin", self.asymin),
            ("raa0", self.raa0),
            ("d", self.d),
        ] {
            let holds = value > 0.0 && value.is_finite();
            check_setting(name, value, holds, "positive and finite")?;
        }
        let (incr, decr, far) = (self.asyincr, self.asydecr, self.asymax);
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
                self.asymin <= far && far.is_finite(),
                "finite and at least asymin",
            ),
            (
                "albefa",
                self.albefa,
                0.0 < self.albefa && self.albefa < 1.0,
                "above 0 and below 1",
            ),
            (
                "c",
                self.c,
                0.0 <= self.c && self.c.is_finite(),
                "finite and at least 0",
            ),
        ];
        for (name, value, holds, allowed) in ranges {
            check_setting(name, value, holds, allowed)?;
        }
        Ok(())
    }
}
