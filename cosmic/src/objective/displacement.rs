//! The loss for robots that should get far: the displacement along the ground of the payload, or of the body that the
//! scene names.

use autodiff::Real;

use super::Loss;
use crate::geometry::Ground;
use crate::scene::{LossKind, LossSettings};
use crate::simulator::Trajectory;

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

#[cfg(test)]
mod tests {
    use super::Displacement;
    use crate::geometry::{Ground, Vector};
    use crate::lattice::State;
    use crate::objective::Loss;
    use crate::scene::{LossKind, LossSettings};
    use crate::simulator::Trajectory;

    fn displacement(kind: LossKind) -> Displacement {
        Displacement {
            ground: Ground {
                height: 0.1,
                incline_deg: 30.0,
            },
            settings: LossSettings {
                kind,
                ..LossSettings::default()
            },
        }
    }

    /// The mean covers the last steps of a rollout. If a rollout is shorter than the window, the mean covers the whole
    /// rollout.
    #[test]
    fn the_mean_looks_back_from_the_last_state() {
        let observed = |kind, steps| displacement(kind).observed(steps);
        let last_half: Vec<usize> = (2064..=4096).step_by(16).collect();
        assert_eq!(observed(LossKind::Mean, 4096), last_half);
        assert_eq!(observed(LossKind::Mean, 40), [8, 24, 40]);
        assert_eq!(observed(LossKind::Mean, 0), [0]);
        assert_eq!(observed(LossKind::Final, 40), [40]);
    }

    #[test]
    fn both_forms_measure_along_the_ground() {
        let ground = displacement(LossKind::Final).ground;
        let state = |along: f64| State {
            x: vec![ground.vector_to_world(Vector::new([along, 0.4]))],
            v: vec![Vector::zero()],
        };
        let states = [9.0, 1.0, 2.0, 6.0].map(state).to_vec();
        let trajectory = Trajectory::new(vec![0, 8, 24, 40], states);
        // Rotating vectors with entries below 10 has rounding errors of 1e-15.
        let last = displacement(LossKind::Final).loss(&trajectory);
        assert!((last + 6.0).abs() < 1e-14);
        let mean = displacement(LossKind::Mean).loss(&trajectory);
        assert!((mean + 3.0).abs() < 1e-14);
    }
}
