//! The rollouts of a `Simulator`, and their derivatives.

use crate::arrays::{Given, NAMES, Number, Seen, array, behind};
use crate::asked::{Asked, Stop, each, ends_absurd, in_pool, seen, whole};
use crate::device::Device;
use crate::errors::{of_class, raised, refused};
use crate::memory::{has_room, kept};
use crate::pool::usual_threads;
use crate::simulator::Simulator;
use autodiff::Dual;
use cosmic::error::Error;
use cosmic::inputs::{ALL, Inputs};
use cosmic::simulator::Span;
use numpy::{PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::sync::Arc;

/// Work for the GPU runs in the thread pool like that of several robots, so that signals are noticed.
const IN_POOL: usize = 2;

impl Simulator {
    /// Checks that the scene has the observed steps of a rollout. They are counted from step `first`, at which the
    /// rollout starts.
    pub(crate) fn span(&self, observed: Vec<usize>, first: usize) -> PyResult<Span> {
        let planned = self.scene.physics.steps;
        let Some(&last) = observed.last() else {
            return Err(refused("observed: expected one step or more".to_owned()));
        };
        if !observed.is_sorted_by(|a, b| a < b) {
            return Err(refused(format!(
                "observed: expected steps that ascend, found {observed:?}"
            )));
        }
        if first.saturating_add(last) > planned {
            let wanted = first.saturating_add(last);
            return Err(refused(format!(
                "step {wanted} is beyond the scene's last step, {planned}; increase physics.steps"
            )));
        }
        Ok(Span {
            first,
            ..Span::from_start(observed)
        })
    }

    /// The GPU, if rollouts run there.
    fn device(&self) -> PyResult<Option<Arc<Device>>> {
        self.on_gpu.then(Device::shared).transpose()
    }

    fn shape(&self, batch: Option<usize>, span: &Span) -> Vec<usize> {
        behind(batch, &[span.observed.len(), self.sizes.nodes, 2])
    }

    /// Refuses rollouts whose results do not fit into memory. A rollout needs `copies` copies of the positions and
    /// velocities, `each` further bytes per robot, and `thread` further bytes per thread.
    fn results_fit<R: Number>(
        &self,
        asked: &Asked<R>,
        copies: usize,
        each: f64,
        thread: f64,
    ) -> PyResult<()> {
        let (robots, states) = (asked.batch.robots(), asked.span.observed.len());
        let numbers = 4 * copies * states * self.sizes.nodes;
        let robot = numbers as f64 * size_of::<R>() as f64 + each;
        // A single robot does not need the thread pool.
        let threads = if robots == 1 {
            1
        } else {
            usual_threads()?.min(robots)
        };
        let [robots_are, states_are] =
            [(robots, "robot"), (states, "observed state")].map(|(n, what)| {
                let plural = if n == 1 { "" } else { "s" };
                format!("{n} {what}{plural}")
            });
        let [of, or] = if thread == 0.0 {
            ["a rollout", ""]
        } else {
            [
                "the gradient of a rollout",
                ", or set gradient.memory in the scene",
            ]
        };
        has_room(
            robots as f64 * robot + threads as f64 * thread,
            &format!("{of} of {robots_are} with {states_are}"),
            &format!("use fewer robots at once, or observe fewer states (`observed`){or}"),
        )
    }

    /// Returns the exception for a robot whose rollout diverges.
    fn diverged<R: Number>(&self, asked: &Asked<R>, robot: usize) -> PyErr {
        of_robot(asked.batch.size, robot, asked.divergence(&self.task, robot))
    }

    pub(crate) fn rollout_in<'py, R: Number>(
        &self,
        py: Python<'py>,
        arrays: &[Bound<'py, PyAny>],
        span: Span,
        projection: &str,
        check: bool,
    ) -> PyResult<Seen<'py>> {
        let asked = Asked::<R>::new(&self.sizes, arrays, span, projection)?;
        self.results_fit(&asked, 1, 0.0, 0.0)?;
        let shape = self.shape(asked.batch.size, &asked.span);
        // The arrays are made by NumPy: it requests large memory pages for large arrays, which makes them ten times
        // cheaper.
        let (x, v) = (zeros::<R>(py, &shape)?, zeros::<R>(py, &shape)?);
        let (mut x_place, mut v_place) = (x.readwrite(), v.readwrite());
        let places = [x_place.as_slice_mut()?, v_place.as_slice_mut()?];
        let robots = asked.batch.robots();
        let (done, interrupt) = match self.device()? {
            None => in_pool(py, robots, |stop| {
                asked.fill(&self.task, places, stop, check)
            })?,
            Some(device) => {
                let walk = |_: &Stop| device.rollouts(&self.task, &asked);
                let (walks, interrupt) = in_pool(py, IN_POOL, walk)?;
                let walks = walks.map_err(|why| device.failed(&why))?;
                (asked.write(&self.task, &walks, places, check), interrupt)
            }
        };
        drop((x_place, v_place));
        if let Some(error) = interrupt {
            // The finished states become an attribute of the exception, if it accepts attributes.
            _ = error.value(py).setattr("trajectory", (x, v));
            return Err(error);
        }
        done.map_err(|(robot, error)| of_robot(asked.batch.size, robot, error))?;
        Ok([x.into_any(), v.into_any()])
    }

    pub(crate) fn vjp_in<'py, R: Number>(
        &self,
        py: Python<'py>,
        arrays: &[Bound<'py, PyAny>],
        cotangents: [&Bound<'py, PyAny>; 2],
        span: Span,
        projection: &str,
        check: bool,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let asked = Asked::<R>::new(&self.sizes, arrays, span, projection)?;
        let gradient = 2.0 * self.sizes.numbers() * size_of::<R>() as f64;
        let steps = asked.span.observed.last().copied().unwrap_or(0);
        let record = kept(&self.scene, &self.sizes, steps, size_of::<R>() as f64);
        self.results_fit(&asked, 1, gradient, record)?;
        let shape = self.shape(asked.batch.size, &asked.span);
        let [x_bar, v_bar] = [
            cotangent::<R>("x_bar", cotangents[0], &shape)?,
            cotangent::<R>("v_bar", cotangents[1], &shape)?,
        ];
        let products = match self.device()? {
            None => self.products(py, &asked, [&x_bar, &v_bar])?,
            Some(device) => {
                let pull = |_: &Stop| device.pulled(&self.task, &asked, [&x_bar, &v_bar]);
                let pulled = whole(in_pool(py, IN_POOL, pull)?)?;
                pulled.map_err(|why| device.failed(&why))?
            }
        };
        let or_nan = |(is_absurd, mut gradient): (bool, Vec<R>)| {
            if is_absurd {
                gradient.fill(R::lit(f64::NAN));
            }
            (is_absurd, gradient)
        };
        let (absurd, gradients): (Vec<bool>, Vec<Vec<R>>) =
            products.into_iter().map(or_nan).unzip();
        if let Some(robot) = absurd.iter().position(|&is| is).filter(|_| check) {
            return Err(self.diverged(&asked, robot));
        }
        let goals = asked.batch.components(0).len();
        let mut numbers = vec![Vec::new(); NAMES.len() + usize::from(goals > 0)];
        for gradient in gradients {
            let (inputs, goals) = gradient.split_at(gradient.len() - goals);
            let parts = self.sizes.split(inputs).into_iter().chain([goals.to_vec()]);
            for (numbers, part) in numbers.iter_mut().zip(parts) {
                numbers.extend(part);
            }
        }
        let shapes = self.sizes.shapes().into_iter().chain([vec![goals / 2, 2]]);
        let arrays = numbers.into_iter().zip(shapes).map(|(numbers, shape)| {
            Ok(array(py, numbers, &behind(asked.batch.size, &shape))?.into_any())
        });
        arrays.collect()
    }

    /// For each robot, whether its last state is absurd, and the gradient of its states times their cotangents.
    fn products<R: Number>(
        &self,
        py: Python,
        asked: &Asked<R>,
        [x_bar, v_bar]: [&[R]; 2],
    ) -> PyResult<Vec<(bool, Vec<R>)>> {
        let robots = asked.batch.robots();
        let length = x_bar.len() / robots;
        let product = |robot: usize| {
            let part = |bar: &[R]| bar[robot * length..][..length].to_vec();
            let cotangents = [part(x_bar), part(v_bar)].concat();
            let mixing = &asked.mixing[robot];
            let inputs = asked.batch.inputs(robot);
            let goals = asked.batch.components(robot);
            let function = |inputs: &Inputs<_>, goals: &[_]| {
                seen(&self.task, mixing, inputs, goals, &asked.span)
            };
            let (values, gradient) = inputs.vjp(ALL, &goals, function, &cotangents);
            (ends_absurd(&values, self.sizes.nodes), gradient)
        };
        whole(in_pool(py, robots, |stop| each(robots, stop, product))?)
    }

    pub(crate) fn jvp_in<'py, R: Number>(
        &self,
        py: Python<'py>,
        arrays: &[Bound<'py, PyAny>],
        tangents: &[Bound<'py, PyAny>],
        span: Span,
        projection: &str,
        check: bool,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let asked = Asked::<R>::new(&self.sizes, arrays, span, projection)?;
        self.results_fit(&asked, 4, 0.0, 0.0)?;
        let along = Asked::<R>::new(&self.sizes, tangents, asked.span.clone(), "none")?;
        if along
            .batch
            .size
            .is_some_and(|size| Some(size) != asked.batch.size)
        {
            return Err(refused(
                "tangents: inputs and tangents must have the same batch size".to_owned(),
            ));
        }
        let robots = asked.batch.robots();
        let product = |robot: usize| {
            let (mixing, inputs) = (&asked.mixing[robot], asked.batch.inputs(robot));
            let tangents = along.batch.inputs(robot % along.batch.robots());
            let goals = asked.batch.components(robot).into_iter();
            let goals: Vec<_> = goals.map(Dual::constant).collect();
            let (mut values, mut slopes) = inputs.jvp(&tangents, |inputs| {
                seen(&self.task, mixing, inputs, &goals, &asked.span)
            });
            let is_absurd = ends_absurd(&values, self.sizes.nodes);
            if is_absurd {
                values.fill(R::lit(f64::NAN));
                slopes.fill(R::lit(f64::NAN));
            }
            (is_absurd, (values, slopes))
        };
        let products = in_pool(py, robots, |stop| each(robots, stop, product))?;
        let (absurd, products): (Vec<bool>, Vec<_>) = whole(products)?.into_iter().unzip();
        if let Some(robot) = absurd.iter().position(|&is| is).filter(|_| check) {
            return Err(self.diverged(&asked, robot));
        }
        let shape = self.shape(asked.batch.size, &asked.span);
        let (values, slopes): (Vec<Vec<R>>, Vec<Vec<R>>) = products.into_iter().unzip();
        let mut arrays = Vec::new();
        for found in [values, slopes] {
            let half = found[0].len() / 2;
            for part in [0..half, half..2 * half] {
                let numbers = found.iter().flat_map(|numbers| &numbers[part.clone()]);
                arrays.push(array::<R>(py, numbers.copied().collect(), &shape)?.into_any());
            }
        }
        Ok(arrays)
    }
}

/// Converts an error about a robot to an exception. In a batch the message contains the number of the robot.
fn of_robot(batch: Option<usize>, robot: usize, error: Error) -> PyErr {
    match batch {
        None => raised(error),
        Some(_) => of_class(&error, format!("robot {robot}: {}", error.within())),
    }
}

/// Returns an array of zeros, or NumPy's exception if there is no memory for it.
fn zeros<'py, R: Number>(py: Python<'py>, shape: &[usize]) -> PyResult<Bound<'py, PyArrayDyn<R>>> {
    let numpy = py.import("numpy")?;
    let made = numpy.call_method1("zeros", (PyTuple::new(py, shape)?, numpy::dtype::<R>(py)))?;
    Ok(made.cast_into()?)
}

fn cotangent<R: Number>(name: &str, object: &Bound<PyAny>, shape: &[usize]) -> PyResult<Vec<R>> {
    let given = Given::<R>::new(name, object)?;
    if given.shape() != shape {
        let found = given.shape();
        return Err(refused(format!(
            "{name}: expected the shape {shape:?}, found {found:?}"
        )));
    }
    Ok(given.numbers()?.to_vec())
}
