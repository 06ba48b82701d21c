//! How far a robot walks on ground that is more slippery than that of its scene.

use std::sync::Arc;

use super::evaluator::Evaluator;
use super::variations::PERTURBED_ROLLOUTS;
use crate::design::{Design, Mixture};
use crate::laws::FRICTION;
use crate::policy::Controller;
use crate::world::Variation;

/// The share of the friction that remains when the ground is more slippery: rubber on a wet floor instead of a dry one.
pub const LOW_FRICTION: f64 = 0.6;

impl Evaluator {
    /// The median displacement along the ground (m) of the first eight of these varied robots with [`LOW_FRICTION`] times
    /// the friction. `None` if feet never slip, for tasks other than distance, and for an undecided design.
    pub(super) fn on_low_friction(
        &self,
        design: &Design<Mixture<f64>>,
        controller: &Controller<f64>,
        varied: &[Variation],
    ) -> Option<f64> {
        if !self.scene.slips() || !self.is_far() || design.layout().is_none() {
            return None;
        }
        let slippery = |variation: &Variation| {
            let surroundings = (*variation.surroundings).clone();
            Variation {
                surroundings: Arc::new(surroundings.scaled(FRICTION, LOW_FRICTION)),
                ..variation.clone()
            }
        };
        let variations = varied.iter().take(PERTURBED_ROLLOUTS).map(slippery);
        let variations: Vec<Variation> = variations.collect();
        let found = self.spreads(design, &[controller], &variations).remove(0);
        Some(found.displacement.p50)
    }
}
