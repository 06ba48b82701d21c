//! Designing for more than the nominal robot: gradients as means over drawn ones.

use rayon::prelude::*;

use super::schedule::Schedule;
use super::slopes::{At, Slope};
use super::{CoDesign, Progress};
use crate::gradient::{Inputs, Task};
use crate::random::{Purpose, stream_of};
use crate::scatter::{World, draw};

impl CoDesign {
    /// The worlds of an iteration's gradients; none where the robot is designed as it is. They
    /// are drawn anew for every iteration, by its number: a resumed run draws the same.
    pub(super) fn worlds(&self, progress: &Progress, now: &Schedule) -> Vec<World> {
        let settings = &self.scene.robust;
        let number = now.iteration as u64;
        let mut stream = stream_of(progress.seed, Purpose::Scatter, number);
        let world = |_| draw(&self.task, settings, &mut stream);
        (0..settings.samples).map(world).collect()
    }

    /// The means of gradients over worlds; with none of them those of the nominal task.
    pub(super) fn means<const N: usize>(
        &self,
        at: At,
        slopes: impl Fn(&Task, &Inputs<f64>) -> [Slope; N] + Sync,
    ) -> [Slope; N] {
        if at.worlds.is_empty() {
            return slopes(&self.task, at.inputs);
        }
        let in_world = |world: &World| {
            let start = world.start.clone();
            let inputs = Inputs {
                start,
                ..at.inputs.clone()
            };
            slopes(&world.task, &inputs)
        };
        // Collected in order: the sum does not depend on the number of threads.
        let of_worlds: Vec<[Slope; N]> = at.worlds.par_iter().map(in_world).collect();
        std::array::from_fn(|k| Slope::mean(of_worlds.iter().map(|slopes| &slopes[k])))
    }
}

impl Slope {
    fn mean<'a>(slopes: impl ExactSizeIterator<Item = &'a Self>) -> Self {
        let share = 1.0 / slopes.len() as f64;
        let mut mean = Self {
            gradient: Vec::new(),
            loss: 0.0,
            displacement: 0.0,
        };
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
