//! The augmented Lagrangian, for equality and inequality constraints and bounds, which may be infinite.
//!
//! The method of R. Andreani, E. G. Birgin, J. M. Martinez and M. L. Schuverdt, "On augmented Lagrangian methods with
//! general lower-level constraints", SIAM Journal on Optimization 18 (2007) 1286-1309. It minimises
//!
//! `f_0(x) + r / 2 sum_i (f_i(x) + l_i / r)^2`
//!
//! within the bounds, where terms of inequalities count only if they are positive. Then it replaces the multipliers
//! `l_i` by `r (f_i + l_i / r)`, and multiplies the penalty `r` by ten if the violations have not halved. Each
//! minimisation is a limited-memory quasi-Newton method with projection onto the bounds. All functions are divided by
//! their largest derivative at the start, times the range of its variable, if that is above 1. So large constraints count
//! no more than small ones.

use crate::descent::{Bounds, Memory};
use crate::error::OptimiserError;
use crate::problem::Problem;
use crate::run::{Run, Solution, Status, Stop};

/// Factor on the penalty if the violations have not become smaller than `SHARE` times what they were.
const GROWTH: f64 = 10.0;
const SHARE: f64 = 0.5;
/// The first penalty if the start satisfies all constraints.
const FEASIBLE: f64 = 1e4;
/// The largest penalty.
const LARGEST: f64 = 1e12;
/// The largest multiplier that a minimisation uses.
const BOUND: f64 = 1e20;

/// Minimises the objective of a problem from a start within its bounds. The start may violate constraints. An iteration
/// is a quasi-Newton step or an update of the multipliers.
///
/// ```
/// use cosmic_optimiser::{Problem, Status, Stop, augmented};
///
/// // The point of the circle x^2 + y^2 = 2 with the least x + y.
/// let mut problem = Problem::new(
///     &[f64::NEG_INFINITY; 2],
///     &[f64::INFINITY; 2],
///     |x| vec![x[0] + x[1], x[0] * x[0] + x[1] * x[1] - 2.0],
///     |x| vec![1.0, 1.0, 2.0 * x[0], 2.0 * x[1]],
/// )
/// .with_equalities(1);
/// let solution = augmented::minimise(&mut problem, &[-2.0, 0.5], &Stop::default())?;
/// assert_eq!(solution.status, Status::Converged);
/// assert!((solution.objective + 2.0).abs() < 1e-5);
/// # Ok::<(), cosmic_optimiser::OptimiserError>(())
/// ```
///
/// # Errors
/// If a list has the wrong length, an entry of the start is not finite, bounds cross, or the start is outside the
/// bounds. Everything that happens later is a [`Status`].
pub fn minimise(
    problem: &mut Problem<'_>,
    start: &[f64],
    stop: &Stop,
) -> Result<Solution, OptimiserError> {
    let mut driver = Driver {
        run: Run::new(problem, start, stop)?,
        lagrangian: Lagrangian::default(),
        memory: Memory::default(),
        accuracy: 0.1,
        infeasibility: f64::INFINITY,
    };
    let end = driver.iterate();
    driver.run.finish(end)
}

/// The augmented Lagrangian of the scaled functions.
#[derive(Default)]
struct Lagrangian {
    equalities: usize,
    /// The factor of each function.
    weights: Vec<f64>,
    /// The multiplier of each scaled constraint.
    multipliers: Vec<f64>,
    penalty: f64,
}

impl Lagrangian {
    /// The multipliers after an update with these values of the functions.
    fn updated(&self, values: &[f64]) -> Vec<f64> {
        let updated = |i: usize| {
            let sum = self.multipliers[i] + self.penalty * self.weights[1 + i] * values[1 + i];
            if i < self.equalities {
                sum
            } else {
                sum.max(0.0)
            }
        };
        (0..self.multipliers.len()).map(updated).collect()
    }

    fn value(&self, values: &[f64]) -> f64 {
        let squares: f64 = self.updated(values).iter().map(|l| l * l).sum();
        self.weights[0] * values[0] + 0.5 * squares / self.penalty
    }

    fn gradient(&self, values: &[f64], gradients: &[Vec<f64>]) -> Vec<f64> {
        let mut sum: Vec<f64> = gradients[0].iter().map(|g| self.weights[0] * g).collect();
        for (i, l) in self.updated(values).iter().enumerate() {
            for (sum, slope) in sum.iter_mut().zip(&gradients[1 + i]) {
                *sum += l * self.weights[1 + i] * slope;
            }
        }
        sum
    }
}

struct Driver<'p, 'a> {
    run: Run<'p, 'a>,
    lagrangian: Lagrangian,
    memory: Memory,
    /// The stationarity to which the Lagrangian is minimised before the next update of its multipliers.
    accuracy: f64,
    /// The largest violation or complementarity at the last update of the multipliers, of the scaled constraints.
    infeasibility: f64,
}

