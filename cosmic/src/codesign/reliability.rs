//! The verdict whether the median over perturbed starts describes a robot, and the score by which robots are chosen.

use serde::{Deserialize, Serialize};

use super::quantiles::Quantiles;

/// The verdict whether the median over perturbed starts describes a robot.
///
/// The tolerance is half of the median's absolute value. A robot is unreliable in three cases:
/// - its 10 % quantile is below the median by more than the tolerance;
/// - the result of its unperturbed rollout differs from the median by more than the tolerance;
/// - one of these three numbers is not finite, because rollouts diverged.
///
/// The tolerance for distances is at least a twentieth of a spacing (5 mm in the paper's scenes), so that a robot that
/// does not move is not called unreliable. The tolerance for losses has no minimum.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "verdict", rename_all = "snake_case")]
pub enum Reliability {
    /// The median describes the robot well and is the figure to quote.
    Reliable,
    /// The median is misleading.
    Unreliable {
        /// The number that differs too much from the median, and the difference, as text.
        reason: String,
    },
}

/// The smallest tolerance is half of this share of the lattice's scale: a smaller median distance counts as this
/// distance. It is 1 cm in the paper's scenes.
const LEAST_DISTANCE: f64 = 0.01;

/// The kind of number that robots are ranked by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Merit {
    /// The displacement along the ground, in metres. `scale` is that of the [lattice](crate::lattice::Lattice::scale).
    Distance { scale: f64 },
    /// With two goals, a robot walks one distance towards each goal. This is the shorter of these distances, in metres.
    ShorterWay { scale: f64 },
    /// Minus the loss.
    MinusLoss,
}

impl Merit {
    /// The score by which controllers and runs are chosen: the median of a reliable robot, the 10 % quantile of an
    /// unreliable one. Because it is a single number, the choice does not depend on the order of the robots.
    pub(super) fn score(self, spread: &Quantiles, unperturbed: f64) -> f64 {
        match self.reliability(spread, unperturbed) {
            Reliability::Reliable => spread.p50,
            Reliability::Unreliable { .. } => spread.p10,
        }
    }

    /// Decides, from a robot's quantiles over perturbed starts and its unperturbed rollout, whether the median
    /// describes the robot.
    pub(super) fn reliability(self, spread: &Quantiles, unperturbed: f64) -> Reliability {
        let Quantiles { p10, p50, .. } = *spread;
        let unreliable = |reason: String| Reliability::Unreliable { reason };
        if ![p10, p50, unperturbed].iter().all(|x| x.is_finite()) {
            return unreliable("rollouts diverge".to_owned());
        }
        let (least, of_which) = match self {
            Self::Distance { scale } => (LEAST_DISTANCE * scale, ""),
            Self::ShorterWay { scale } => (LEAST_DISTANCE * scale, " of the shorter displacement"),
            Self::MinusLoss => (0.0, ""),
        };
        let tolerance = 0.5 * p50.abs().max(least);
        let is_low = p50 - p10 > tolerance;
        if !is_low && (unperturbed - p50).abs() <= tolerance {
            return Reliability::Reliable;
        }
        unreliable(match (is_low, self) {
            (true, Self::MinusLoss) => format!(
                "the 90 % quantile of the loss over perturbed starts is {:.4}, more than {tolerance:.4} \
                 above the median of {:.4}",
                -p10, -p50
            ),
            (false, Self::MinusLoss) => format!(
                "the loss of the unperturbed rollout is {:.4}, more than {tolerance:.4} away from the \
                 median of {:.4} over perturbed starts",
                -unperturbed, -p50
            ),
            (true, _) => format!(
                "the 10 % quantile{of_which} over perturbed starts is {p10:.3} m, more than {tolerance:.3} m \
                 below the median of {p50:.3} m"
            ),
            (false, _) => format!(
                "the unperturbed rollout reaches {unperturbed:.3} m{of_which}, more than {tolerance:.3} m away \
                 from the median of {p50:.3} m over perturbed starts"
            ),
        })
    }
}

