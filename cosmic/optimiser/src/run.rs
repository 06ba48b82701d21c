//! What all drivers share: the stopping rule, the result, and the point that a run has reached.

use crate::error::{OptimiserError, require};
use crate::problem::Problem;

/// When a run ends.
///
/// Let `g_ij` be the derivative of function `i` by variable `j`, multiplied by the range of the variable (for a variable
/// with an infinite bound, by `max(1, |x_j|)`), and let `l_i` be the multipliers, with `l_0 = 1`. The *scale* of the
/// objective is the largest `|g_0j|`, but at least a tenth of the largest one at the start. The *KKT residual* is the larger of
/// - stationarity: the largest `|sum_i l_i g_ij|`, divided by the scale. For a variable near a bound, it is the distance
///   to the bound (divided by the range) if that is smaller and the bound prevents the descent;
/// - complementarity: the largest `|l_i f_i|` of an inequality, divided by the scale.
///
/// The residual has no units: it does not change if the objective or a variable is measured in other units.
#[derive(Debug, Clone, PartialEq)]
pub struct Stop {
    /// The largest KKT residual of a converged run. 1e-6 by default.
    pub kkt: f64,
    /// The largest violation of a constraint in the units of the constraint: `f_i` for an inequality, `|f_i|` for an
    /// equality. 1e-6 by default.
    pub feasibility: f64,
    /// A run also ends if no variable changes by more than this part of its range (for a variable with an infinite
    /// bound, of `max(1, |x_j|)`). 1e-12 by default.
    pub step: f64,
    /// The largest number of iterations. 1000 by default.
    pub iterations: usize,
}

impl Default for Stop {
    fn default() -> Self {
        Stop {
            kkt: 1e-6,
            feasibility: 1e-6,
            step: 1e-12,
            iterations: 1000,
        }
    }
}

/// A violation counts as stationary if a move over the range of a variable changes it, to first order, by no more than
/// this part.
const FLAT: f64 = 1e-4;
/// The residuals of a point that is close enough to a solution to decide whether it is the right one.
pub(crate) const BALANCED: f64 = 1e-3;

/// How a run ended.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Status {
    /// The point satisfies the optimality conditions and all constraints to the tolerances of [`Stop`]. If the problem
    /// is not convex, the point may be a local minimum or a saddle point.
    Converged,
    /// The point satisfies all constraints, but not the optimality conditions, and steps are smaller than
    /// [`Stop::step`]. The tolerance is below the rounding error of the functions, derivatives are wrong, the point is a
    /// kink of a function, or the solution has no multipliers, as for the constraint `x^2 <= 0`.
    SmallStep,
    /// The run has done [`Stop::iterations`] iterations.
    IterationLimit,
    /// A constraint is violated, and to first order no small change of the variables reduces the violation. Either no
    /// point satisfies all constraints, or the run reached a local minimum of the violation: then another start helps.
    Infeasible,
    /// The point satisfies the optimality conditions, but its objective is larger than that of the start, which satisfied
    /// all constraints. Derivatives have the wrong sign, or the run has ended in a worse local minimum.
    WorseThanStart,
    /// A function or a number computed from functions is not finite; the error says which one. The result is the last
    /// point where all functions are finite, or the start.
    Failed(OptimiserError),
}

/// The result of a run.
#[must_use = "the status says whether the run converged"]
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// How the run ended.
    pub status: Status,
    /// The last point, within the bounds.
    pub point: Vec<f64>,
    /// The value of the objective at the point. NaN if the functions are not finite at the start.
    pub objective: f64,
    /// The values of the constraints at the point. Empty if the functions are not finite at the start.
    pub constraints: Vec<f64>,
    /// The multiplier of each constraint: at least 0 for inequalities.
    pub multipliers: Vec<f64>,
    /// The KKT residual: see [`Stop`].
    pub kkt: f64,
    /// The largest violation of a constraint, or 0.
    pub violation: f64,
    /// The number of iterations.
    pub iterations: usize,
    /// The number of points where the values were computed.
    pub value_evaluations: usize,
    /// The number of points where the gradients were computed.
    pub gradient_evaluations: usize,
}

/// The residuals of the optimality conditions.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Residuals {
    pub(crate) stationarity: f64,
    pub(crate) complementarity: f64,
    pub(crate) violation: f64,
}

