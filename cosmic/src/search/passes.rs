//! The two kinds of update: MMA updates the design, Adam updates the controller.

use super::begin::CoDesign;
use super::progress::{Progress, Record};
use super::schedule::{Phase, Schedule};
use super::slope::{GradientPoint, Slope};
use super::slopes::Variables;
use crate::design::{Design, clamp};
use crate::judge::Reached;
use crate::optimiser::{AdamState, Linearisation, bound_norm};
use crate::projection::Projection;
use crate::scene::ClockKind;

/// Before the snap, there is a full rollout in every iteration whose number is a multiple of this number. In the
/// fine-tuning there is one in every iteration, because every controller may be the one that is delivered.
const EVALUATE_EVERY: usize = 10;

/// The ratio of the learning rate of a learned clock's tempo to that of all other numbers of the controller. With a
/// ratio of 1 robots get less far in most worlds, and with 10 more of them are unreliable (`studies/options.md`).
const TEMPO_RATE: f64 = 3.0;

/// Bound on the norm of the displacement's design gradient (found by experiment).
const DESIGN_NORM: f64 = 0.3;

/// Bound on the norm of the whole controller gradient (found by experiment). The derivative by the tempo of a learned
/// clock is bounded by itself, to a third of this bound.
const CONTROLLER_NORM: f64 = 1.0;

/// Factor by which a penalty weight is multiplied if the violation of its measure grew, and divided if it fell (paper,
/// table 2).
const PENALTY_GROWTH: f64 = 1.01;

impl CoDesign {
    /// Updates the design once for the performance projection and once for the stability projection, and blends the two
    /// updates. Each projection has its own optimiser state. The multipliers of the augmented Lagrangian are updated
    /// only once, from the binarisation measures before the update (D10).
    pub(super) fn design_pass(
        &mut self,
        progress: &mut Progress,
        now: &Schedule,
        record: &mut Record,
    ) {
        let at = self.point(progress, now);
        let full = self.is_evaluated(now);
        let (slopes, evaluated) = rayon::join(
            || self.evaluator.design_slopes(&at),
            || full.then(|| self.evaluate(progress)),
        );
        note_displacement(record, evaluated);
        let seen = match slopes[0] {
            Some(_) => Projection::Performance,
            None => Projection::Stability,
        };
        let known: Vec<&Slope> = slopes.iter().flatten().collect();
        self.note_horizon(record, &known, Variables::Design(seen), &at);
        progress.note_slopes(known);

        let (rows, terms) = self.rows_and_terms(&at.inputs, progress, now);
        let share = self.scene().schedule.stability_share;
        let before = progress.design.vectors().into_owned();
        let mut z = before.clone();
        let shares = [1.0 - share, share];
        for (k, slope) in slopes.into_iter().enumerate() {
            let Some(mut slope) = slope else { continue };
            record.design_gradient[k] = Some(slope.bound(DESIGN_NORM));
            let memory = self.scene().gradient.design_memory;
            slope.averaged(&mut progress.design_mean[k], memory);
            for (g, term) in slope.gradient.iter_mut().zip(&terms) {
                *g += term;
            }
            let linearisation = Linearisation {
                point: before.as_flattened(),
                objective_gradient: &slope.gradient,
                constraints: &rows.values,
                jacobian: &rows.jacobian,
            };
            match self.mma.update(&mut progress.mma[k], &linearisation) {
                Ok(update) => {
                    blend(&mut z, &before, &update.point, shares[k]);
                    record.mma[k] = Some(update.diagnostics);
                }
                Err(_) => record.skipped += 1,
            }
        }
        clamp(&mut z);
        progress.design = Design::Undecided(z);
        if self.is_augmented() {
            let (lagrangian, before) = (&mut progress.lagrangian, &progress.violations);
            lagrangian.update(&record.violations, before, PENALTY_GROWTH);
        }
        progress.violations = record.violations;
    }