impl Reliability {
    /// Why the robot is unreliable, or `None`.
    pub fn reason(&self) -> Option<&str> {
        match self {
            Self::Reliable => None,
            Self::Unreliable { reason } => Some(reason),
        }
    }

    /// The verdict in one word: `reliable` or `unreliable`.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Reliable => "reliable",
            Self::Unreliable { .. } => "unreliable",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Merit, Reliability};
    use crate::codesign::Quantiles;

    const FAR: Merit = Merit::Distance { scale: 1.0 };

    fn spread(p10: f64, p50: f64) -> Quantiles {
        let p90 = p50 + 1.0;
        Quantiles { p10, p50, p90 }
    }

    /// The reason why a robot with these quantiles is unreliable; empty if it is reliable.
    fn reason(merit: Merit, [p10, p50, unperturbed]: [f64; 3]) -> String {
        let found = merit.reliability(&spread(p10, p50), unperturbed);
        found.reason().unwrap_or_default().to_owned()
    }

    #[test]
    fn an_unreliable_robot_has_a_reason() {
        let far = |numbers| reason(FAR, numbers);
        assert_eq!(far([1.6, 3.0, 4.4]), "");
        assert_eq!(
            far([-1.537, 3.093, 3.0]),
            "the 10 % quantile over perturbed starts is -1.537 m, more than 1.546 m below the median \
             of 3.093 m"
        );
        assert!(far([3.0, 3.093, -4.2]).starts_with("the unperturbed rollout reaches -4.200 m, "));
        assert!(far([3.0, 3.0, 4.6]).contains("1.500 m away"));
        let diverged = [f64::NEG_INFINITY, 3.0, 3.0];
        assert_eq!(far(diverged), "rollouts diverge");
        assert_eq!(far([3.0, 3.0, f64::NAN]), "rollouts diverge");
    }

    /// A robot that walks backwards is as reliable as one that walks forwards.
    #[test]
    fn negative_medians_are_compared_by_their_absolute_value() {
        let far = |numbers| reason(FAR, numbers);
        assert_eq!(far([-2.9, -2.0, -1.1]), "");
        assert!(far([-3.1, -2.0, -2.0]).contains("-3.100 m"));
        // For a robot that barely moves, the numbers may differ by at most 5 mm.
        assert_eq!(far([-0.004, 0.0, 0.004]), "");
        assert!(far([-0.006, 0.0, 0.0]).contains("0.005 m below"));
        // With losses, the merit is minus the loss.
        let loss = |numbers| reason(Merit::MinusLoss, numbers);
        assert_eq!(loss([-0.5, -0.4, -0.3]), "");
        let worse = loss([-0.9, -0.4, -0.4]);
        for words in ["loss over perturbed starts is 0.9000", "median of 0.4000"] {
            assert!(worse.contains(words), "{worse}");
        }
        assert_eq!(loss([0.0, 0.0, 0.0]), "");
    }

    #[test]
    fn the_score_of_an_unreliable_robot_is_its_lower_quantile() {
        let score = |numbers: [f64; 3]| FAR.score(&spread(numbers[0], numbers[1]), numbers[2]);
        let reliable = score([1.9, 2.0, 2.0]);
        assert_eq!(reliable, 2.0);
        // Two unreliable robots: the first because of its quantile, the second because of its unperturbed rollout.
        assert_eq!(score([1.4, 3.0, 3.0]), 1.4);
        assert_eq!(score([1.6, 3.0, -4.0]), 1.6);
        // An unreliable robot may still have the higher score.
        assert!(score([2.4, 5.0, 5.0]) > reliable);
    }

    #[test]
    fn files_have_the_verdict_and_the_reason() {
        let json = |found: &Reliability| serde_json::to_string(found).unwrap();
        assert_eq!(json(&Reliability::Reliable), r#"{"verdict":"reliable"}"#);
        let found = FAR.reliability(&spread(0.0, 3.0), 3.0);
        let text = json(&found);
        assert!(
            text.starts_with(r#"{"verdict":"unreliable","reason":"the 10 %"#),
            "{text}"
        );
        assert_eq!(serde_json::from_str::<Reliability>(&text).unwrap(), found);
    }
}
