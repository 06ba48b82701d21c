//! The loss for robots that should get far: the displacement along the ground of the payload, or of the body that the
//! scene names.

use autodiff::Real;

use super::Loss;
use crate::geometry::Ground;
use crate::scene::{LossKind, LossSettings};
use crate::world::Trajectory;

/// The loss that rewards distance: minus the [position](Trajectory::position) of the payload, or of the body that the
/// scene names, along the ground, `-(s . x_0)`. The position is taken at the end, as in the paper, or averaged over the
/// last part of the rollout.
#[derive(Clone, Debug, PartialEq)]
pub struct Displacement {
    /// The ground along which the position is measured.
    pub ground: Ground,
    /// The settings that decide at which states the loss reads the position.
    pub settings: LossSettings,
}

impl Displacement {
    /// The paper's loss: minus the position after the last step.
    pub fn at_end(ground: Ground) -> Self {
        let settings = LossSettings {
            kind: LossKind::Final,
            ..LossSettings::default()
        };
        Self { ground, settings }
    }
}

impl Loss for Displacement {
    fn observed(&self, steps: usize) -> Vec<usize> {
        let LossSettings { window, every, .. } = self.settings;
        if self.settings.kind == LossKind::Final {
            return vec![steps];
        }
        let count = window.min(steps).div_ceil(every).max(1);
        (0..count).rev().map(|k| steps - k * every).collect()
    }

    fn nodes(&self) -> usize {
        1
    }

    fn is_far(&self) -> bool {
        true
    }

    fn unit(&self, scale: f64) -> f64 {
        scale
    }

    fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
        let observed = self.observed(trajectory.last_step());
        let along = |&step: &usize| self.ground.along(trajectory.position(step));
        let positions: Vec<R> = observed.iter().map(along).collect();
        R::sum_of(&positions) * R::lit(-1.0 / positions.len() as f64)
    }
}
