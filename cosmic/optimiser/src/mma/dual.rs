//! The solution of the subproblem through its dual.
//!
//! The dual is a concave function of the multipliers. Its gradient has an entry for each constraint: the value of the
//! constraint's model at the step that minimises the Lagrangian, minus the elastic extension. The gradient is
//! continuous, but its derivative jumps where a variable reaches the bounds of its step (its box) or a multiplier
//! passes the elastic cost `c`. For a few constraints, an active-set Newton method with a line search along each
//! direction reaches rounding error.
//!
//! Degenerate cases are common. If all variables are at the edges of their boxes, the dual is flat in all directions up
//! to the elastic cost. If a volume has nearly equal lower and upper bounds, the dual is nearly flat in one direction.
//! Two things make the method safe in these cases. First, each multiplier has a known upper bound: `c + d y` for the
//! largest `y` that the box can require. Second, the Newton matrix is damped by the gradient divided by that bound, so
//! a step in a flat direction leads at most to the bound. The damping vanishes with the gradient and does not disturb
//! the last Newton steps.

use super::bracket::Bracket;
use super::cholesky::solve_positive;
use super::subproblem::{Elastic, Subproblem};

/// The search stops after this number of Newton steps and then reports its residual. Most random problems take fewer
/// than 15 steps; the hardest of 400 000 took 80.
const MAX_STEPS: usize = 100;
/// Once in this number of Newton steps, each multiplier is moved on its own, with the others fixed. This helps where
/// the dual is piecewise linear: there, Newton's direction can zigzag in one multiplier while another one is far from
/// its solution. The search stops if neither the dual nor the residual has improved since the last time, because then
/// rounding prevents further progress.
const PATIENCE: usize = 10;
/// The largest number of evaluations in one line search.
pub(super) const MAX_TRIALS: usize = 100;
/// A line search ends when it has reduced the directional derivative to this share of its initial value. A smaller
/// share would cost more evaluations, a larger share more Newton steps.
const SLACK: f64 = 0.3;
/// The assumed rounding error of a constraint, in ulps of the sum of the absolute values of its terms.
const ULPS: f64 = 8.0;

/// The solution of a subproblem.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Solution {
    pub(super) multipliers: Vec<f64>,
    pub(super) newton_steps: usize,
    pub(super) residual: f64,
}

/// Maximises the dual, starting from the multipliers `guess` if their number is right, otherwise from 0. Afterwards,
/// `model.steps` are the steps for the returned multipliers. Returns `None` if numbers overflow.
pub(super) fn maximise(
    model: &mut Subproblem,
    elastic: Elastic,
    guess: &[f64],
) -> Option<Solution> {
    let mut search = Ascent::new(model, elastic);
    if guess.len() == search.multipliers.len() {
        for i in 0..guess.len() {
            search.multipliers[i] = guess[i].clamp(0.0, search.ceilings[i]);
        }
    }
    search.evaluate();
    let mut newton_steps = 0;
    let mut before = (search.value, search.residual());
    while !search.converged() && newton_steps < MAX_STEPS {
        search.find_direction();
        if !finite(&search.matrix) || !search.slope().is_finite() {
            return None;
        }
        search.advance();
        newton_steps += 1;
        if newton_steps.is_multiple_of(PATIENCE) {
            search.ascend_each();
            let (value, residual) = (search.value, search.residual());
            if value <= before.0 + search.value_noise && residual > 0.5 * before.1 {
                break;
            }
            before = (value, residual);
        }
    }
    if !finite(&search.gradient) || !finite(&search.model.steps) {
        return None;
    }
    Some(Solution {
        newton_steps,
        residual: search.residual(),
        multipliers: search.multipliers,
    })
}

fn finite(numbers: &[f64]) -> bool {
    numbers.iter().all(|number| number.is_finite())
}

/// The largest possible step along a direction. Also the multiplier that reaches its bound at the end of this step, if
/// one does.
struct Limit {
    length: f64,
    hit: Option<usize>,
}

