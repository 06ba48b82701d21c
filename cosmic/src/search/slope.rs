//! [`Slope`], a gradient of the loss; [`GradientPoint`], the point at which gradients are computed; and means of gradients over
//! design passes and over variations.

use rayon::prelude::*;

use crate::inputs::Inputs;
use crate::optimiser::bound_norm;
use crate::world::{Span, Variation, World};

/// A gradient of the loss in its [unit](crate::objective::Loss::unit), with the loss and the robot's result within the
/// horizon. If the loss is not finite, the whole gradient is NaN, so that no optimiser uses it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Slope {
    /// The derivatives with respect to the variables.
    pub gradient: Vec<f64>,
    /// The loss.
    pub loss: f64,
    /// Displacement along the ground, in metres.
    pub displacement: f64,
    /// True if the payload does not move within the horizon and did not move in earlier passes. The gradient of the
    /// centre of mass is then used.
    pub stuck: bool,
}

impl Slope {
    /// The slope of a loss whose gradient is `gradient` divided by `unit`.
    pub(super) fn of<R: Into<f64> + Copy>(loss: f64, gradient: &[R], unit: f64) -> Self {
        let usable = |&g: &R| match loss.is_finite() {
            true => g.into() / unit,
            false => f64::NAN,
        };
        Self {
            gradient: gradient.iter().map(usable).collect(),
            loss,
            ..Self::default()
        }
    }

    /// Scales the gradient down if its norm is larger than the given norm. Returns the norm before scaling.
    pub fn bound(&mut self, norm: f64) -> f64 {
        bound_norm(&mut self.gradient, norm)
    }

    /// True if no variable has an influence on the loss: all derivatives are exactly zero.
    pub(super) fn is_flat(&self) -> bool {
        !self.gradient.is_empty() && self.gradient.iter().all(|&g| g == 0.0)
    }

    /// Replaces the gradient by its exponential running mean, `memory * mean + (1 - memory) * gradient`.
    /// The first gradient is the first mean. If `memory` is 0 or the gradient is not finite, neither the gradient nor
    /// the mean changes.
    pub fn averaged(&mut self, mean: &mut Vec<f64>, memory: f64) {
        if memory == 0.0 || !self.gradient.iter().all(|g| g.is_finite()) {
            return;
        }
        if mean.is_empty() {
            mean.clone_from(&self.gradient);
        }
        for (mean, g) in mean.iter_mut().zip(&mut self.gradient) {
            *mean = memory * *mean + (1.0 - memory) * *g;
            *g = *mean;
        }
    }

    /// The mean over variations of every field. `slopes` has one `Slope` for each variation.
    pub(super) fn mean<'a>(slopes: impl ExactSizeIterator<Item = &'a Self>) -> Self {
        let share = 1.0 / slopes.len() as f64;
        let mut mean = Self::default();
        for slope in slopes {
            mean.gradient.resize(slope.gradient.len(), 0.0);
            for (mean, g) in mean.gradient.iter_mut().zip(&slope.gradient) {
                *mean += share * g;
            }
            mean.loss += share * slope.loss;
            mean.displacement += share * slope.displacement;
        }
        mean
    }
}

/// The point at which gradients are computed: the robot, its variations, and the steps that carry the gradient.
pub struct GradientPoint {
    /// The variations that gradients are averaged over. If there are none, the gradient is that of the robot as designed.
    pub variations: Vec<Variation>,
    /// The inputs of the rollout: design vectors, controller and start. Variations have starts of their own.
    pub inputs: Inputs<f64>,
    /// The steps that carry the gradient (D11), and the bound on its cotangents. The rollout ends after them.
    pub horizon: Span,
    /// True if the payload has not moved in the last passes. The gradient of a payload that still does not move is then
    /// replaced by that of the centre of mass.
    pub sticks: bool,
}

impl GradientPoint {
    /// Calls `slopes` for every variation and returns the mean of each of the `N` gradients. Without variations, calls it
    /// once for the robot as designed.
    pub(super) fn means<const N: usize>(
        &self,
        world: &World,
        slopes: impl Fn(&Variation) -> [Slope; N] + Sync,
    ) -> [Slope; N] {
        if self.variations.is_empty() {
            return slopes(&world.nominal(&self.inputs.start));
        }
        // Collected in order, so that the sum does not depend on the number of threads.
        let of_all: Vec<[Slope; N]> = self.variations.par_iter().map(&slopes).collect();
        std::array::from_fn(|k| Slope::mean(of_all.iter().map(|slopes| &slopes[k])))
    }
}
