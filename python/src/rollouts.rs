//! The rollouts of a `Simulator`, and their derivatives. All arrays have an axis for robots in front.

use crate::arrays::{Number, array};
use crate::asked::{Asked, ends_absurd, seen, write};
use crate::device::Device;
use crate::errors::of_class;
use crate::simulator::Simulator;
use crate::work::{Interruptible, Stop, each, in_pool, whole};
use cosmic::inputs::{ALL, Inputs};
use cosmic::simulator::Span;
use numpy::{PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::sync::Arc;

/// Two arrays, such as positions and velocities.
pub(crate) type Pair<'py> = [Bound<'py, PyAny>; 2];

/// Work for the GPU runs in the thread pool like that of several robots, so that signals are noticed.
const IN_POOL: usize = 2;

/// For each robot, whether its last state is absurd, and numbers.
pub(crate) type Products<R> = Vec<(bool, Vec<R>)>;

impl Simulator {
    /// The GPU, if rollouts run there.
    fn device(&self) -> PyResult<Option<Arc<Device>>> {
        self.on_gpu.then(Device::shared).transpose()
    }

    /// Returns the exception for a robot whose rollout diverges.
    fn diverged<R: Number>(&self, asked: &Asked<R>, robot: usize) -> PyErr {
        let error = asked.divergence(&self.task, robot);
        match asked.robots {
            1 => of_class(&error, error.within()),
            _ => of_class(&error, format!("robot {robot}: {}", error.within())),
        }
    }

    /// Simulates all robots into the arrays `x` and `v`, as [`Asked::fill`] does. The thread must not have the
    /// interpreter's lock.
    pub(crate) fn filled<R: Number>(
        &self,
        asked: &Asked<R>,
        places: [&mut [R]; 2],
    ) -> PyResult<Interruptible<Option<usize>>> {
        let Some(device) = self.device()? else {
            return in_pool(asked.robots, |stop| asked.fill(&self.task, places, stop));
        };
        let (walks, interrupt) = in_pool(IN_POOL, |_| device.rollouts(&self.task, asked))?;
        let walks = walks.map_err(|why| device.failed(&why))?;
        Ok((write(&walks, places), interrupt))
    }

    /// For each robot, the gradient of its states times `bars`, by all inputs and then by its other inputs. The thread must not
    /// have the interpreter's lock.
    pub(crate) fn pulled<R: Number>(
        &self,
        asked: &Asked<R>,
        bars: [&[R]; 2],
    ) -> PyResult<Products<R>> {
        if let Some(device) = self.device()? {
            let pulled = whole(in_pool(IN_POOL, |_| {
                device.pulled(&self.task, asked, bars)
            })?)?;
            return pulled.map_err(|why| device.failed(&why));
        }
        products(asked, |robot| {
            let length = bars[0].len() / asked.robots;
            let cotangents = bars.map(|bar| &bar[robot * length..][..length]).concat();
            let mixing = &asked.mixing[robot];
            let function = |inputs: &Inputs<_>, others: &[_]| {
                seen(&self.task, &self.sizes, mixing, inputs, others, &asked.span)
            };
            let (inputs, others) = (asked.inputs(robot), asked.others(robot));
            let (values, gradient) = inputs.vjp(ALL, others, function, &cotangents);
            (ends_absurd(&values, self.sizes.nodes), gradient)
        })
    }

    /// For each robot its states, and then their derivatives in the direction `along`. The thread must not have the
    /// interpreter's lock.
    pub(crate) fn pushed<R: Number>(
        &self,
        asked: &Asked<R>,
        along: &Asked<R>,
    ) -> PyResult<Products<R>> {
        products(asked, |robot| {
            let mixing = &asked.mixing[robot];
            let function = |inputs: &Inputs<_>, others: &[_]| {
                seen(&self.task, &self.sizes, mixing, inputs, others, &asked.span)
            };
            let others = [asked, along].map(|of| of.others(robot));
            let tangents = along.inputs(robot);
            let (values, slopes) = asked.inputs(robot).jvp(&tangents, others, function);
            let is_absurd = ends_absurd(&values, self.sizes.nodes);
            (is_absurd, [values, slopes].concat())
        })
    }