struct Ascent<'a> {
    model: &'a mut Subproblem,
    elastic: Elastic,
    /// Upper bounds on the multipliers. A solution stays below them. Only a constraint that cannot be active has the
    /// bound 0, which its multiplier reaches.
    ceilings: Vec<f64>,
    /// The rounding error of each component of the gradient.
    noise: Vec<f64>,
    multipliers: Vec<f64>,
    value: f64,
    value_noise: f64,
    gradient: Vec<f64>,
    direction: Vec<f64>,
    free: Vec<usize>,
    matrix: Vec<f64>,
}

impl<'a> Ascent<'a> {
    fn new(model: &'a mut Subproblem, elastic: Elastic) -> Self {
        let count = model.values.len();
        let ceiling = |peak: f64| {
            // A tenth is added to `peak`, so that the gradient is negative at the bound.
            let bound = elastic.linear + elastic.quadratic * 1.1 * peak;
            if peak > 0.0 { bound } else { 0.0 }
        };
        Ascent {
            ceilings: (0..count).map(|i| ceiling(model.peaks[i])).collect(),
            noise: vec![0.0; count],
            multipliers: vec![0.0; count],
            value: 0.0,
            value_noise: 0.0,
            gradient: vec![0.0; count],
            direction: vec![0.0; count],
            free: Vec::with_capacity(count),
            matrix: Vec::with_capacity(count * count),
            model,
            elastic,
        }
    }

    /// Computes the value and the gradient of the dual at the multipliers, and their rounding errors.
    fn evaluate(&mut self) {
        self.value = self.model.minimise(&self.multipliers, &mut self.gradient);
        self.value_noise = ULPS * f64::EPSILON * self.value.abs();
        for (i, &multiplier) in self.multipliers.iter().enumerate() {
            let extension = self.elastic.extension(multiplier);
            self.gradient[i] -= extension;
            self.value -= 0.5 * self.elastic.quadratic * extension * extension;
            // Above the elastic cost, an ulp of the multiplier changes the extension by that ulp divided by d.
            let elastic_size = if extension > 0.0 {
                multiplier / self.elastic.quadratic
            } else {
                0.0
            };
            self.noise[i] = ULPS * f64::EPSILON * (self.model.sizes[i] + elastic_size);
            self.value_noise += multiplier * self.noise[i];
        }
    }

    /// The violation of the optimality condition of constraint `i`.
    fn violation(&self, i: usize) -> f64 {
        if self.multipliers[i] > 0.0 {
            self.gradient[i].abs()
        } else {
            self.gradient[i].max(0.0)
        }
    }

    /// The largest violation, in the units of the constraints.
    fn residual(&self) -> f64 {
        (0..self.gradient.len())
            .map(|i| self.violation(i))
            .fold(0.0, f64::max)
    }

    /// True if all violations are within rounding error. Also true if one is NaN, which ends the search.
    fn converged(&self) -> bool {
        !(0..self.gradient.len()).any(|i| self.violation(i) > self.noise[i])
    }

    /// Computes Newton's direction. Along it, only free multipliers change. A multiplier is free if it would not cross
    /// a bound at once.
    fn find_direction(&mut self) {
        let free = (0..self.gradient.len()).filter(|&i| {
            self.multipliers[i] > 0.0 || self.gradient[i] > 0.0 && self.ceilings[i] > 0.0
        });
        self.free.clear();
        self.free.extend(free);
        loop {
            self.solve_newton();
            let (multipliers, ceilings) = (&self.multipliers, &self.ceilings);
            let direction = &self.direction;
            let count = self.free.len();
            // A multiplier that would cross its bound is excluded, and the system is solved again for the others. The
            // direction of the others is still uphill.
            self.free.retain(|&i| {
                let (at, by) = (multipliers[i], direction[i]);
                !(at == 0.0 && by < 0.0 || at == ceilings[i] && by > 0.0)
            });
            if self.free.len() == count {
                return;
            }
        }
    }

