//! Runs of MMA and GCMMA to a stopping rule.

use super::method::{Asymptotes, Linearisation, Mma, MmaState, Update};
use super::settings::MmaSettings;
use crate::error::{OptimiserError, require};
use crate::problem::Problem;
use crate::run::{BALANCED, Run, Solution, Status, Stop};

/// A constraint that stays violated although its multiplier has reached the elastic cost `c` has a larger multiplier, or
/// cannot be satisfied. Then the weight of the objective is multiplied by this factor, which has the effect of a larger
/// `c`.
const LESS: f64 = 1e-3;
/// The least weight of the objective. With this weight, multipliers may be up to 1e15 times as large as the objective.
const LEAST: f64 = 1e-12;
/// The largest number of subproblems in an iteration. Each has at most ten times the curvature of the one before.
const MAX_INNER: usize = 40;
/// The least curvature of a model, relative to the largest slope of its function. It keeps the models of linear
/// functions strictly convex.
const FLATTEST: f64 = 1e-6;
/// The first models of an iteration have at least this part of the last curvature. Without it, every iteration would
/// have to find the curvature again: the test problems take 2.5 times as many evaluations as at 0.3.
const AGAIN: f64 = 0.3;
/// The assumed relative rounding error of values.
const NOISE: f64 = 1e-14;

/// Which version of the method a run uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Variant {
    /// The globally convergent version (GCMMA). It solves the subproblem again, with more curvature, until the models
    /// are conservative: no function is larger at the new point than its model. So the objective plus the cost of
    /// violations decreases in every iteration, and the run cannot cycle. An iteration costs one gradient and one or
    /// more values.
    #[default]
    Conservative,
    /// The original method: one value and one gradient in each iteration. It may cycle, mainly if the minimum is inside
    /// the bounds, where gradients vanish: from (1, 1) in the box from -2 to 2, the run on `x'x` keeps away from 0.
    Plain,
}

/// The options of [`minimise`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Options {
    /// The version of the method.
    pub variant: Variant,
    /// The settings of the method. The objective is divided by its scale (see [`Stop`]) before `c`, `d` and `raa0`
    /// apply.
    pub settings: MmaSettings,
    /// The stopping rule.
    pub stop: Stop,
}

/// Minimises the objective of a problem with inequality constraints and finite bounds, from a start within the bounds.
/// The start may violate constraints.
///
/// The cost beyond the user's functions is proportional to the number of variables and to the square of the number of
/// constraints.
///
/// # Errors
/// If a list has the wrong length, a bound or an entry of the start is not finite, bounds cross, the start is outside
/// the bounds, a setting is outside its range, or the problem has equalities. Everything that happens later is a
/// [`Status`].
pub fn minimise(
    problem: &mut Problem<'_>,
    start: &[f64],
    options: &Options,
) -> Result<Solution, OptimiserError> {
    require(problem.equalities == 0, || {
        "MMA takes inequality constraints only; use augmented::minimise for equalities".into()
    })?;
    let mma = Mma::new(options.settings.clone(), &problem.lower, &problem.upper)?;
    let mut driver = Driver {
        state: mma.init(start),
        mma,
        variant: options.variant,
        weight: 1.0,
        scale: 1.0,
        curvatures: Vec::new(),
        elastic: Vec::new(),
        run: Run::new(problem, start, &options.stop)?,
    };
    let end = driver.iterate();
    driver.run.finish(end)
}

struct Driver<'p, 'a> {
    mma: Mma,
    variant: Variant,
    state: MmaState,
    /// The weight of the objective.
    weight: f64,
    /// The factor of the objective in the last update: its weight divided by its scale.
    scale: f64,
    /// The curvatures of the last models, of the objective after multiplication with `scale`.
    curvatures: Vec<f64>,
    /// The elastic variables of the last update.
    elastic: Vec<f64>,
    run: Run<'p, 'a>,
}

impl Driver<'_, '_> {
    fn iterate(&mut self) -> Result<Status, OptimiserError> {
        self.run.evaluate()?;
        loop {
            let residuals = self.run.residuals();
            let stop = &self.run.stop;
            let feasible = residuals.violation <= stop.feasibility;
            let stationary = residuals.stationarity.max(residuals.complementarity) <= stop.kkt;
            if feasible && stationary {
                return Ok(self.run.optimal());
            }
            if self.run.is_infeasible() {
                return Ok(Status::Infeasible);
            }
            let still = self.run.step <= stop.step;
            // The elastic variables, not the constraints, made the point stationary.
            let elastic = self.elastic.iter().any(|&y| y > 0.0);
            let tight = feasible && residuals.complementarity <= BALANCED;
            let stretched = elastic && !tight && (still || self.run.is_balanced());
            if still || stretched {
                let least = self.weight <= LEAST;
                if feasible && (least || !stretched) {
                    return Ok(Status::SmallStep);
                }
                if least {
                    return Ok(Status::Infeasible);
                }
                self.weight *= LESS;
            }
            if self.run.iterations == self.run.stop.iterations {
                return Ok(Status::IterationLimit);
            }
            self.run.iterations += 1;
            self.update()?;
        }
    }

