//! The current robot of an optimisation: its design, its walk, and its delivery.

use super::begin::CoDesign;
use super::progress::Progress;
use crate::design::{Design, Mixture};
use crate::inputs::Inputs;
use crate::judge::{Candidate, Delivery, Entrants, Measuring, Reached};
use crate::scene::{SelectionKind, SelectionSettings};
use crate::world::Trajectory;

impl CoDesign {
    /// The current design in the form that is simulated. Before the snap, this is the design vectors after the performance
    /// projection; after the snap, it is the layout (D7).
    pub fn design(&self, progress: &Progress) -> Design<Mixture<f64>> {
        self.evaluator.simulated(&progress.design)
    }

    /// Ranks the current robot in full rollouts, in the precision of gradients, and returns the result.
    pub fn evaluate(&self, progress: &Progress) -> Reached {
        let designs = [self.design(progress)];
        (self.evaluator).ranked(&designs, &progress.controller, progress.seed)[0]
    }

    /// Simulates the current robot from the unperturbed start, in the precision of gradients, and returns its states
    /// after the numbers of steps in `steps`; `None` if the robot diverges.
    pub fn watch(&self, progress: &Progress, steps: Vec<usize>) -> Option<Trajectory<f64>> {
        let precision = self.scene().gradient.precision;
        let robot = (&self.design(progress), &self.evaluator.nominal());
        (self.evaluator)
            .watched(&[robot], &progress.controller, steps, precision)
            .remove(0)
    }

    /// The inputs of a rollout of the current robot from the unperturbed start.
    pub fn inputs(&self, progress: &Progress) -> Inputs<f64> {
        Inputs {
            z: progress.design.vectors().into_owned(),
            controller: progress.controller.clone(),
            start: self.evaluator.start.clone(),
        }
    }

    /// The controllers among which one is chosen: the controller of the last iteration, then the candidates, without
    /// duplicates.
    pub fn entrants(&self, progress: &Progress) -> Vec<Candidate> {
        let candidates = progress.candidates.iter().cloned();
        let (same, others): (Vec<_>, Vec<_>) =
            candidates.partition(|c| c.controller == progress.controller);
        let is_chosen = self.scene().selection.kind != SelectionKind::Last && !others.is_empty();
        let merit = match same.first() {
            Some(candidate) => candidate.merit,
            None if is_chosen => self.evaluate(progress).merit,
            // There is no other candidate to compare with.
            None => f64::NAN,
        };
        let mut entrants = vec![Candidate {
            iteration: progress.iteration,
            merit,
            controller: progress.controller.clone(),
            spread: same.first().and_then(|c| c.spread),
        }];
        if is_chosen {
            entrants.extend(others);
        }
        entrants
    }

    /// Measures the quantiles of every candidate's merit (displacement or minus the loss) over the variations with which a
    /// controller is chosen.
    pub fn judge_candidates(&self, progress: &mut Progress) {
        let design = self.design(progress);
        let candidates = &progress.candidates;
        let spreads = (self.evaluator).selections(&design, candidates, progress.seed);
        for (candidate, spread) in progress.candidates.iter_mut().zip(spreads) {
            // Quantiles over diverged rollouts are minus infinity, which JSON cannot store.
            candidate.spread = Some(spread).filter(|s| s.p10.is_finite());
        }
    }

    /// Chooses the controller to deliver and measures the robot in full rollouts. If the optimisation ended before the
    /// snap, the edges of the simulated robot are mixtures of materials.
    pub fn deliver(&self, progress: &Progress) -> Delivery {
        let mut measuring = Measuring::over(SelectionSettings::FINAL_ROLLOUTS);
        let delivery = self.deliver_unless(progress, &mut measuring);
        delivery.expect("nothing stops these measurements")
    }

    /// Like [`deliver`](Self::deliver), but can be stopped: asks `measuring.is_stopped` after each measurement, and returns
    /// `None` as soon as that returns true. A later call with the same progress and the measurements that `measuring.known`
    /// then holds goes on where this one stopped. The delivered robot does not depend on `measuring.rollouts`.
    ///
    /// # Panics
    /// If there are fewer than eight rollouts.
    pub fn deliver_unless(
        &self,
        progress: &Progress,
        measuring: &mut Measuring,
    ) -> Option<Delivery> {
        let entrants = Entrants {
            design: &progress.design,
            controllers: self.entrants(progress),
            seed: progress.seed,
        };
        self.evaluator.measure(&entrants, measuring)
    }
}
