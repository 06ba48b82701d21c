//! Populations on a GPU.

use crate::arrays::{Number, flattened};
use crate::asked::{Asked, scaled, surroundings_of};
use crate::errors::{Error, InputError};
use crate::work::OfProcess;
use autodiff::Var;
use cosmic::inputs::{ALL, Inputs};
use cosmic::lattice::Body;
use cosmic::world::Task;
use cosmic::world::{Trajectory, Wanted};
use cosmic_gpu::{Batch, Gpu, Losses, Member, OnGpu, Refused};
use pyo3::prelude::*;
use std::sync::Arc;

/// A GPU with the programs that it has compiled.
pub(crate) struct Device(OnGpu);

static OPENED: OfProcess<Device> = OfProcess::new();

/// A robot's positions and velocities times their cotangents, as a loss.
struct Pulled<'a, R> {
    task: &'a Task,
    asked: &'a Asked<R>,
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
        task: &Task,
        asked: &Asked<R>,
    ) -> Result<Vec<Trajectory<R>>, Refused> {
        let walks = self.0.rollouts(&batch(task, asked))?.into_iter();
        Ok(walks.map(|walk| walk.map(R::lit)).collect())
    }

    /// For each robot, whether its last state is absurd, and the gradient of its states times `bars` by all inputs and
    /// then by its other inputs.
    pub(crate) fn pulled<R: Number>(
        &self,
        task: &Task,
        asked: &Asked<R>,
        bars: [&[R]; 2],
    ) -> Result<Vec<(bool, Vec<R>)>, Refused> {
        let of = batch(task, asked);
        let by = Wanted {
            bodies: true,
            controllers: true,
            surroundings: !asked.others(0).is_empty(),
        };
        let losses = Pulled { task, asked, bars };
        let found = self.0.differentiated(&of, by, &losses)?.into_iter();
        let single = |gradient: Vec<f64>| gradient.into_iter().map(R::lit).collect();
        let found = found.map(|found| {
            let last = found.trajectory.states.last();
            let is_absurd = last.is_some_and(|state| state.is_absurd());
            (is_absurd, single(found.gradient))
        });
        Ok(found.collect())
    }
}

/// The requested robots as a population.
fn batch<R: Number>(task: &Task, asked: &Asked<R>) -> Batch {
    let robots = asked.robots;
    let or_one = |is_shared: bool| 0..if is_shared { 1 } else { robots };
    let body = |robot| -> Body<f64> { asked.body(task, robot).map(Into::into) };
    let surroundings = |robot| asked.surroundings(task, robot).map(Into::into);
    Batch {
        simulator: task.simulator.clone(),
        span: asked.span.clone(),
        surroundings: or_one(asked.shares_surroundings())
            .map(surroundings)
            .collect(),
        bodies: or_one(asked.shares_body()).map(body).collect(),
        controllers: or_one(asked.shared_controller().is_some())
            .map(|robot| asked.controller(robot).map(Into::into))
            .collect(),
        starts: (0..robots)
            .map(|robot| asked.start(robot).map(Into::into))
            .collect(),
    }
}

impl<R: Number> Pulled<'_, R> {
    fn inputs(&self, robot: usize) -> Inputs<f64> {
        self.asked.inputs(robot).map(Into::into)
    }
}

impl<R: Number> Losses for Pulled<'_, R> {
    fn numbers(&self, robot: usize) -> Vec<f64> {
        let others = self.asked.others(robot).iter();
        let mut numbers = self.inputs(robot).get(ALL);
        numbers.extend(others.map(|&x| Into::<f64>::into(x)));
        numbers
    }

    fn robot(&self, robot: usize, numbers: &[Var<f64>]) -> Member<Var<f64>> {
        let mut inputs: Inputs<Var<f64>> = self.inputs(robot).lift();
        let others = self.asked.others(robot).len();
        let (own, others) = numbers.split_at(numbers.len() - others);
        inputs.set(ALL, own);
        let body = self.asked.mixing[robot].body(self.task, &inputs.z);
        let sizes = &self.asked.sizes;
        Member {
            surroundings: surroundings_of(self.task, sizes, others),
            body: scaled(self.task, sizes, body, others),
            controller: inputs.controller,
            start: inputs.start,
        }
    }

    fn loss(&self, robot: usize, walk: &Trajectory<Var<f64>>) -> Var<f64> {
        let length = self.bars[0].len() / self.asked.robots;
        let bars = self.bars.map(|bars| &bars[robot * length..][..length]);
        let pairs = flattened(std::slice::from_ref(walk)).concat().into_iter();
        let pairs = pairs.zip(bars.concat());
        pairs.map(|(x, bar)| x * Var::constant(bar.into())).sum()
    }
}