    /// Maximises the dual along each multiplier, one after the other.
    fn ascend_each(&mut self) {
        for i in 0..self.gradient.len() {
            if self.violation(i) > self.noise[i] {
                self.free.clear();
                self.free.push(i);
                self.direction.fill(0.0);
                self.direction[i] = self.gradient[i].signum() * self.ceilings[i];
                self.advance();
            }
        }
    }

    /// Computes the direction over the free multipliers. It solves the damped Newton system, which consists of
    /// curvature, damping and gradient.
    fn solve_newton(&mut self) {
        self.model.dual_curvature(&self.free, &mut self.matrix);
        let size = self.free.len();
        let mut solution: Vec<f64> = self.free.iter().map(|&i| self.gradient[i]).collect();
        for (row, &i) in self.free.iter().enumerate() {
            let diagonal = &mut self.matrix[row * size + row];
            if self.multipliers[i] > self.elastic.linear {
                *diagonal += self.elastic.quadratic.recip();
            }
            *diagonal += self.gradient[i].abs() / self.ceilings[i];
        }
        solve_positive(&mut self.matrix, &mut solution);
        self.direction.fill(0.0);
        for (&i, &component) in self.free.iter().zip(&solution) {
            self.direction[i] = component;
        }
    }

    /// The largest step along the direction.
    fn limit(&self) -> Limit {
        let mut limit = Limit {
            length: f64::INFINITY,
            hit: None,
        };
        for &i in &self.free {
            let (at, move_by) = (self.multipliers[i], self.direction[i]);
            let room = if move_by < 0.0 {
                at
            } else {
                self.ceilings[i] - at
            };
            let length = room / move_by.abs();
            if length < limit.length {
                (limit.length, limit.hit) = (length, Some(i));
            }
        }
        limit
    }

    /// Moves to the point at `length` along the direction from `start`, and returns the directional derivative there.
    fn slope_at(&mut self, start: &[f64], length: f64, limit: &Limit) -> f64 {
        for (i, &from) in start.iter().enumerate() {
            let to = from + length * self.direction[i];
            self.multipliers[i] = to.clamp(0.0, self.ceilings[i]);
        }
        if let (Some(hit), true) = (limit.hit, length == limit.length) {
            // Puts the multiplier exactly on its bound, without a rounding error.
            let falls = self.direction[hit] < 0.0;
            self.multipliers[hit] = if falls { 0.0 } else { self.ceilings[hit] };
        }
        self.evaluate();
        self.slope()
    }

    /// The directional derivative of the dual at the current multipliers.
    fn slope(&self) -> f64 {
        (self.gradient.iter().zip(&self.direction))
            .map(|(g, p)| g * p)
            .sum()
    }

    /// The lengths along the direction at which a multiplier passes the elastic cost. At these lengths, the derivative
    /// of the slope jumps by orders of magnitude.
    fn kinks(&self) -> Vec<f64> {
        (self.free.iter())
            .map(|&i| (self.elastic.linear - self.multipliers[i]) / self.direction[i])
            .filter(|length| length.is_finite())
            .collect()
    }

    /// The line search: moves along the direction to where the directional derivative, which decreases, is nearly zero.
    fn advance(&mut self) {
        let start = self.multipliers.clone();
        let limit = self.limit();
        let (first_value, first_slope) = (self.value, self.slope());
        let noise: f64 = (self.noise.iter().zip(&self.direction))
            .map(|(e, p)| e * p.abs())
            .sum();
        let enough = SLACK * first_slope + noise;
        let mut kinks = self.kinks();
        let mut bracket = Bracket::starting_with(first_slope);
        let mut length = limit.length.min(1.0);
        for _ in 0..MAX_TRIALS {
            let slope = self.slope_at(&start, length, &limit);
            // Beyond the maximum along the line, the value may be lower than at the start.
            let gained = slope >= 0.0 || self.value + self.value_noise >= first_value;
            let at_limit = slope > 0.0 && length == limit.length;
            if at_limit || slope.abs() <= enough && gained {
                return;
            }
            bracket.narrow(length, slope);
            length = bracket.next_trial(&mut kinks).min(limit.length);
        }
    }
}
