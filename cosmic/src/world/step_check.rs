//! Checks whether the time step of a scene is stable for a body. A cheap bound on the frequencies of the body is tried
//! first; only if the time step is beyond it, the largest frequency itself is computed.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::stability::Vibration;
use crate::error::{Error, Result};
use crate::numbers::rounded;
use crate::scene::{
    MOST_SUBSTEPS, PhysicsSettings, UnstableStep, stable_step, stable_step_off_bars,
};

crate::keys! {
    /// A vibration, and the time step at which it begins to grow.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    struct StepLimit {
        /// The angular frequency of the vibration.
        frequency: f64, "number", unit "1/s";
        /// The smallest time step with which the vibration grows; `null` if it never grows.
        dt: Option<f64>, "number or `null`", unit "s";
        /// The node at which the vibration is largest.
        node: usize, "whole number";
    }
}

impl StepLimit {
    /// The limit by the largest frequency.
    pub fn exact(vibration: &Vibration, physics: &PhysicsSettings) -> Self {
        Self::new(vibration, vibration.fastest(), 1.0, physics)
    }

    /// A cheap limit that is never above [`exact`](Self::exact): by the bound from single edges. It holds for all robots
    /// that vibrate at most `faster` times as fast.
    pub fn safe(vibration: &Vibration, faster: f64, physics: &PhysicsSettings) -> Self {
        let (frequency, node) = vibration.edge_bound();
        Self::new(vibration, (faster * frequency, node), faster, physics)
    }

    /// The limit by a vibration of all forces, or by forces that an implicit step does not solve for if they limit the time
    /// step more.
    fn new(
        vibration: &Vibration,
        (frequency, node): (f64, usize),
        faster: f64,
        physics: &PhysicsSettings,
    ) -> Self {
        // A node that vibrates faster by a factor is lighter by the square of the factor, so its damping is larger by
        // that square.
        let damping = faster * faster * vibration.damping();
        let limit = |frequency, dt: f64, node| Self {
            frequency,
            // A limit that is not a number stays, so that no time step is below it.
            dt: (dt != f64::INFINITY).then_some(dt),
            node,
        };
        let all = stable_step(physics, frequency, damping);
        let others = vibration.off_bars(faster);
        let of_others = stable_step_off_bars(physics, others.frequency, others.damping);
        match of_others < all {
            true => limit(others.frequency, of_others, others.node),
            false => limit(frequency, all, node),
        }
    }

    /// The smallest time step, s, with which the vibration grows; infinite if it never grows.
    pub fn step(&self) -> f64 {
        self.dt.unwrap_or(f64::INFINITY)
    }

    /// The quotient of the time step `dt` and this limit; with a quotient of 1 or more, the vibration grows.
    pub fn share(&self, dt: f64) -> f64 {
        self.dt.map_or(0.0, |limit| dt / limit)
    }
}

/// How safe a time step is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Grade {
    /// The time step is below the limit that follows from a bound: no vibration about the checked positions grows.
    Safe,
    /// The time step is beyond the limit that follows from the bound, but below the limit that follows from the largest
    /// frequency.
    Close,
    /// The time step is beyond the limit of the largest frequency: the fastest vibration grows.
    Unstable,
}

crate::keys! {
    /// A time step compared with the vibrations of a body about a state at rest, with idle actuators.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    struct StepCheck {
        /// The time step.
        dt: f64, "number", unit "s";
        /// The number of substeps in a time step.
        substeps: usize, "whole number";
        /// The limit that follows from a bound on all frequencies, including those of the robots that `[robust]` draws.
        bound: StepLimit, "object", parts StepLimit;
        /// The limit that follows from the largest frequency itself; in a lattice of more than 1000 nodes, at most a
        /// thousandth below it. `null` if `dt` is below the limit of `bound`.
        exact: Option<StepLimit>, "object or `null`", parts StepLimit;
        /// Below this time step, all designs of the lattice are stable, and the robots that `[robust]` draws around
        /// them. `null` if nothing vibrates.
        any_design: Option<f64>, "number or `null`", unit "s";
    }
}