    pub(crate) fn rollout_in<'py, R: Number>(
        &self,
        py: Python<'py>,
        arrays: &[Bound<'py, PyAny>],
        span: Span,
        projection: &str,
        check: bool,
    ) -> PyResult<Pair<'py>> {
        let asked = Asked::<R>::new(&self.sizes, arrays, span, projection)?;
        let robots = asked.robots;
        let shape = [robots, asked.span.observed.len(), self.sizes.nodes, 2];
        // The arrays are made by NumPy: it requests large memory pages for large arrays, which makes them ten times
        // cheaper.
        let (x, v) = (zeros::<R>(py, &shape)?, zeros::<R>(py, &shape)?);
        let (mut x_place, mut v_place) = (x.readwrite(), v.readwrite());
        let places = [x_place.as_slice_mut()?, v_place.as_slice_mut()?];
        let (absurd, interrupt) = py.detach(|| self.filled(&asked, places))?;
        drop((x_place, v_place));
        if let Some(error) = interrupt {
            // The finished states become an attribute of the exception, if it accepts attributes.
            _ = error.value(py).setattr("trajectory", (x, v));
            return Err(error);
        }
        match absurd.filter(|_| check) {
            Some(robot) => Err(self.diverged(&asked, robot)),
            None => Ok([x.into_any(), v.into_any()]),
        }
    }

    /// The gradient of each robot's states times `bars`, by all inputs and then by its other inputs: a row per robot.
    pub(crate) fn vjp_in<'py, R: Number>(
        &self,
        py: Python<'py>,
        arrays: &[Bound<'py, PyAny>],
        bars: [&Bound<'py, PyAny>; 2],
        span: Span,
        projection: &str,
        check: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let asked = Asked::<R>::new(&self.sizes, arrays, span, projection)?;
        let [x, v] = bars.map(|bar| bar.extract::<PyReadonlyArrayDyn<R>>());
        let (x, v) = (x?, v?);
        let bars = [x.as_slice()?, v.as_slice()?];
        let products = py.detach(|| self.pulled(&asked, bars))?;
        self.rows(py, &asked, products, check)
    }

    /// For each robot one row: its positions, its velocities, and the tangents of both.
    pub(crate) fn jvp_in<'py, R: Number>(
        &self,
        py: Python<'py>,
        arrays: &[Bound<'py, PyAny>],
        tangents: &[Bound<'py, PyAny>],
        span: Span,
        projection: &str,
        check: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let asked = Asked::<R>::new(&self.sizes, arrays, span, projection)?;
        let along = Asked::<R>::new(&self.sizes, tangents, asked.span.clone(), "none")?;
        let products = py.detach(|| self.pushed(&asked, &along))?;
        self.rows(py, &asked, products, check)
    }

    /// Makes an array with a row for each robot. The numbers of a robot that diverged are NaN, or an exception if `check`
    /// is true.
    fn rows<'py, R: Number>(
        &self,
        py: Python<'py>,
        asked: &Asked<R>,
        mut products: Products<R>,
        check: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        for (robot, (is_absurd, numbers)) in products.iter_mut().enumerate() {
            if *is_absurd && check {
                return Err(self.diverged(asked, robot));
            } else if *is_absurd {
                numbers.fill(R::lit(f64::NAN));
            }
        }
        let shape = [products.len(), products[0].1.len()];
        let numbers = products.into_iter().flat_map(|(_, numbers)| numbers);
        Ok(array(py, numbers.collect(), &shape)?.into_any())
    }
}

/// Applies a function to every robot.
fn products<R: Number>(
    asked: &Asked<R>,
    of: impl Fn(usize) -> (bool, Vec<R>) + Sync + Send,
) -> PyResult<Products<R>> {
    let robots = asked.robots;
    let all = |stop: &Stop| each(robots, 1, stop, |robot| of(robot.start));
    whole(in_pool(robots, all)?)
}

/// Returns an array of zeros, or NumPy's exception if there is no memory for it.
fn zeros<'py, R: Number>(py: Python<'py>, shape: &[usize]) -> PyResult<Bound<'py, PyArrayDyn<R>>> {
    let numpy = py.import("numpy")?;
    let made = numpy.call_method1("zeros", (PyTuple::new(py, shape)?, numpy::dtype::<R>(py)))?;
    Ok(made.cast_into()?)
}