/// A run of a driver: the problem, and the point that was reached.
pub(crate) struct Run<'p, 'a> {
    pub(crate) problem: &'p mut Problem<'a>,
    pub(crate) stop: Stop,
    pub(crate) point: Vec<f64>,
    pub(crate) values: Vec<f64>,
    pub(crate) gradients: Vec<Vec<f64>>,
    pub(crate) multipliers: Vec<f64>,
    pub(crate) iterations: usize,
    /// The size of the step to the point, relative to the ranges of the variables.
    pub(crate) step: f64,
    /// The largest scaled derivative of the objective at the start, or at the first point where it is not 0.
    first_slope: f64,
    /// The objective at the start if the start satisfies all constraints.
    first_objective: Option<f64>,
}

impl<'p, 'a> Run<'p, 'a> {
    /// Begins a run. Evaluates nothing yet. Refuses bounds, a start and tolerances that do not make sense.
    pub(crate) fn new(
        problem: &'p mut Problem<'a>,
        start: &[f64],
        stop: &Stop,
    ) -> Result<Self, OptimiserError> {
        problem.begin(start)?;
        for (name, value, least) in [
            ("kkt", stop.kkt, f64::MIN_POSITIVE),
            ("feasibility", stop.feasibility, 0.0),
            ("step", stop.step, 0.0),
        ] {
            require(value >= least && value.is_finite(), || {
                let allowed = if least > 0.0 { "above 0" } else { "at least 0" };
                format!("the tolerance `{name}` is {value}; it must be finite and {allowed}")
            })?;
        }
        Ok(Run {
            problem,
            stop: stop.clone(),
            point: start.to_vec(),
            values: Vec::new(),
            gradients: Vec::new(),
            multipliers: Vec::new(),
            iterations: 0,
            step: f64::INFINITY,
            first_slope: 0.0,
            first_objective: None,
        })
    }

    /// Evaluates the functions at the start.
    pub(crate) fn evaluate(&mut self) -> Result<(), OptimiserError> {
        self.values = self.problem.values(&self.point)?;
        self.gradients = self.problem.gradients(&self.point)?;
        self.multipliers = vec![0.0; self.values.len() - 1];
        let is_feasible = self.violation() <= self.stop.feasibility;
        self.first_objective = is_feasible.then_some(self.values[0]);
        Ok(())
    }

    /// The status of a point that satisfies the optimality conditions and all constraints.
    pub(crate) fn optimal(&mut self) -> Status {
        // To first order, the tolerances of a converged run allow this much.
        let multipliers: f64 = self.multipliers.iter().map(|l| l.abs()).sum();
        let noise = self.stop.kkt * self.objective_scale() + self.stop.feasibility * multipliers;
        let rounding = 1e-12 * self.values[0].abs();
        match self.first_objective {
            Some(first) if self.values[0] > first + noise + rounding => Status::WorseThanStart,
            _ => Status::Converged,
        }
    }

    /// Moves to a point whose values are known. If its gradients are not finite, the run stays where it is.
    pub(crate) fn advance(
        &mut self,
        point: Vec<f64>,
        values: Vec<f64>,
    ) -> Result<(), OptimiserError> {
        self.gradients = self.problem.gradients(&point)?;
        self.step = (0..point.len())
            .map(|j| (point[j] - self.point[j]).abs() / self.length(j))
            .fold(0.0, f64::max);
        (self.point, self.values) = (point, values);
        Ok(())
    }

    /// The length in which changes of a variable are measured: its range, which is 1 for a fixed variable.
    pub(crate) fn length(&self, j: usize) -> f64 {
        let range = self.problem.upper[j] - self.problem.lower[j];
        match range {
            0.0 => 1.0,
            range if range.is_finite() => range,
            _ => self.point[j].abs().max(1.0),
        }
    }

    /// The largest scaled derivative of a function by a variable that is not fixed.
    pub(crate) fn slope(&self, function: usize) -> f64 {
        let gradient = self.gradients[function].iter().enumerate();
        gradient
            .filter(|&(j, _)| self.problem.lower[j] < self.problem.upper[j])
            .map(|(j, slope)| slope.abs() * self.length(j))
            .fold(0.0, f64::max)
    }

    /// The scale of the objective at the point: see [`Stop`].
    pub(crate) fn objective_scale(&mut self) -> f64 {
        let slope = self.slope(0);
        if self.first_slope == 0.0 {
            self.first_slope = slope;
        }
        slope.max(0.1 * self.first_slope)
    }

