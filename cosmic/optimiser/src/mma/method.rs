//! The method of moving asymptotes: its state and its updates.

use super::dual;
use super::settings::{MmaSettings, check_settings};
use super::subproblem::{Elastic, Room, Subproblem};
use crate::error::{OptimiserError, check, check_finite, check_length, require};

/// The state of MMA between updates.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct MmaState {
    /// The number of updates so far.
    pub updates: u64,
    /// The point that the last update started from.
    pub previous: Vec<f64>,
    /// The point that the update before the last one started from.
    pub before_previous: Vec<f64>,
    /// The lower asymptotes of the last update.
    pub low: Vec<f64>,
    /// The upper asymptotes of the last update.
    pub upp: Vec<f64>,
    /// The multipliers of the last update. The search for the next multipliers starts there. Empty before the first
    /// update.
    pub multipliers: Vec<f64>,
}

/// The lower and the upper asymptote of each variable.
#[derive(Debug, Clone)]
pub(super) struct Asymptotes {
    low: Vec<f64>,
    upp: Vec<f64>,
}

impl MmaState {
    /// Records an update that started from `point`.
    pub(super) fn advance(&mut self, point: &[f64], asymptotes: Asymptotes, multipliers: &[f64]) {
        self.updates += 1;
        self.before_previous = std::mem::replace(&mut self.previous, point.to_vec());
        (self.low, self.upp) = (asymptotes.low, asymptotes.upp);
        self.multipliers = multipliers.to_vec();
    }
}

/// An optimisation problem at one point: the values and the first derivatives of its functions.
#[derive(Debug, Clone, Copy)]
pub struct Linearisation<'a> {
    /// The point: the values of the variables.
    pub point: &'a [f64],
    /// The derivative of the objective with respect to each variable.
    pub objective_gradient: &'a [f64],
    /// The values of the constraints `f_i`, which should be at most 0.
    pub constraints: &'a [f64],
    /// For each constraint, its derivative with respect to each variable.
    pub jacobian: &'a [Vec<f64>],
}

/// The result of an update.
#[derive(Debug, Clone, PartialEq)]
pub struct Update {
    /// The new point, within the bounds.
    pub point: Vec<f64>,
    /// The multipliers of the constraints. If constraints are degenerate, the multipliers are not unique; `point` is
    /// always unique.
    pub multipliers: Vec<f64>,
    /// How the subproblem was solved.
    pub diagnostics: MmaDiagnostics,
}

/// A report on how a subproblem was solved.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MmaDiagnostics {
    /// The number of Newton steps that maximised the dual.
    pub newton_steps: usize,
    /// The largest violation of the optimality conditions of the subproblem, in the units of the constraints.
    pub residual: f64,
    /// The elastic variable of each constraint: by how much the subproblem had to violate the constraint.
    pub elastic: Vec<f64>,
}

/// The method of moving asymptotes (MMA) for variables with given bounds.
#[derive(Debug, Clone)]
pub struct Mma {
    settings: MmaSettings,
    lower: Vec<f64>,
    upper: Vec<f64>,
    /// The variables whose lower and upper bounds differ. The others never move.
    moving: Vec<usize>,
    pub(super) subproblem: Subproblem,
}

impl Mma {
    /// Prepares the method for variables with the given bounds. A variable whose lower and upper bounds are equal stays
    /// fixed.
    ///
    /// # Errors
    /// If there are not as many lower bounds as upper bounds, if a bound is not finite, if a lower bound is above its
    /// upper bound, or if a setting is outside its range.
    pub fn new(
        settings: MmaSettings,
        lower: &[f64],
        upper: &[f64],
    ) -> Result<Self, OptimiserError> {
        check_settings(&settings)?;
        check_finite("lower bounds", lower)?;
        check("upper bounds", upper, lower.len())?;
        for (j, (lower, upper)) in lower.iter().zip(upper).enumerate() {
            require(lower <= upper, || {
                format!("variable {j}: the lower bound {lower} is above the upper bound {upper}")
            })?;
        }
        Ok(Mma {
            settings,
            moving: (0..lower.len()).filter(|&j| lower[j] < upper[j]).collect(),
            lower: lower.to_vec(),
            upper: upper.to_vec(),
            subproblem: Subproblem::default(),
        })
    }

    pub(super) fn settings(&self) -> &MmaSettings {
        &self.settings
    }

    /// The state before the first update from `start`.
    #[must_use]
    pub fn init(&self, start: &[f64]) -> MmaState {
        MmaState {
            updates: 0,
            previous: start.to_vec(),
            before_previous: start.to_vec(),
            low: start.to_vec(),
            upp: start.to_vec(),
            multipliers: Vec::new(),
        }
    }

    /// Does one update, from the values and derivatives at a point.
    ///
    /// # Errors
    /// If a slice has the wrong length, an entry is not finite, the point is outside the bounds, or derivatives are so
    /// large that the subproblem overflows. In these cases, the state does not change.
    pub fn update(
        &mut self,
        state: &mut MmaState,
        at: &Linearisation<'_>,
    ) -> Result<Update, OptimiserError> {
        self.check_input(state, at)?;
        let asymptotes = self.asymptotes(state, at.point);
        let curvatures = vec![self.settings.raa0; 1 + at.constraints.len()];
        let update = self.solve(at, &asymptotes, &curvatures, &state.multipliers)?;
        state.advance(at.point, asymptotes, &update.multipliers);
        Ok(update)
    }