    fn update(&mut self) -> Result<(), OptimiserError> {
        let scale = match self.run.objective_scale() {
            0.0 => self.weight,
            scale => self.weight / scale,
        };
        if !scale.is_normal() {
            return Err(OptimiserError::Overflow);
        }
        if let Some(curvature) = self.curvatures.first_mut() {
            *curvature *= scale / self.scale;
        }
        self.scale = scale;
        let gradient: Vec<f64> = self.run.gradients[0].iter().map(|g| g * scale).collect();
        let guess: Vec<f64> = self.run.multipliers.iter().map(|l| l * scale).collect();
        let asymptotes = self.mma.asymptotes(&self.state, &self.run.point);
        self.begin_curvatures(&gradient);
        let (update, values) = self.subproblems(&gradient, &asymptotes, &guess)?;
        self.state.advance(&self.run.point, asymptotes, &[]);
        self.run.multipliers = update.multipliers.iter().map(|l| l / scale).collect();
        self.elastic = update.diagnostics.elastic;
        self.run.advance(update.point, values)
    }

    /// Solves subproblems until one is accepted. Returns its solution, and the values of all functions there.
    fn subproblems(
        &mut self,
        gradient: &[f64],
        asymptotes: &Asymptotes,
        guess: &[f64],
    ) -> Result<(Update, Vec<f64>), OptimiserError> {
        let Driver { mma, run, .. } = self;
        let at = Linearisation {
            point: &run.point,
            objective_gradient: gradient,
            constraints: &run.values[1..],
            jacobian: &run.gradients[1..],
        };
        let mut inner = 1;
        loop {
            let update = mma.solve(&at, asymptotes, &self.curvatures, guess)?;
            let values = run.problem.values(&update.point);
            let last = inner == MAX_INNER || self.variant == Variant::Plain;
            let missing = match values {
                Ok(values) => {
                    let models = mma.subproblem.models();
                    let missing = missing(&run.values, &values, &models, self.scale);
                    if last || missing.iter().all(|&missing| missing <= 0.0) {
                        return Ok((update, values));
                    }
                    missing
                }
                // A shorter step may stay where the functions are finite.
                Err(OptimiserError::NotFinite { .. }) if !last => {
                    vec![f64::INFINITY; run.values.len()]
                }
                Err(error) => return Err(error),
            };
            let bend = mma.subproblem.bend();
            for (curvature, missing) in self.curvatures.iter_mut().zip(missing) {
                if missing > 0.0 {
                    // The rule of Svanberg 2007 (GCMMA).
                    *curvature = (1.1 * (*curvature + missing / bend)).min(10.0 * *curvature);
                }
            }
            inner += 1;
        }
    }

    /// Chooses the curvatures of the first models of an iteration.
    fn begin_curvatures(&mut self, objective_gradient: &[f64]) {
        let count = self.run.values.len();
        if self.variant == Variant::Plain {
            self.curvatures = vec![self.mma.settings().raa0; count];
            self.curvatures[0] *= self.weight;
            return;
        }
        self.curvatures.resize(count, 0.0);
        for i in 0..count {
            let gradient = match i {
                0 => objective_gradient,
                _ => &self.run.gradients[i],
            };
            let slopes = (0..gradient.len()).map(|j| gradient[j].abs() * self.run.length(j));
            let (sum, most) = slopes.fold((0.0, 0.0), |(sum, most), slope| {
                (sum + slope, f64::max(most, slope))
            });
            // The rule of Svanberg 2007 (GCMMA).
            let mean = 0.1 * sum / gradient.len() as f64;
            let least = (FLATTEST * most).max(f64::MIN_POSITIVE);
            self.curvatures[i] = mean.max(AGAIN * self.curvatures[i]).max(least);
        }
    }
}

/// For each function, by how much its value exceeds its model; 0 or less if the model is conservative. A constraint that
/// holds at the new point needs no conservative model.
fn missing(before: &[f64], after: &[f64], models: &[f64], scale: f64) -> Vec<f64> {
    let missing = |i: usize| {
        let noise = NOISE * (before[i].abs() + after[i].abs());
        match i {
            0 => scale * (after[0] - before[0] - noise) - models[0],
            _ if after[i] <= 0.0 => 0.0,
            _ => after[i] - models[i] - noise,
        }
    };
    (0..before.len()).map(missing).collect()
}
