//! What may stop a robot that does not get far, and what to try. The page `docs/walks.md` says more.

use super::{Measured, WALKS};
use crate::judge::Reliability;
use crate::numbers::{brief, percent};

/// The share of what actuators can lift at most from which a payload may be too heavy.
const HEAVY: f64 = 0.5;
/// The margin of friction below which a slope may be too steep: the feet of a walking robot push.
const SLIPPERY: f64 = 2.0;

impl Measured<'_> {
    /// The hints; empty for a stiff and reliable robot that walks on to the end, and for a robot with another task.
    pub(super) fn hints(&self) -> Vec<String> {
        let Some(displacement) = self.displacement.filter(|_| self.is_far) else {
            return Vec::new();
        };
        let mut hints = Vec::new();
        let is_slow = displacement < WALKS[0] * self.length || self.standstill.is_some();
        if is_slow {
            let reasons = [self.slips(), self.carries_much(), self.meets_a_step()];
            hints.extend(reasons.into_iter().flatten());
            hints.push("try other seeds: `--starts 4`".to_owned());
        }
        let is_unreliable = matches!(self.reliability, Reliability::Unreliable { .. });
        let modes = self.structure.and_then(|structure| structure.floppy_modes);
        if is_slow || is_unreliable || modes.is_some_and(|modes| modes > 0) {
            hints.push("docs/walks.md says what helps most".to_owned());
        }
        hints
    }

    fn slips(&self) -> Option<String> {
        let margin = self.friction_margin.filter(|margin| *margin < SLIPPERY)?;
        let says = match margin < 1.0 {
            true => "no robot can stand on this slope: the friction is only",
            false => "the slope leaves little friction: it is",
        };
        Some(format!(
            "{says} {} times what holds a robot at rest; try a gentler slope (`physics.incline_deg`) or more friction \
             (`physics.friction`)",
            brief(margin)
        ))
    }

    fn carries_much(&self) -> Option<String> {
        (self.load > HEAVY && self.load.is_finite()).then(|| {
            format!(
                "the payload is heavy: it weighs {} of what the actuators can lift at most; try a lighter payload \
                 (`physics.payload_mass`) or stronger actuators",
                percent(self.load)
            )
        })
    }

    fn meets_a_step(&self) -> Option<String> {
        let at = self
            .standstill
            .map(|still| still.at)
            .or(self.displacement)?;
        let next = self.risers.iter().find(|riser| riser.along > at)?;
        Some(format!(
            "the next step is {} cm high, at {:.2} m from the start; try lower steps",
            brief(100.0 * next.height),
            next.along
        ))
    }
}
