//! Settling, the last part of the fine-tuning: returns to the best controller, and takes back every update that loses
//! distance.
//!
//! Gaits are chaotic. The fine-tuning finds good controllers and loses them again, because some updates halve the
//! distance. Such updates help to get away from poor controllers. But because of them, it is a matter of chance whether
//! the last controller is good. So the last iterations return to the best controller and stay close to it.

use super::begin::CoDesign;
use super::progress::{Progress, Settled};
use super::schedule::Schedule;
use crate::judge::first_best;
use crate::scene::SelectionKind;

/// An update is taken back if the merit (displacement or minus the loss) falls by more than this share.
const LOSS: f64 = 0.05;

impl CoDesign {
    /// Settles the controller. The first iteration that settles goes back to the best candidate. Later iterations go back
    /// to the last good controller if `merit`, the merit of the current controller, is too low. Returns true if the
    /// controller was replaced. The caller must then drop the gradient of this iteration, because it belongs to the old
    /// controller.
    pub fn settle(&self, progress: &mut Progress, now: &Schedule, merit: f64) -> bool {
        if !now.settles() {
            return false;
        }
        match &mut progress.settled {
            None => {
                if !self.begin_to_settle(progress) {
                    return false;
                }
            }
            // A merit may be negative, so the tolerance is a share of its absolute value.
            Some(settled) if merit >= settled.merit - LOSS * settled.merit.abs() => {
                settled.controller.clone_from(&progress.controller);
                settled.merit = settled.merit.max(merit);
                return false;
            }
            // The controller is unchanged, so there is no update to take back. The merit of its unperturbed rollout may
            // still be far below `settled.merit`, which can be its median merit.
            Some(settled) if progress.controller == settled.controller => {
                settled.merit = merit;
                return false;
            }
            Some(settled) => {
                settled.trust *= 0.5;
                progress.controller.clone_from(&settled.controller);
            }
        }
        // Adam's momentum belongs to the controller before the change.
        progress.adam.mean.fill(0.0);
        true
    }

    /// Replaces the controller by the candidate with the best [score](crate::judge::Merit::score) over perturbed
    /// starts. Returns false, without a change, if no candidate could be scored because rollouts diverged.
    fn begin_to_settle(&self, progress: &mut Progress) -> bool {
        self.judge_candidates(progress);
        let judged = progress.candidates.iter();
        let judged: Vec<_> = judged.filter_map(|c| Some((c.spread?, c))).collect();
        // Candidates are sorted by their merits. So of candidates with equal ranks, the one with the better merit is chosen.
        let best = first_best(
            judged
                .iter()
                .map(|(spread, c)| self.evaluator.rank(spread, c)),
        );
        let Some(&(ref spread, candidate)) = judged.get(best) else {
            return false;
        };
        let merit = match self.scene().selection.kind {
            SelectionKind::Robust => candidate.merit,
            _ => spread.p50,
        };
        progress.controller.clone_from(&candidate.controller);
        progress.settled = Some(Settled {
            controller: candidate.controller.clone(),
            merit,
            trust: 1.0,
        });
        true
    }
}
