//! The verdict whether the median over varied robots describes a robot, and the score by which robots are chosen.

use serde::{Deserialize, Serialize};

use super::other_steps::OtherSteps;
use super::quantiles::Quantiles;
use crate::numbers::short;
use crate::scene::Integrator;

/// The verdict whether the median over robots that [vary](super::VARIED) a little describes a robot.
///
/// The tolerance is half of the median's absolute value. A robot is unreliable in three cases:
/// - its 10 % quantile is below the median by more than the tolerance;
/// - the result of its unperturbed rollout differs from the median by more than the tolerance;
/// - one of these three numbers is not finite, because rollouts diverged.
///
/// The tolerance for distances is at least a twentieth of a spacing (5 mm in the paper's scenes), so that a robot that
/// does not move is not called unreliable. The tolerance for losses has no minimum.
///
/// Robots that are told where to go have different goals in each rollout, and another one in the unperturbed rollout. So
/// only the first and the third case count, and the tolerance is at least a quarter of the way to a goal.
///
/// A delivered robot is also unreliable if its median over perturbed starts changes by more than [`STEADY`] with half the
/// time step or with [another integrator](super::OtherSteps), or if it should walk far but [stands
/// still](super::Standstill) or [stays in place](crate::lattice::Lattice::least_walk).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "verdict", rename_all = "snake_case")]
pub enum Reliability {
    /// The median describes the robot well and is the figure to quote.
    Reliable,
    /// The median is misleading.
    Unreliable {
        /// True for a robot that should walk far but stays in place. In files, the key is absent for all other robots.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        stays_in_place: bool,
        /// The numbers that differ too much from the median, and the differences, as text.
        reason: String,
    },
}

/// The share of a median up to which another median counts as equal. Medians over perturbed starts of a chaotic robot
/// differ by a few per cent even if nothing else changes.
pub const STEADY: f64 = 0.2;

/// The smallest tolerance is half of this share of the lattice's scale: a smaller median distance counts as this
/// distance. It is 1 cm in the paper's scenes.
const LEAST_DISTANCE: f64 = 0.01;

/// The least median of the losses of robots with given goals that counts: half of the way to a goal.
const LEAST_SHARE: f64 = 0.5;

/// A median distance that is shorter than this share of the lattice's scale counts as this distance when medians are
/// compared: a robot that stays in place does not depend on the time step.
pub const LEAST_MEDIAN: f64 = 0.05;

/// The kind of number that robots are ranked by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Merit {
    /// The displacement along the ground, in metres. `scale` is that of the [lattice](crate::lattice::Lattice::scale).
    Distance {
        /// The scale of the lattice, m.
        scale: f64,
    },
    /// Minus the loss.
    MinusLoss,
    /// With given goals: minus the loss, over rollouts with different goals.
    MinusShare,
}

impl Merit {
    /// The score by which controllers and runs are chosen: the median of a reliable robot, the 10 % quantile of an
    /// unreliable one. Because it is a single number, the choice does not depend on the order of the robots.
    pub fn score(self, spread: &Quantiles, unperturbed: f64) -> f64 {
        match self.reliability(spread, unperturbed) {
            Reliability::Reliable => spread.p50,
            Reliability::Unreliable { .. } => spread.p10,
        }
    }

    /// Decides, from the quantiles over varied robots and the robot's unperturbed rollout, whether the median describes
    /// the robot.
    pub fn reliability(self, spread: &Quantiles, unperturbed: f64) -> Reliability {
        let Quantiles { p10, p50, .. } = *spread;
        let unreliable = |reason: String| Reliability::Unreliable {
            stays_in_place: false,
            reason,
        };
        if ![p10, p50, unperturbed].iter().all(|x| x.is_finite()) {
            return unreliable("rollouts diverge".to_owned());
        }
        let least = match self {
            Self::Distance { scale } => LEAST_DISTANCE * scale,
            Self::MinusLoss => 0.0,
            Self::MinusShare => LEAST_SHARE,
        };
        let tolerance = 0.5 * p50.abs().max(least);
        let is_low = p50 - p10 > tolerance;
        let is_apart = (unperturbed - p50).abs() > tolerance && self != Self::MinusShare;
        if !is_low && !is_apart {
            return Reliability::Reliable;
        }
        unreliable(match (is_low, self) {
            (true, Self::MinusLoss | Self::MinusShare) => format!(
                "the 90 % quantile of the loss of varied robots is {:.4}, more than {tolerance:.4} above their \
                 median of {:.4}",
                -p10, -p50
            ),
            (false, Self::MinusLoss) => format!(
                "the loss of the unperturbed rollout is {:.4}, more than {tolerance:.4} away from the \
                 median of {:.4} of varied robots",
                -unperturbed, -p50
            ),
            (true, _) => format!(
                "the 10 % quantile of varied robots is {p10:.3} m, more than {tolerance:.3} m below their \
                 median of {p50:.3} m"
            ),
            (false, _) => format!(
                "the unperturbed rollout reaches {unperturbed:.3} m, more than {tolerance:.3} m away \
                 from the median of {p50:.3} m of varied robots"
            ),
        })
    }

