//! The end of the fine-tuning: from the best controller on, by updates that lose nothing.
//!
//! Gaits are chaotic: the fine-tuning finds good controllers and loses them again, some of its
//! updates halve the distance. That is how it gets away from poor ones; but what it happens to
//! stand at in the end is no result. So its last part goes back to the best and stays there.

use serde::{Deserialize, Serialize};

use super::progress::Progress;
use super::schedule::{Moment, Phase};
use super::{CoDesign, Spread};
use crate::controller::Controller;

/// Share of the merit that an update may lose.
const LOSS: f64 = 0.05;

/// What the rest of the fine-tuning comes back to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settled {
    /// The last controller that lost nothing.
    pub controller: Controller<f64>,
    /// What it is held against: at first the median of the best candidate, later the best single
    /// rollout; m along the ground, for another task than to get far minus its loss.
    pub merit: f64,
    /// What is left of the learning rate: halved by every update that is taken back.
    pub trust: f64,
}

impl CoDesign {
    /// Goes back to the best candidate at the first iteration of the end, and later to the last
    /// good controller where the rollout of the present one has fallen behind. Returns whether it
    /// did: the gradient at hand is then of another controller.
    pub(super) fn settle(&self, progress: &mut Progress, moment: &Moment, merit: f64) -> bool {
        if moment.phase() != Phase::FineTuning || !moment.settles() {
            return false;
        }
        match &mut progress.settled {
            None => {
                if !self.begin_to_settle(progress) {
                    return false;
                }
            }
            // Losses are of either sign: a share of their size.
            Some(settled) if merit >= settled.merit - LOSS * settled.merit.abs() => {
                settled.controller.clone_from(&progress.controller);
                settled.merit = settled.merit.max(merit);
                return false;
            }
            Some(settled) => {
                settled.trust *= 0.5;
                progress.controller.clone_from(&settled.controller);
            }
        }
        progress.adam.mean.fill(0.0);
        true
    }

    /// Goes back to the candidate with the best median over perturbed starts, if there is any.
    fn begin_to_settle(&self, progress: &mut Progress) -> bool {
        self.judge_candidates(progress);
        let median = |spread: &Option<Spread>| spread.map_or(f64::NEG_INFINITY, |s| s.p50);
        let candidates = progress.candidates.iter();
        let best = candidates.max_by(|a, b| median(&a.spread).total_cmp(&median(&b.spread)));
        let Some(best) = best else {
            return false;
        };
        progress.controller.clone_from(&best.controller);
        progress.settled = Some(Settled {
            controller: best.controller.clone(),
            merit: median(&best.spread),
            trust: 1.0,
        });
        true
    }
}
