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
use crate::scene::BinarisationMethod;
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

/// Constraints `f <= 0`: the four volume bounds, then the binarisation measures where they are
/// constraints.
struct Rows {
    values: Vec<f64>,
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
        let is_augmented = self.scene.binarisation.method == BinarisationMethod::Augmented;
        let mut terms = vec![0.0; 3 * progress.z.len()];
        let mut rows = self.volume_rows(&inputs, moment);
        if is_augmented {
            (_, terms) = inputs.differentiate(DESIGN, |inputs| {
                let measures = self.measured(&inputs.z);
                progress.lagrangian.terms(&measures, &thresholds)
            });
        } else {
            self.add_measures(&mut rows, &inputs, &thresholds);
        }
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
        if is_augmented {
            let before = &progress.violations;
            progress
                .lagrangian
                .update(&record.violations, before, growth);
        }
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
            self.loss_of(task, &mixture, (inputs, horizon))
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
            self.loss_of(task, &mixture, (inputs, horizon))
        })
    }

    /// The displacement loss and the rollout that it is of. With a second goal behind, the mean of
    /// the loss ahead and of minus the loss with that goal: the payload is to get as far back.
    fn loss_of<R: Real>(
        &self,
        task: &Task,
        mixture: &[[R; 3]],
        (inputs, horizon): (&Inputs<R>, &Horizon),
    ) -> (R, Trajectory<R>) {
        let robot = (&inputs.controller, &inputs.start);
        let loss = (&self.objective, horizon);
        let (ahead, trajectory) = task.loss(mixture, robot, loss);
        let Some(task) = &self.back else {
            return (ahead, trajectory);
        };
        let (back, _) = task.loss(mixture, robot, loss);
        (R::lit(0.5) * (ahead - back), trajectory)
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
        (gradient, rows): (&[f64], &Rows),
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
    fn volume_rows(&self, inputs: &Inputs<f64>, moment: &Moment) -> Rows {
        let scale = self.scene.mma.volume_row_scale;
        let bounds = moment.volume_bounds();
        let volume = |pick: fn(&Measures<Var<f64>>) -> Var<f64>| {
            inputs.differentiate(DESIGN, |inputs| pick(&self.measured(&inputs.z)))
        };
        let solid = volume(|m| m.volume);
        let actuator = volume(|m| m.actuator_volume);
        let row = |gradient: &[f64], sign: f64| gradient.iter().map(|g| sign * scale * g).collect();
        let mut rows = Rows {
            values: Vec::new(),
            jacobian: Vec::new(),
        };
        let both = [(solid, bounds.solid), (actuator, bounds.actuator)];
        for ((value, gradient), [least, most]) in &both {
            rows.values
                .extend([scale * (value - most), scale * (least - value)]);
            rows.jacobian
                .extend([row(gradient, 1.0), row(gradient, -1.0)]);
        }
        rows
    }

    /// Adds the four measures as constraints, on the performance projection (D10) and scaled as
    /// the volumes are.
    fn add_measures(&self, rows: &mut Rows, inputs: &Inputs<f64>, thresholds: &[f64; 4]) {
        let scale = self.scene.mma.volume_row_scale;
        for (k, threshold) in thresholds.iter().enumerate() {
            let (value, mut gradient) =
                inputs.differentiate(DESIGN, |inputs| self.measured(&inputs.z).constrained()[k]);
            gradient.iter_mut().for_each(|g| *g *= scale);
            rows.values.push(scale * (value - threshold));
            rows.jacobian.push(gradient);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::codesign::{CoDesign, Record, optimise};
    use crate::gradient::{CONTROLLER, DESIGN, Horizon, Inputs};
    use crate::projection::Projection;
    use crate::scene::{BinarisationMethod, HorizonMode, LossKind, Scene};

    fn tiny() -> Scene {
        let mut scene = Scene::default();
        (scene.lattice.columns, scene.lattice.rows) = (3, 2);
        (scene.physics.steps, scene.controller.hidden) = (24, 3);
        scene.schedule.iterations = 12;
        (scene.schedule.attraction_from, scene.schedule.snap_at) = (8, 11);
        scene.schedule.horizon = [24, 24];
        scene.loss.kind = LossKind::Final;
        scene
    }

    /// The loss of two goals, its gradient by design and controller against differences. The robot
    /// falls freely: nothing has a kink.
    #[test]
    fn the_loss_of_two_goals_has_the_gradient_of_differences() {
        let mut scene = tiny();
        (scene.lattice.drop, scene.controller.two_goals) = (1.0, true);
        scene.controller.goal_scale = 1.0;
        let codesign = CoDesign::new(&scene).unwrap();
        let progress = codesign.begin(1).unwrap();
        let inputs = codesign.inputs(&progress);
        let horizon = Horizon {
            steps: 24,
            mode: HorizonMode::Head,
            cotangent_bound: None,
        };
        let value = |inputs: &Inputs<f64>| {
            let mixture = codesign.task.mixture(Projection::Performance, &inputs.z);
            codesign
                .loss_of(&codesign.task, &mixture, (inputs, &horizon))
                .0
        };
        for blocks in [DESIGN, CONTROLLER] {
            let (_, gradient) = inputs.differentiate(blocks, |inputs| {
                let mixture = codesign.task.mixture(Projection::Performance, &inputs.z);
                codesign
                    .loss_of(&codesign.task, &mixture, (inputs, &horizon))
                    .0
            });
            let numbers = inputs.get(blocks);
            let direction: Vec<f64> = (0..numbers.len()).map(|k| (k as f64).cos()).collect();
            let at = |h: f64| {
                let moved = numbers.iter().zip(&direction).map(|(x, d)| x + h * d);
                let mut inputs = inputs.clone();
                inputs.set(blocks, &moved.collect::<Vec<_>>());
                value(&inputs)
            };
            let slope: f64 = gradient.iter().zip(&direction).map(|(g, d)| g * d).sum();
            let h = 1e-5;
            let difference = (at(h) - at(-h)) / (2.0 * h);
            // Positions of 0.1 m rounded at 1e-17 and divided by h: 1e-12; truncation h^2 beta^2,
            // 4e-8, of the slope.
            assert!((difference - slope).abs() < 1e-7 * slope.abs() + 1e-11);
            assert!(slope != 0.0);
        }
    }

    fn records(scene: &Scene) -> Vec<Record> {
        let mut records = Vec::new();
        optimise(scene, 0, |record| records.push(record.clone())).unwrap();
        records
    }

    #[test]
    fn measures_as_constraints_stand_beside_the_volumes() {
        let mut scene = tiny();
        let rows = |records: &[Record]| records[0].mma[0].as_ref().unwrap().elastic.len();
        assert_eq!(rows(&records(&scene)), 4);
        scene.binarisation.method = BinarisationMethod::Constraints;
        scene.binarisation.threshold_over = [0, 1];
        let strict = records(&scene);
        assert_eq!(rows(&strict), 8);
        let multipliers = |record: &Record| record.multipliers == [0.0; 4];
        assert!(strict.iter().all(multipliers));
        // From undecided towards one material each.
        assert!(strict[9].measures[0] < strict[0].measures[0]);
    }
}
