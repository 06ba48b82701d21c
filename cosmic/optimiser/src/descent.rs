//! A quasi-Newton step within bounds: limited-memory BFGS on the variables that the bounds leave free, with a line
//! search along the projected direction.
//!
//! D. P. Bertsekas, "Projected Newton methods for optimization problems with simple constraints", SIAM Journal on
//! Control and Optimization 20 (1982) 221-246, with the two-loop recursion of J. Nocedal, "Updating quasi-Newton
//! matrices with limited storage", Mathematics of Computation 35 (1980) 773-782.

use std::collections::VecDeque;

/// The number of pairs that approximate the inverse of the Hessian.
const PAIRS: usize = 10;
/// A step is accepted if it decreases the function by this part of what its slope promises.
const ENOUGH: f64 = 1e-4;
/// The largest number of trials in a line search.
const MAX_TRIALS: usize = 60;

/// The last steps, each with the change of the gradient along it.
#[derive(Debug, Default)]
pub(crate) struct Memory(VecDeque<(Vec<f64>, Vec<f64>)>);

/// The box in which a step stays, and the length of a first trial step in each variable.
pub(crate) struct Bounds<'b> {
    pub(crate) lower: &'b [f64],
    pub(crate) upper: &'b [f64],
    pub(crate) first: Vec<f64>,
}

impl Memory {
    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }

    /// Remembers a step and the change of the gradient along it.
    pub(crate) fn add(&mut self, step: Vec<f64>, change: Vec<f64>) {
        if self.0.len() == PAIRS {
            self.0.pop_front();
        }
        self.0.push_back((step, change));
    }

    /// Finds a lower point along a projected direction. `value` returns `None` where the function is not finite.
    /// Returns `None` if rounding prevents a decrease.
    pub(crate) fn search<E>(
        &mut self,
        point: &[f64],
        (start, gradient): (f64, &[f64]),
        bounds: &Bounds<'_>,
        mut value: impl FnMut(&[f64]) -> Result<Option<f64>, E>,
    ) -> Result<Option<Vec<f64>>, E> {
        let stopped = |j: usize| match gradient[j] > 0.0 {
            true => point[j] <= bounds.lower[j],
            false => point[j] >= bounds.upper[j],
        };
        let free: Vec<usize> = (0..point.len()).filter(|&j| !stopped(j)).collect();
        let direction = self.direction(gradient, &free);
        let lengths = (free.iter()).map(|&j| bounds.first[j] / direction[j].abs());
        let mut length = match self.0.is_empty() {
            true => lengths.fold(f64::INFINITY, f64::min),
            false => 1.0,
        };
        for _ in 0..MAX_TRIALS {
            let trial: Vec<f64> = (0..point.len())
                .map(|j| (point[j] + length * direction[j]).clamp(bounds.lower[j], bounds.upper[j]))
                .collect();
            let promised: f64 = (0..point.len())
                .map(|j| gradient[j] * (trial[j] - point[j]))
                .sum();
            if promised.is_nan() || trial == point {
                break;
            }
            let reached = value(&trial)?;
            if reached.is_some_and(|reached| reached <= start + ENOUGH * promised && promised < 0.0)
            {
                return Ok(Some(trial));
            }
            // The minimum of the parabola through both values with the slope at the start.
            let parabola = reached.map(|reached| -0.5 * promised / (reached - start - promised));
            length *= parabola.unwrap_or(0.1).clamp(0.1, 0.5);
        }
        Ok(None)
    }

    /// The direction of descent over the free variables. Forgets all pairs if they do not lead downhill.
    fn direction(&mut self, gradient: &[f64], free: &[usize]) -> Vec<f64> {
        let direction = self.two_loops(gradient, free);
        if dot(free, gradient, &direction) < 0.0 {
            return direction;
        }
        self.clear();
        self.two_loops(gradient, free)
    }

    /// Minus the product of the approximate inverse Hessian with the gradient, over the free variables. Pairs without
    /// positive curvature over these variables are left out.
    fn two_loops(&self, gradient: &[f64], free: &[usize]) -> Vec<f64> {
        let mut direction = vec![0.0; gradient.len()];
        for &j in free {
            direction[j] = -gradient[j];
        }
        let pairs: Vec<_> = (self.0.iter())
            .map(|(step, change)| (step, change, dot(free, step, change)))
            .filter(|(_, change, product)| *product > 1e-12 * dot(free, change, change))
            .collect();
        let mut factors = Vec::new();
        for (step, change, product) in pairs.iter().rev() {
            let factor = dot(free, step, &direction) / product;
            free.iter()
                .for_each(|&j| direction[j] -= factor * change[j]);
            factors.push(factor);
        }
        if let Some((_, change, product)) = pairs.last() {
            let scale = product / dot(free, change, change);
            free.iter().for_each(|&j| direction[j] *= scale);
        }
        for ((step, change, product), factor) in pairs.iter().zip(factors.iter().rev()) {
            let other = dot(free, change, &direction) / product;
            free.iter()
                .for_each(|&j| direction[j] += (factor - other) * step[j]);
        }
        direction
    }
}

fn dot(free: &[usize], a: &[f64], b: &[f64]) -> f64 {
    free.iter().map(|&j| a[j] * b[j]).sum()
}