    /// Updates the controller. In the fine-tuning, first makes the old controller a candidate for delivery. `known` is
    /// the result of a full rollout with the old controller, if there was one already.
    pub(super) fn controller_pass(
        &self,
        progress: &mut Progress,
        now: &Schedule,
        known: Option<Reached>,
        record: &mut Record,
    ) {
        if let (Phase::FineTuning, Some(window)) = (now.phase(), &self.window) {
            return self.window_pass(window, progress, now, known, record);
        }
        let at = self.point(progress, now);
        let design = self.design(progress);
        let full = self.is_evaluated(now);
        let trust = progress.settled.as_ref().map_or(1.0, |s| s.trust);
        let rate = trust * now.learning_rate();
        let variables = if rate == 0.0 {
            Variables::Nothing(&design)
        } else {
            Variables::Controller(&design)
        };
        let ([slope], evaluated) = rayon::join(
            || self.evaluator.slopes([variables], &at),
            || known.or_else(|| full.then(|| self.evaluate(progress))),
        );
        note_displacement(record, evaluated);
        self.note_horizon(record, &[&slope], variables, &at);
        if rate != 0.0 {
            progress.note_slopes([&slope]);
        }
        if let (Phase::FineTuning, Some(reached)) = (now.phase(), evaluated) {
            progress.note_candidate(reached.merit);
            if self.settle(progress, now, reached.merit) {
                return;
            }
        }
        if rate == 0.0 {
            return;
        }
        let (numbers, adam) = (progress.controller.numbers_mut(), &mut progress.adam);
        let moved = self.move_numbers(numbers, adam, slope, rate);
        record.controller_gradient = Some(moved.norm);
        record.skipped += usize::from(moved.is_skipped);
    }

    /// Records what gradients tell about the robot within their horizon: the first one, except for a loss that is not
    /// finite.
    fn note_horizon(
        &self,
        record: &mut Record,
        slopes: &[&Slope],
        variables: Variables,
        at: &GradientPoint,
    ) {
        let lost = slopes.iter().find(|slope| !slope.loss.is_finite());
        let (first, is_far) = (slopes[0], self.evaluator.is_far());
        let displacement = self.evaluator.judged(first.displacement, variables, at);
        record.displacement_horizon = Some(displacement);
        record.merit_horizon = (!is_far).then_some(-first.loss);
        record.loss_horizon = Some(lost.unwrap_or(&first).loss);
        record.stuck = first.stuck;
    }

    /// Updates the numbers of a controller by Adam. A gradient that is not finite is skipped.
    pub(super) fn move_numbers(
        &self,
        numbers: &mut [f64],
        adam: &mut AdamState,
        mut slope: Slope,
        rate: f64,
    ) -> Moved {
        // The tempo of a learned clock is the last number. Its derivative grows with the phase: on 4x3 nodes it is 8
        // times the norm of all others in the median over a run, and 90 times at most. A common bound would shrink the
        // others.
        let tempos = usize::from(self.scene().controller.clock == ClockKind::Learned);
        let weights = slope.gradient.len() - tempos;
        let (others, tempo) = slope.gradient.split_at_mut(weights);
        let norms = [
            bound_norm(others, CONTROLLER_NORM),
            bound_norm(tempo, CONTROLLER_NORM / TEMPO_RATE),
        ];
        let before = numbers[weights..].to_vec();
        let updated = self.adam.update(adam, numbers, &slope.gradient, rate);
        for (tempo, before) in numbers[weights..].iter_mut().zip(before) {
            *tempo = before + TEMPO_RATE * (*tempo - before);
        }
        Moved {
            norm: norms[0].hypot(norms[1]),
            is_skipped: updated.is_err(),
        }
    }

    fn is_evaluated(&self, now: &Schedule) -> bool {
        now.phase() == Phase::FineTuning || now.iteration.is_multiple_of(EVALUATE_EVERY)
    }
}

/// An update of the numbers of a controller.
pub(super) struct Moved {
    /// The norm of the gradient before its bounds.
    pub(super) norm: f64,
    /// True if the gradient was not finite, so that nothing changed.
    pub(super) is_skipped: bool,
}

/// Records the displacement of a full rollout, if the iteration did one.
pub(super) fn note_displacement(record: &mut Record, reached: Option<Reached>) {
    record.displacement = reached.map(|reached| reached.along());
    record.diverged = record.displacement.is_some_and(f64::is_nan);
}

/// Adds `share` times the update from `from` to `to` to the design vectors `z`.
fn blend(z: &mut [[f64; 3]], from: &[[f64; 3]], to: &[f64], share: f64) {
    let places = z.as_flattened_mut().iter_mut().zip(from.as_flattened());
    for ((z, from), to) in places.zip(to) {
        *z += share * (to - from);
    }
}
