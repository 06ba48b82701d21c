//! The two kinds of update: of the design by MMA, of the controller by Adam.

use autodiff::{Real, Var};

use super::progress::{Candidate, MmaDiagnostics, Progress, Record};
use super::schedule::{Moment, Phase};
use super::{CoDesign, EVALUATE_EVERY};
use crate::design::clamp;
use crate::gradient::{CONTROLLER, DESIGN, Horizon, Inputs, Task};
use crate::objective::{Measures, measures};
use crate::optimiser::{Linearisation, MmaState, Update, bound_norm};
use crate::projection::Projection;
use crate::simulator::Trajectory;

/// A gradient of the displacement loss, and where the payload was after the horizon.
pub(super) struct Slope {
    pub(super) gradient: Vec<f64>,
    pub(super) displacement: f64,
}

impl Slope {
    /// Scales the gradient back to a norm where one is set; returns its own.
    fn bound(&mut self, norm: Option<f64>) -> f64 {
        bound_norm(&mut self.gradient, norm.unwrap_or(f64::INFINITY))
    }
}

/// The four volume bounds as constraints `f <= 0`.
struct VolumeRows {
    values: [f64; 4],
    jacobian: Vec<Vec<f64>>,
}

impl CoDesign {
    /// Moves the design by the performance and the stability projection, each with its own
    /// memory, and blends the two steps. Multipliers move once, on measures taken before (D10).
    pub(super) fn design_pass(
        &mut self,
        progress: &mut Progress,
        moment: &Moment,
        record: &mut Record,
    ) {
        let inputs = self.inputs(progress);
        let horizon = self.horizon(moment);
        let full = self.is_evaluated(moment);
        let worlds = self.worlds(progress, moment);
        let slope = |projection| {
            self.mean_slope(&worlds, &inputs, |task, inputs| {
                self.design_slope(task, inputs, (projection, &horizon))
            })
        };
        let ((performance, stability), evaluated) = rayon::join(
            || {
                rayon::join(
                    || slope(Projection::Performance),
                    || slope(Projection::Stability),
                )
            },
            || full.then(|| self.evaluate(progress)),
        );
        record.displacement = evaluated.map(|reached| reached.along());
        record.displacement_horizon = Some(performance.displacement);

        let thresholds = moment.thresholds(&progress.first_measures);
        let (_, terms) = inputs.differentiate(DESIGN, |inputs| {
            progress
                .lagrangian
                .terms(&self.measured(&inputs.z), &thresholds)
        });
        let rows = self.volume_rows(&inputs, moment);
        let share = self.scene.schedule.stability_share;
        let before = progress.z.clone();
        let updates = [(performance, 1.0 - share), (stability, share)];
        for (k, (mut slope, share)) in updates.into_iter().enumerate() {
            record.design_gradient[k] = Some(slope.bound(self.scene.gradient.design_norm));
            for (g, term) in slope.gradient.iter_mut().zip(&terms) {
                *g += term;
            }
            let memory = &mut progress.mma[k];
            match self.update_design(k, memory, &before, (&slope.gradient, &rows)) {
                Some(update) => {
                    let moved = progress.z.as_flattened_mut().iter_mut().zip(&update.point);
                    for ((z, point), from) in moved.zip(before.as_flattened()) {
                        *z += share * (point - from);
                    }
                    record.mma[k] = Some(MmaDiagnostics {
                        newton_steps: update.newton_steps,
                        residual: update.residual,
                        elastic: update.elastic,
                    });
                }
                None => record.skipped += 1,
            }
        }
        clamp(&mut progress.z);
        let growth = self.scene.binarisation.penalty_growth;
        progress
            .lagrangian
            .update(&record.violations, &progress.violations, growth);
        progress.violations = record.violations;
    }

    /// Moves the controller against its gradient; in the fine-tuning the controller that the
    /// iteration begins with becomes a candidate for delivery.
    pub(super) fn controller_pass(
        &self,
        progress: &mut Progress,
        moment: &Moment,
        record: &mut Record,
    ) {
        let inputs = self.inputs(progress);
        let mixture = self.mixture(progress);
        let horizon = self.horizon(moment);
        let full = self.is_evaluated(moment);
        let worlds = self.worlds(progress, moment);
        let (mut slope, evaluated) = rayon::join(
            || {
                self.mean_slope(&worlds, &inputs, |task, inputs| {
                    self.controller_slope(task, inputs, (&mixture, &horizon))
                })
            },
            || full.then(|| self.evaluate(progress)),
        );
        record.displacement = evaluated.map(|reached| reached.along());
        record.displacement_horizon = Some(slope.displacement);
        if let (Phase::FineTuning, Some(reached)) = (moment.phase(), evaluated) {
            self.note_candidate(progress, reached.merit);
        }
        record.controller_gradient = Some(slope.bound(self.scene.adam.gradient_norm));
        let mut weights = inputs.get(CONTROLLER);
        let rate = moment.learning_rate();
        match self
            .adam
            .update(&mut progress.adam, &mut weights, &slope.gradient, rate)
        {
            Ok(()) => {
                let mut moved = inputs;
                moved.set(CONTROLLER, &weights);
                progress.controller = moved.controller;
            }
            Err(_) => record.skipped += 1,
        }
    }