    /// The reasons not to trust a robot whose median merit over perturbed starts is `own`, and `other` if time is cut into
    /// other steps; empty if these medians are close. `integrator` is that of the scene.
    pub fn unsteady(self, own: f64, other: &OtherSteps, integrator: Integrator) -> Vec<String> {
        let least = match self {
            Self::Distance { scale } => LEAST_MEDIAN * scale,
            Self::MinusLoss => 0.0,
            Self::MinusShare => LEAST_SHARE,
        };
        let shown = |merit: f64| match self {
            Self::MinusLoss | Self::MinusShare => format!("{:.4}", -merit),
            Self::Distance { .. } => format!("{merit:.2} m"),
        };
        let name = |integrator: Integrator| match integrator {
            Integrator::SymplecticEuler => "symplectic Euler",
            Integrator::Leapfrog => "leapfrog",
            Integrator::Implicit => "implicit steps",
        };
        let half = (
            other.half.merit,
            "at half the time step".to_owned(),
            "at the scene's time step".to_owned(),
        );
        let by_other = other.integrator.map(|(by, medians)| {
            let here = format!("with the scene's {}", name(integrator));
            (medians.merit, format!("with {}", name(by)), here)
        });
        let compared = std::iter::once(half).chain(by_other);
        let is_far = |&(merit, ..): &(f64, String, String)| {
            // The medians of diverged rollouts are not finite.
            let is_near = (merit - own).abs() <= STEADY * own.abs().max(least);
            own.is_finite() && !is_near
        };
        let says = |(merit, there, here): (f64, String, String)| {
            let walks = match self {
                Self::Distance { .. } => "it walks",
                Self::MinusLoss | Self::MinusShare => "its loss is",
            };
            match merit.is_finite() {
                true => format!(
                    "{walks} {} {there}, but {} {here}",
                    shown(merit),
                    shown(own)
                ),
                false => format!("it diverges {there}"),
            }
        };
        compared.filter(is_far).map(says).collect()
    }
}

impl Reliability {
    /// This verdict with more reasons not to trust the robot.
    pub(super) fn and(self, reasons: impl IntoIterator<Item = String>) -> Self {
        let own = self.reason().map(str::to_owned);
        let all: Vec<String> = own.into_iter().chain(reasons).collect();
        match all.is_empty() {
            true => Self::Reliable,
            false => Self::Unreliable {
                stays_in_place: self.stays_in_place(),
                reason: all.join("; "),
            },
        }
    }

    /// The verdict on a robot that should walk far, given the median displacement (m) that this verdict is about. A robot
    /// that moves by less than `least` stays in place, which comes before all other reasons.
    pub fn of_walk(self, displacement: f64, least: f64) -> Self {
        // A median over diverged rollouts is not finite, and has its reason already.
        if displacement.abs() >= least {
            return self;
        }
        let first = format!(
            "it stays in place: it moves by {} m, and {} m are a twentieth of its length",
            short(displacement),
            short(least)
        );
        let reasons = std::iter::once(first).chain(self.reason().map(str::to_owned));
        Self::Unreliable {
            stays_in_place: true,
            reason: reasons.collect::<Vec<_>>().join("; "),
        }
    }

    /// True for a robot that should walk far but stays in place.
    pub fn stays_in_place(&self) -> bool {
        matches!(
            self,
            Self::Unreliable {
                stays_in_place: true,
                ..
            }
        )
    }

    /// Why the robot is unreliable, or `None`.
    pub fn reason(&self) -> Option<&str> {
        match self {
            Self::Reliable => None,
            Self::Unreliable { reason, .. } => Some(reason),
        }
    }

    /// The verdict in a word or two, for tables: `reliable`, `unreliable` or `stays in place`.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Reliable => "reliable",
            _ if self.stays_in_place() => "stays in place",
            Self::Unreliable { .. } => "unreliable",
        }
    }
}