    /// The residuals of the optimality conditions.
    pub(crate) fn residuals(&mut self) -> Residuals {
        let scale = match self.objective_scale() {
            0.0 => self.steepest_term(),
            scale => scale,
        };
        let products =
            (self.multipliers.iter().zip(&self.values[1..])).skip(self.problem.equalities);
        let product = products.map(|(l, f)| (l * f).abs()).fold(0.0, f64::max);
        Residuals {
            stationarity: self.stationarity(1.0, scale),
            complementarity: if scale > 0.0 {
                product / scale
            } else {
                product
            },
            violation: self.violation(),
        }
    }

    /// The largest scaled derivative of a constraint times its multiplier.
    fn steepest_term(&self) -> f64 {
        let terms = self.multipliers.iter().enumerate();
        terms
            .map(|(i, l)| l.abs() * self.slope(1 + i))
            .fold(0.0, f64::max)
    }

    /// The largest scaled derivative of the Lagrangian that the bounds do not stop, divided by `scale`. `objective` is
    /// the weight of the objective.
    fn stationarity(&self, objective: f64, scale: f64) -> f64 {
        let component = |j: usize| {
            let weighted = self.multipliers.iter().zip(&self.gradients[1..]);
            let sum: f64 = weighted.map(|(l, gradient)| l * gradient[j]).sum();
            let slope = (objective * self.gradients[0][j] + sum) * self.length(j);
            if slope == 0.0 {
                return 0.0;
            }
            let room = match slope > 0.0 {
                true => self.point[j] - self.problem.lower[j],
                false => self.problem.upper[j] - self.point[j],
            };
            (slope.abs() / scale).min(room / self.length(j))
        };
        (0..self.point.len()).map(component).fold(0.0, f64::max)
    }

    /// The violation of constraint `i`, at least 0.
    fn violation_of(&self, i: usize) -> f64 {
        match i < self.problem.equalities {
            true => self.values[1 + i].abs(),
            false => self.values[1 + i].max(0.0),
        }
    }

    pub(crate) fn violation(&self) -> f64 {
        (0..self.values.len().saturating_sub(1))
            .map(|i| self.violation_of(i))
            .fold(0.0, f64::max)
    }

    /// True if the Lagrangian is about stationary, relative to its largest term, and constraints with a multiplier hold
    /// with equality or are violated.
    pub(crate) fn is_balanced(&mut self) -> bool {
        let scale = self.objective_scale().max(self.steepest_term());
        self.slack() <= self.stop.kkt * scale && self.stationarity(1.0, scale) <= BALANCED
    }

    /// The largest product of the slack of an inequality that holds with its multiplier.
    fn slack(&self) -> f64 {
        let products =
            (self.multipliers.iter().zip(&self.values[1..])).skip(self.problem.equalities);
        products.map(|(l, f)| -l * f).fold(0.0, f64::max)
    }

    /// True if the point is a stationary point of the violation: without the objective, the multipliers satisfy the
    /// optimality conditions, or all slopes are small compared with the violations.
    pub(crate) fn is_infeasible(&self) -> bool {
        let excess = |(i, l): (usize, &f64)| l.abs() * self.violation_of(i);
        let excess: f64 = self.multipliers.iter().enumerate().map(excess).sum();
        let scale = self.steepest_term().max(excess * FLAT / self.stop.kkt);
        excess > 0.0
            && self.violation() > self.stop.feasibility
            && self.slack() <= self.stop.kkt * scale
            && self.stationarity(0.0, scale) <= self.stop.kkt
    }

    /// The result of the run.
    ///
    /// # Errors
    /// Returns the error that ended the run if an input was invalid.
    pub(crate) fn finish(
        mut self,
        end: Result<Status, OptimiserError>,
    ) -> Result<Solution, OptimiserError> {
        let status = match end {
            Ok(status) => status,
            Err(error @ OptimiserError::Input(_)) => return Err(error),
            Err(error) => Status::Failed(error),
        };
        let kkt = match self.gradients.is_empty() {
            true => f64::NAN,
            false => {
                let residuals = self.residuals();
                residuals.stationarity.max(residuals.complementarity)
            }
        };
        Ok(Solution {
            status,
            objective: self.values.first().copied().unwrap_or(f64::NAN),
            constraints: self.values.get(1..).unwrap_or_default().to_vec(),
            violation: self.violation(),
            kkt,
            point: self.point,
            multipliers: self.multipliers,
            iterations: self.iterations,
            value_evaluations: self.problem.evaluations[0],
            gradient_evaluations: self.problem.evaluations[1],
        })
    }
}