impl Driver<'_, '_> {
    fn iterate(&mut self) -> Result<Status, OptimiserError> {
        self.run.evaluate()?;
        self.begin();
        let mut moved = true;
        loop {
            let updated = self.lagrangian.updated(&self.run.values);
            let weights = &self.lagrangian.weights;
            self.run.multipliers = (updated.iter().zip(&weights[1..]))
                .map(|(l, weight)| l * weight / weights[0])
                .collect();
            let residuals = self.run.residuals();
            let stop = &self.run.stop;
            let feasible = residuals.violation <= stop.feasibility;
            let stationary = residuals.stationarity <= stop.kkt;
            if feasible && stationary && residuals.complementarity <= stop.kkt {
                return Ok(self.run.optimal());
            }
            if self.run.is_infeasible() {
                return Ok(Status::Infeasible);
            }
            if self.run.iterations == stop.iterations {
                return Ok(Status::IterationLimit);
            }
            self.run.iterations += 1;
            let ready = residuals.stationarity <= self.accuracy;
            if moved && !ready {
                moved = self.descend()?;
                continue;
            }
            let exhausted = !moved && self.accuracy <= stop.kkt;
            if feasible && exhausted {
                return Ok(Status::SmallStep);
            }
            if !feasible && self.lagrangian.penalty > LARGEST {
                return Ok(Status::Infeasible);
            }
            self.update_multipliers(updated);
            moved = true;
        }
    }

    /// Chooses the weights of the functions and the first penalty.
    fn begin(&mut self) {
        let run = &self.run;
        let weight = |function: usize| 1.0 / run.slope(function).max(1.0);
        let lagrangian = Lagrangian {
            equalities: run.problem.equalities,
            weights: (0..run.values.len()).map(weight).collect(),
            multipliers: vec![0.0; run.values.len() - 1],
            penalty: 1.0,
        };
        // With the penalty 1 and multipliers 0, these are the violations.
        let violations = lagrangian.updated(&run.values);
        let squares: f64 = violations.iter().map(|v| v * v).sum();
        let objective = (lagrangian.weights[0] * run.values[0]).abs();
        let penalty = match squares {
            // A start that satisfies the constraints should not leave them far behind.
            0.0 => FEASIBLE,
            squares => (2.0 * objective.max(1.0) / squares).clamp(1e-6, 10.0),
        };
        self.lagrangian = Lagrangian {
            penalty,
            ..lagrangian
        };
    }

    fn update_multipliers(&mut self, updated: Vec<f64>) {
        let lagrangian = &mut self.lagrangian;
        let changes = updated.iter().zip(&lagrangian.multipliers);
        let infeasibility = changes
            .map(|(new, old)| (new - old).abs() / lagrangian.penalty)
            .fold(0.0, f64::max);
        lagrangian.multipliers = updated.iter().map(|l| l.clamp(-BOUND, BOUND)).collect();
        if infeasibility > SHARE * self.infeasibility {
            lagrangian.penalty *= GROWTH;
        }
        self.infeasibility = infeasibility;
        self.accuracy = (0.1 * self.accuracy).max(0.5 * self.run.stop.kkt);
        self.memory.clear();
    }

    /// Makes a quasi-Newton step. Returns false if no step decreases the Lagrangian.
    fn descend(&mut self) -> Result<bool, OptimiserError> {
        let Driver {
            run,
            lagrangian,
            memory,
            ..
        } = self;
        let gradient = lagrangian.gradient(&run.values, &run.gradients);
        let start = lagrangian.value(&run.values);
        if !start.is_finite() || !gradient.iter().all(|slope| slope.is_finite()) {
            return Err(OptimiserError::Overflow);
        }
        let first = (0..run.point.len()).map(|j| 0.1 * run.length(j)).collect();
        let mut reached = Vec::new();
        let problem = &mut *run.problem;
        let (lower, upper) = (problem.lower.clone(), problem.upper.clone());
        let bounds = Bounds {
            lower: &lower,
            upper: &upper,
            first,
        };
        let value = |trial: &[f64]| match problem.values(trial) {
            Ok(values) => {
                reached = values;
                Ok(Some(lagrangian.value(&reached)).filter(|value| value.is_finite()))
            }
            Err(OptimiserError::NotFinite { .. }) => Ok(None),
            Err(error) => Err(error),
        };
        let Some(point) = memory.search(&run.point, (start, &gradient), &bounds, value)? else {
            return Ok(false);
        };
        let before = run.point.clone();
        run.advance(point, reached)?;
        let after = lagrangian.gradient(&run.values, &run.gradients);
        let difference =
            |new: &[f64], old: &[f64]| new.iter().zip(old).map(|(n, o)| n - o).collect();
        memory.add(
            difference(&run.point, &before),
            difference(&after, &gradient),
        );
        Ok(true)
    }
}
