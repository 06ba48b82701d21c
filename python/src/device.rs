//! Populations on a GPU.

use crate::arrays::{Number, flattened};
use crate::asked::Asked;
use crate::errors::{Error, InputError};
use crate::work::OfProcess;
use autodiff::{Parameters, Var};
use cosmic::world::{Robot, Trajectory};
use cosmic_gpu::{Gpu, Losses, OnGpu, Refused, Wanted};
use pyo3::prelude::*;
use std::sync::Arc;

/// A GPU with the programs that it has compiled.
pub(crate) struct Device(OnGpu);

static OPENED: OfProcess<Device> = OfProcess::new();

/// A robot's positions and velocities times their cotangents, as a loss.
struct Pulled<'a, R> {
    asked: &'a Asked<'a, R>,
    /// The cotangents of all robots' observed positions, and of their velocities.
    bars: [&'a [R]; 2],
}

impl Device {
    /// Whether this wheel has GPU support.
    pub(crate) const IS_SUPPORTED: bool = true;

    /// Returns the GPU of this process.
    pub(crate) fn shared() -> PyResult<Arc<Self>> {
        OPENED.get(|| {
            let gpu = Gpu::of_environment();
            let gpu = gpu.map_err(|error| InputError::new_err(error.to_string()))?;
            Ok(Self(OnGpu::new(gpu)))
        })
    }

    /// The exception for work that the device cannot do.
    pub(crate) fn failed(&self, why: &str) -> PyErr {
        Error::new_err(format!(
            "{} cannot simulate this: {why}",
            self.0.gpu().adapter().name
        ))
    }

    /// Computes the rollouts of all robots, in single precision.
    pub(crate) fn rollouts<R: Number>(
        &self,
        asked: &Asked<R>,
    ) -> Result<Vec<Trajectory<R>>, Refused> {
        let robots = asked.robots(0..asked.count, Into::into);
        let walks = self.0.run(&asked.kind.world, &robots, &asked.span)?;
        Ok(walks.into_iter().map(|walk| walk.map(R::lit)).collect())
    }

    /// For each robot, whether its last state is absurd, and the gradient of its states times `bars` by all its arrays.
    pub(crate) fn pulled<R: Number>(
        &self,
        asked: &Asked<R>,
        bars: [&[R]; 2],
    ) -> Result<Vec<(bool, Vec<R>)>, Refused> {
        let robots = asked.robots(0..asked.count, Into::into);
        let by = Wanted {
            bodies: true,
            controllers: true,
            surroundings: asked.arrays.len() > asked.kind.sizes.shapes().len(),
        };
        let (world, losses) = (&asked.kind.world, Pulled { asked, bars });
        let found = (self.0).differentiated(world, &robots, &asked.span, by, &losses)?;
        let single = |gradient: Vec<f64>| gradient.into_iter().map(R::lit).collect();
        let found = found.into_iter().map(|found| {
            let last = found.trajectory.states.last();
            let is_absurd = last.is_some_and(|state| state.is_absurd());
            (is_absurd, single(found.gradient))
        });
        Ok(found.collect())
    }
}

impl<R: Number> Losses for Pulled<'_, R> {
    fn numbers(&self, robot: usize) -> Vec<f64> {
        let row = self.asked.arrays.row(robot).into_iter();
        row.map(Into::into).collect()
    }

    fn robot(&self, robot: usize, numbers: &[Var<f64>]) -> Robot<Var<f64>> {
        self.asked.robot(robot, numbers, None)
    }

    fn loss(&self, robot: usize, walk: &Trajectory<Var<f64>>) -> Var<f64> {
        let length = self.bars[0].len() / self.asked.count;
        let bars = self.bars.map(|bars| &bars[robot * length..][..length]);
        let pairs = flattened(std::slice::from_ref(walk)).concat().into_iter();
        let pairs = pairs.zip(bars.concat());
        pairs.map(|(x, bar)| x * Var::constant(bar.into())).sum()
    }
}