    /// Keeps a controller among the best single rollouts.
    pub(super) fn note_candidate(&self, progress: &mut Progress, merit: f64) {
        let candidate = Candidate {
            iteration: progress.iteration,
            along: merit,
            controller: progress.controller.clone(),
        };
        let better = |c: &Candidate| c.along >= merit;
        let place = progress.candidates.partition_point(better);
        if merit.is_finite() {
            progress.candidates.insert(place, candidate);
            progress
                .candidates
                .truncate(self.scene.selection.candidates);
        }
    }

    fn is_evaluated(&self, moment: &Moment) -> bool {
        moment.phase() == Phase::FineTuning || moment.iteration.is_multiple_of(EVALUATE_EVERY)
    }

    fn inputs(&self, progress: &Progress) -> Inputs<f64> {
        Inputs {
            z: progress.z.clone(),
            controller: progress.controller.clone(),
            start: self.start.clone(),
        }
    }

    fn design_slope(
        &self,
        task: &Task,
        inputs: &Inputs<f64>,
        (projection, horizon): (Projection, &Horizon),
    ) -> Slope {
        self.slope(inputs, DESIGN, |inputs| {
            let mixture = task.mixture(projection, &inputs.z);
            let robot = (&inputs.controller, &inputs.start);
            task.loss(&mixture, robot, (&self.objective, horizon))
        })
    }

    fn controller_slope(
        &self,
        task: &Task,
        inputs: &Inputs<f64>,
        (mixture, horizon): (&[[f64; 3]], &Horizon),
    ) -> Slope {
        self.slope(inputs, CONTROLLER, |inputs| {
            let mixture: Vec<_> = mixture.iter().map(|m| m.map(Var::constant)).collect();
            let robot = (&inputs.controller, &inputs.start);
            task.loss(&mixture, robot, (&self.objective, horizon))
        })
    }

    fn slope(
        &self,
        inputs: &Inputs<f64>,
        blocks: [bool; 7],
        loss: impl FnOnce(&Inputs<Var<f64>>) -> (Var<f64>, Trajectory<Var<f64>>),
    ) -> Slope {
        let mut displacement = f64::NAN;
        let (_, gradient) = inputs.differentiate(blocks, |inputs| {
            let (loss, trajectory) = loss(inputs);
            let last = trajectory.at(trajectory.last_step()).map(Var::value);
            [displacement, _] = self.between(&self.start, &last);
            loss
        });
        Slope {
            gradient,
            displacement,
        }
    }

    /// One update of the design; `None` where its gradient is not finite.
    fn update_design(
        &mut self,
        k: usize,
        memory: &mut MmaState,
        z: &[[f64; 3]],
        (gradient, rows): (&[f64], &VolumeRows),
    ) -> Option<Update> {
        let at = Linearisation {
            point: z.as_flattened(),
            objective_gradient: gradient,
            constraints: &rows.values,
            jacobian: &rows.jacobian,
        };
        self.mma[k].update(memory, &at).ok()
    }

    /// The measures of the performance projection (D10).
    fn measured<R: Real>(&self, z: &[[R; 3]]) -> Measures<R> {
        let mixture = self.task.mixture(Projection::Performance, z);
        measures(&mixture, self.scene.projection.delta)
    }

    /// The volume bounds and their derivatives by the design, on the performance projection.
    fn volume_rows(&self, inputs: &Inputs<f64>, moment: &Moment) -> VolumeRows {
        let scale = self.scene.mma.volume_row_scale;
        let bounds = moment.volume_bounds();
        let volume = |pick: fn(&Measures<Var<f64>>) -> Var<f64>| {
            inputs.differentiate(DESIGN, |inputs| pick(&self.measured(&inputs.z)))
        };
        let solid = volume(|m| m.volume);
        let actuator = volume(|m| m.actuator_volume);
        let row = |gradient: &[f64], sign: f64| gradient.iter().map(|g| sign * scale * g).collect();
        let mut rows = VolumeRows {
            values: [0.0; 4],
            jacobian: Vec::new(),
        };
        let both = [(solid, bounds.solid), (actuator, bounds.actuator)];
        for (k, ((value, gradient), [least, most])) in both.iter().enumerate() {
            rows.values[2 * k] = scale * (value - most);
            rows.values[2 * k + 1] = scale * (least - value);
            rows.jacobian
                .extend([row(gradient, 1.0), row(gradient, -1.0)]);
        }
        rows
    }
}
