//! One iteration of the paper's algorithm 1, and the loop over all iterations.

use super::begin::CoDesign;
use super::progress::{Progress, Record};
use super::schedule::{PassKind, Phase, Schedule};
use crate::design::{Design, alternatives, attract, flips, snap};
use crate::error::Result;
use crate::judge::Delivery;
use crate::objective::{measures, violations};

impl CoDesign {
    /// Optimises from a seed and calls `observe` with the record of every iteration. To stop early, to save or to
    /// resume, call [`iterate`](Self::iterate) on a [`Progress`], or use `record::optimise_with`, which saves to
    /// a folder.
    ///
    /// # Errors
    /// The errors of [`begin`](Self::begin); [`Error::NotFinite`](crate::Error::NotFinite) if no gradient so far could be
    /// used; [`Error::UnstableStep`](crate::Error::UnstableStep) also if the time step becomes unstable after a later
    /// iteration.
    pub fn optimise(&mut self, seed: u64, mut observe: impl FnMut(&Record)) -> Result<Delivery> {
        let mut progress = self.begin(seed)?;
        while !self.is_done(&progress) {
            let record = self.iterate(&mut progress);
            observe(&record);
            progress.check_loss(&record)?;
            self.step_check(&progress).accept(&self.scene().physics)?;
        }
        Ok(self.deliver(&progress))
    }

    /// True if all iterations are done.
    pub fn is_done(&self, progress: &Progress) -> bool {
        progress.iteration >= self.scene().schedule.iterations
    }

    /// Does one iteration of the paper's algorithm 1.
    pub fn iterate(&mut self, progress: &mut Progress) -> Record {
        let iteration = progress.iteration + 1;
        let scene = self.scene().clone();
        let now = Schedule::at(&scene, iteration);
        let mut record = self.blank_record(progress, &now);
        match now.phase() {
            Phase::CoDesign | Phase::Attraction => match now.pass() {
                PassKind::Design => self.design_pass(progress, &now, &mut record),
                PassKind::Controller => self.controller_pass(progress, &now, None, &mut record),
            },
            Phase::Snap => self.snap(progress, &now),
            Phase::FineTuning => {
                let reached = self.polish(progress, &now);
                self.controller_pass(progress, &now, reached, &mut record);
            }
        }
        if now.phase() == Phase::Attraction {
            self.attract(progress, &now);
        }
        progress.iteration = iteration;
        progress.measurements.clear();
        progress.skipped += record.skipped;
        record.multipliers = progress.lagrangian.multiplier;
        record.penalties = progress.lagrangian.penalty;
        let check = self.step_check(progress);
        self.checked = Some((self.design(progress), check));
        record.time_step = Some(check);
        record
    }

    /// Attraction: if an edge clearly has a dominant material, moves the edge towards that material.
    fn attract(&self, progress: &mut Progress, now: &Schedule) {
        let mixtures = self.design(progress);
        let (confidence, nudge) = now.attraction();
        if let Some(z) = progress.design.undecided_mut() {
            attract(z, &mixtures.mixtures(), confidence, nudge);
        }
    }

    /// Gives every edge one material, within the widened volume bounds. Compares this layout with some alternative
    /// layouts in rollouts, and keeps the best of them.
    fn snap(&self, progress: &mut Progress, now: &Schedule) {
        let design = self.design(progress);
        let (mixtures, bounds) = (&design.mixtures(), now.volume_bounds());
        let (rules, trials) = (&self.rules, self.scene().schedule.snap_trials);
        let snapped = snap(mixtures, &bounds, rules);
        let others = alternatives(mixtures, &snapped, &bounds, rules, trials);
        let controller = &progress.controller;
        let (layout, _) = self
            .evaluator
            .best_layout(snapped, others, controller, progress.seed);
        progress.flips = flips(mixtures, &layout);
        progress.design = Design::Layout(layout);
    }

    /// A record with the values that are known at the start of an iteration.
    fn blank_record(&self, progress: &Progress, now: &Schedule) -> Record {
        let design = self.design(progress);
        let measures = measures(&design.mixtures(), self.scene().projection.delta);
        let thresholds = now.thresholds(&progress.first_measures);
        let pass = match now.phase() {
            Phase::CoDesign | Phase::Attraction => Some(now.pass()),
            Phase::Snap => None,
            Phase::FineTuning => Some(PassKind::Controller),
        };
        Record {
            iteration: now.iteration,
            phase: now.phase(),
            pass,
            horizon: now.horizon(),
            volume: measures.volume,
            actuator_volume: measures.actuator_volume,
            measures: measures.constrained(),
            violations: violations(measures.constrained(), &thresholds),
            ..Record::default()
        }
    }
}
