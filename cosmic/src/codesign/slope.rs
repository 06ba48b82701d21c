//! [`Slope`], a gradient of the loss; [`GradientPoint`], the point at which gradients are computed; and means of gradients over
//! design passes and over domains.

use rayon::prelude::*;

use crate::domain::Domain;
use crate::inputs::Inputs;
use crate::optimiser::bound_norm;
use crate::task::{Horizon, Task};

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
    /// The number by which robots are ranked, as in [`Reached::merit`](super::reach::Reached::merit).
    pub merit: f64,
    /// True if the payload does not move within the horizon and did not move in earlier passes. The gradient of the
    /// centre of mass is then used.
    pub stuck: bool,
}

impl Slope {
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

    /// The mean over domains of every field. `slopes` has one `Slope` for each domain.
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
            mean.merit += share * slope.merit;
        }
        mean
    }
}

/// The point at which gradients are computed: the robot and its start, the domains, and the horizon.
pub struct GradientPoint<'a> {
    /// The domains that gradients are averaged over. If there are none, the gradient of the nominal task is used.
    pub domains: Vec<Domain<'a>>,
    /// The inputs of the rollout: design vectors, controller and start.
    pub inputs: Inputs<f64>,
    /// The steps that carry the gradient.
    pub horizon: Horizon,
    /// True if the payload has not moved in the last passes. The gradient of a payload that still does not move is then
    /// replaced by that of the centre of mass.
    pub sticks: bool,
}

impl GradientPoint<'_> {
    /// Calls `slopes` in every domain and returns the mean of each of the `N` gradients. Without domains, calls it once
    /// for the nominal task.
    pub(super) fn means<const N: usize>(
        &self,
        nominal: &Task,
        slopes: impl Fn(&Task, &Inputs<f64>) -> [Slope; N] + Sync,
    ) -> [Slope; N] {
        if self.domains.is_empty() {
            return slopes(nominal, &self.inputs);
        }
        let in_domain = |domain: &Domain| {
            let mut inputs = self.inputs.clone();
            inputs.start.clone_from(&domain.start);
            slopes(&domain.task, &inputs)
        };
        // Collected in order, so that the sum does not depend on the number of threads.
        let of_domains: Vec<[Slope; N]> = self.domains.par_iter().map(in_domain).collect();
        std::array::from_fn(|k| Slope::mean(of_domains.iter().map(|slopes| &slopes[k])))
    }
}
