//! Designing for more than the nominal robot: gradients as means over drawn ones.

use rayon::prelude::*;

use super::passes::Slope;
use super::schedule::Moment;
use super::{CoDesign, Progress};
use crate::gradient::{Inputs, Task};
use crate::random::{Purpose, stream_of};
use crate::scatter::{World, draw};

impl CoDesign {
    /// The worlds of an iteration's gradients; none where the robot is designed as it is. They
    /// are drawn anew for every iteration, by its number: a resumed run draws the same.
    pub(super) fn worlds(&self, progress: &Progress, moment: &Moment) -> Vec<World> {
        let settings = &self.scene.robust;
        let number = moment.iteration as u64;
        let mut stream = stream_of(progress.seed, Purpose::Scatter, number);
        let world = |_| draw(&self.task, settings, &mut stream);
        (0..settings.samples).map(world).collect()
    }

    /// The mean of a gradient over worlds; with none of them that of the nominal task.
    pub(super) fn mean_slope(
        &self,
        worlds: &[World],
        inputs: &Inputs<f64>,
        slope: impl Fn(&Task, &Inputs<f64>) -> Slope + Sync,
    ) -> Slope {
        if worlds.is_empty() {
            return slope(&self.task, inputs);
        }
        let in_world = |world: &World| {
            let start = world.start.clone();
            let inputs = Inputs {
                start,
                ..inputs.clone()
            };
            slope(&world.task, &inputs)
        };
        // Collected in order: the sum does not depend on the number of threads.
        let slopes: Vec<Slope> = worlds.par_iter().map(in_world).collect();
        Slope::mean(&slopes)
    }
}

impl Slope {
    fn mean(slopes: &[Self]) -> Self {
        let share = 1.0 / slopes.len() as f64;
        let mut gradient = vec![0.0; slopes[0].gradient.len()];
        for slope in slopes {
            for (mean, g) in gradient.iter_mut().zip(&slope.gradient) {
                *mean += share * g;
            }
        }
        Self {
            gradient,
            displacement: slopes.iter().map(|s| share * s.displacement).sum(),
        }
    }
}