    /// Solves the subproblem at a point. `curvatures` has an entry for the objective and for each constraint. The search
    /// for the multipliers starts at `guess`. Unlike [`Mma::update`], this does not check the input.
    pub(super) fn solve(
        &mut self,
        at: &Linearisation<'_>,
        asymptotes: &Asymptotes,
        curvatures: &[f64],
        guess: &[f64],
    ) -> Result<Update, OptimiserError> {
        self.build(at, asymptotes, curvatures);
        let elastic = Elastic {
            linear: self.settings.c,
            quadratic: self.settings.d,
        };
        let solution =
            dual::maximise(&mut self.subproblem, elastic, guess).ok_or(OptimiserError::Overflow)?;
        let mut point = at.point.to_vec();
        for (&j, step) in self.moving.iter().zip(&self.subproblem.steps) {
            // The clamp only removes a rounding error.
            point[j] = (point[j] + step).clamp(self.lower[j], self.upper[j]);
        }
        let extension = |&multiplier: &f64| elastic.extension(multiplier);
        Ok(Update {
            point,
            diagnostics: MmaDiagnostics {
                newton_steps: solution.newton_steps,
                residual: solution.residual,
                elastic: solution.multipliers.iter().map(extension).collect(),
            },
            multipliers: solution.multipliers,
        })
    }

    fn check_input(&self, state: &MmaState, at: &Linearisation<'_>) -> Result<(), OptimiserError> {
        let count = self.lower.len();
        for (what, slice) in [
            ("point", at.point),
            ("objective gradient", at.objective_gradient),
            ("state: previous point", &state.previous),
            ("state: point before the previous", &state.before_previous),
            ("state: lower asymptotes", &state.low),
            ("state: upper asymptotes", &state.upp),
        ] {
            check(what, slice, count)?;
        }
        check_finite("state: multipliers", &state.multipliers)?;
        check_finite("constraints", at.constraints)?;
        check_length("rows of the jacobian", at.jacobian, at.constraints.len())?;
        for row in at.jacobian {
            check("row of the jacobian", row, count)?;
        }
        for (j, value) in at.point.iter().enumerate() {
            let (lower, upper) = (&self.lower[j], &self.upper[j]);
            require(lower <= value && value <= upper, || {
                format!("variable {j} is {value}; it must be within its bounds {lower} to {upper}")
            })?;
        }
        Ok(())
    }

    /// The lower and upper asymptotes for an update from `point` (Svanberg 1987, section 4). In the first two updates
    /// their distance from the point is fixed. Later it grows for variables that keep their direction, and shrinks for
    /// variables that oscillate.
    pub(super) fn asymptotes(&self, state: &MmaState, point: &[f64]) -> Asymptotes {
        let p = &self.settings;
        let (mut low, mut upp) = (point.to_vec(), point.to_vec());
        for &j in &self.moving {
            let (x, range) = (point[j], self.upper[j] - self.lower[j]);
            if state.updates < 2 {
                low[j] = x - p.asyinit * range;
                upp[j] = x + p.asyinit * range;
                continue;
            }
            let previous = state.previous[j];
            let trend = (x - previous) * (previous - state.before_previous[j]);
            let factor = if trend > 0.0 {
                p.asyincr
            } else if trend < 0.0 {
                p.asydecr
            } else {
                1.0
            };
            let (nearest, farthest) = (p.asymin * range, p.asymax * range);
            low[j] = (x - factor * (previous - state.low[j])).clamp(x - farthest, x - nearest);
            upp[j] = (x + factor * (state.upp[j] - previous)).clamp(x + nearest, x + farthest);
        }
        Asymptotes { low, upp }
    }

    fn build(&mut self, at: &Linearisation<'_>, asymptotes: &Asymptotes, curvatures: &[f64]) {
        let Mma {
            settings,
            moving,
            lower,
            upper,
            subproblem,
        } = self;
        let Asymptotes { low, upp } = asymptotes;
        subproblem.reset(moving.iter().map(|&j| {
            let (x, range) = (at.point[j], upper[j] - lower[j]);
            let (to_low, to_upp) = (x - low[j], upp[j] - x);
            let stretch = 1.0 - settings.albefa;
            let reach = settings.move_limit * range;
            Room {
                to_upp,
                to_low,
                least: (lower[j] - x).max(-stretch * to_low).max(-reach),
                most: (upper[j] - x).min(stretch * to_upp).min(reach),
                range,
            }
        }));
        let gradient = moving.iter().map(|&j| at.objective_gradient[j]);
        subproblem.set_objective(gradient, curvatures[0]);
        for (i, (&value, row)) in at.constraints.iter().zip(at.jacobian).enumerate() {
            let gradient = moving.iter().map(|&j| row[j]);
            subproblem.add_constraint(value, gradient, curvatures[1 + i]);
        }
    }
}
