//! How far the payload gets along the ground.

use autodiff::Real;
use serde::{Deserialize, Serialize};

use super::Loss;
use crate::lattice::Ground;
use crate::simulator::Trajectory;

/// Minus the payload's position along the ground, `-(s . x_0)`: at the end, as the paper has it,
/// or averaged over the last part of the rollout.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Displacement {
    /// The ground along which is measured.
    pub ground: Ground,
    /// The states averaged over; `None` takes the last alone.
    pub average: Option<Average>,
}

/// Which states of the last part of a rollout are averaged over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Average {
    /// Length of that part in steps; a shorter rollout is averaged as a whole.
    pub window: usize,
    /// Every so many steps a state, counted back from the last; at least 1.
    pub every: usize,
}

impl Loss for Displacement {
    fn observed(&self, steps: usize) -> Vec<usize> {
        let Some(Average { window, every }) = self.average else {
            return vec![steps];
        };
        let count = window.min(steps).div_ceil(every).max(1);
        (0..count).rev().map(|k| steps - k * every).collect()
    }

    fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
        let observed = self.observed(trajectory.last_step());
        let along = |&step: &usize| {
            let [along, _] = self.ground.vector_to_ground(trajectory.at(step).x[0]);
            along
        };
        let positions: Vec<R> = observed.iter().map(along).collect();
        R::sum(&positions) * R::lit(-1.0 / positions.len() as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::{Average, Displacement, Loss};
    use crate::lattice::{Ground, State};
    use crate::simulator::Trajectory;

    fn displacement(incline_deg: f64, average: Option<Average>) -> Displacement {
        let ground = Ground {
            height: 0.1,
            incline_deg,
        };
        Displacement { ground, average }
    }

    const AVERAGE: Average = Average {
        window: 2048,
        every: 16,
    };

    #[test]
    fn the_average_looks_back_from_the_last_state() {
        let observed = displacement(0.0, Some(AVERAGE)).observed(4096);
        assert_eq!(
            (observed.len(), observed[0], observed[127]),
            (128, 2064, 4096)
        );
        assert!(observed.is_sorted());
    }

    #[test]
    fn a_short_rollout_is_averaged_as_a_whole() {
        let loss = displacement(0.0, Some(AVERAGE));
        assert_eq!(loss.observed(40), [8, 24, 40]);
        assert_eq!(loss.observed(0), [0]);
        assert_eq!(displacement(0.0, None).observed(40), [40]);
    }

    #[test]
    fn both_forms_measure_along_the_ground() {
        let state = |along: f64| State {
            x: vec![
                displacement(30.0, None)
                    .ground
                    .vector_to_world([along, 0.4]),
            ],
            v: vec![[0.0; 2]],
        };
        let trajectory = Trajectory {
            steps: vec![0, 8, 24, 40],
            states: [9.0, 1.0, 2.0, 6.0].map(state).to_vec(),
        };
        // Rotations of numbers below 10 are rounded at 1e-15.
        let last = displacement(30.0, None).loss(&trajectory);
        assert!((last + 6.0).abs() < 1e-14);
        let mean = displacement(30.0, Some(AVERAGE)).loss(&trajectory);
        assert!((mean + 3.0).abs() < 1e-14);
    }
}