impl StepCheck {
    /// Checks the time step of `physics`. Below the time step `any_design` (s), every design of the lattice is stable.
    /// The bound for the design in `vibration` is multiplied by `faster`, so that it also holds for the robots that
    /// domain randomization draws.
    pub fn new(
        vibration: &Vibration,
        any_design: f64,
        faster: f64,
        physics: &PhysicsSettings,
    ) -> Self {
        let bound = StepLimit::safe(vibration, faster, physics);
        let beyond = bound.share(physics.dt) >= 1.0 && physics.dt >= any_design;
        Self {
            dt: physics.dt,
            bound,
            exact: beyond.then(|| StepLimit::exact(vibration, physics)),
            substeps: physics.substeps,
            any_design: any_design.is_finite().then_some(any_design),
        }
    }

    /// Returns a warning if the time step is safe for this design, but may not be safe for other designs of the
    /// lattice.
    pub fn of_other_designs(&self) -> Option<String> {
        let any = self.any_design.filter(|any| *any <= self.dt)?;
        (self.grade() == Grade::Safe).then(|| {
            format!(
                "the time step of {} s is stable for this design but may not be for later ones; to be safe for every \
                 design, set physics.dt below {} s",
                self.dt,
                rounded_down(any, 2)
            )
        })
    }

    /// How safe the time step is.
    pub fn grade(&self) -> Grade {
        match &self.exact {
            None => Grade::Safe,
            Some(exact) if exact.share(self.dt) < 1.0 => Grade::Close,
            Some(_) => Grade::Unstable,
        }
    }

    /// Refuses an unstable time step unless the scene allows it.
    ///
    /// # Errors
    /// [`Error::UnstableStep`].
    pub fn accept(&self, physics: &PhysicsSettings) -> Result<()> {
        match (self.grade(), physics.unstable_step) {
            (Grade::Unstable, UnstableStep::Error) => {
                let or_leave = "; to continue anyway set physics.unstable_step = \"warn\"";
                Err(self.error(or_leave))
            }
            _ => Ok(()),
        }
    }

    /// The error for an unstable time step. `or` is another remedy, or empty.
    pub(crate) fn error(&self, or: &str) -> Error {
        let limit = self.exact.unwrap_or(self.bound);
        Error::UnstableStep {
            dt: self.dt,
            limit: limit.step(),
            frequency: limit.frequency,
            node: limit.node,
            remedy: self.remedy() + or,
        }
    }

    /// The advice in messages: changes of settings that make the time step safe for this design and every other design.
    fn remedy(&self) -> String {
        let limits = [self.bound.dt, self.any_design];
        let safe = limits.into_iter().flatten().fold(f64::INFINITY, f64::min);
        let dt = if safe.is_finite() {
            rounded_down(safe, 2)
        } else {
            self.dt
        };
        // The stable time step is proportional to the number of substeps.
        let substeps = (self.dt / safe * self.substeps as f64).floor() + 1.0;
        let less = format!("set physics.dt to {dt} or less");
        if substeps <= MOST_SUBSTEPS {
            format!("{less}, or physics.substeps to {substeps} or more")
        } else {
            less
        }
    }
}

/// Writes the warning about the time step; writes nothing if the time step is safe.
impl fmt::Display for StepCheck {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(exact) = self.exact else {
            return Ok(());
        };
        let (dt, remedy) = (rounded(self.dt, 5), self.remedy());
        match (self.grade(), exact.dt, self.bound.dt) {
            (Grade::Close, Some(limit), Some(bound)) => write!(
                out,
                "the time step of {dt} s is beyond the safe bound of {bound:.3e} s (node {}), \
                 but below {limit:.3e} s, where vibrations begin to grow; {remedy}",
                self.bound.node
            ),
            // An unstable time step gets the text of the error, but without the advice to set `unstable_step`, which is
            // already set.
            _ => write!(out, "{}", self.error("")),
        }
    }
}

/// Rounds a positive number `x` down to `digits` significant digits. Infinity stays infinite.
pub fn rounded_down(x: f64, digits: usize) -> f64 {
    // Drops digits of the shortest decimal text of the number. A computed power of ten could have other bits on other
    // systems.
    let scientific = format!("{x:e}");
    let (significand, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let kept = &significand[..significand.len().min(digits + 1)];
    format!("{kept}e{exponent}").parse().unwrap_or(x)
}
