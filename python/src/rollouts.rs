//! The rollouts of a `Simulator`, and their derivatives. All arrays have an axis for robots in front.

use crate::arrays::{Number, array};
use crate::asked::{Asked, ends_absurd, seen, write};
use crate::device::Device;
use crate::errors::of_class;
use crate::simulator::Simulator;
use crate::work::{Interruptible, Stop, each, group_size, in_pool, whole};
use cosmic::inputs::{ALL, Block, WithOthers, vjp};
use cosmic::world::Span;
use numpy::{PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::ops::Range;
use std::sync::Arc;

/// Two arrays, such as positions and velocities.
pub(crate) type Pair<'py> = [Bound<'py, PyAny>; 2];

/// The arrays of a robot in the order of the bits of `by`, which chooses the gradients that are computed: the blocks of
/// [`ALL`], and all other inputs.
pub(crate) const GRADIENTS: [&str; 5] = ["z", "controller", "x0", "v0", "others"];

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

    /// Simulates all robots into the arrays `x` and `v`, as [`Asked::fill`] does. Lost robots get NaN. The thread must not have
    /// the interpreter's lock.
    pub(crate) fn filled<R: Number>(
        &self,
        asked: &Asked<R>,
        [x, v]: [&mut [R]; 2],
    ) -> PyResult<Interruptible<Option<usize>>> {
        let done = match self.device()? {
            None => in_pool(asked.robots, |stop| asked.fill(&self.task, [x, v], stop))?,
            Some(device) => {
                let (walks, interrupt) = in_pool(IN_POOL, |_| device.rollouts(&self.task, asked))?;
                let walks = walks.map_err(|why| device.failed(&why))?;
                (write(&walks, [x, v]), interrupt)
            }
        };
        let length = x.len() / asked.robots;
        let parts = x.chunks_mut(length).zip(v.chunks_mut(length));
        for ((x, v), _) in parts.zip(&asked.lost).filter(|(_, is_lost)| **is_lost) {
            x.fill(R::lit(f64::NAN));
            v.fill(R::lit(f64::NAN));
        }
        Ok(done)
    }

    /// For each robot, the gradient of its states times `bars`, by all inputs and then by its other inputs. Gradients whose bit
    /// in `by` (see [`GRADIENTS`]) is not set may be 0. The thread must not have the interpreter's lock.
    pub(crate) fn pulled<R: Number>(
        &self,
        asked: &Asked<R>,
        bars: [&[R]; 2],
        by: u32,
    ) -> PyResult<Products<R>> {
        if let Some(device) = self.device()? {
            let pulled = whole(in_pool(IN_POOL, |_| {
                device.pulled(&self.task, asked, bars)
            })?)?;
            return pulled.map_err(|why| device.failed(&why));
        }
        let is_wanted = |k: usize| by >> k & 1 == 1;
        let blocks = (0..ALL.len()).filter(|&k| is_wanted(k)).map(|k| ALL[k]);
        let blocks: Vec<Block> = blocks.collect();
        let length = bars[0].len() / asked.robots;
        let pull = |robots: Range<usize>| {
            let bars = robots.clone().flat_map(|robot| {
                let own = bars.map(|bar| &bar[robot * length..][..length]);
                own.concat()
            });
            let all = robots.clone().map(|robot| WithOthers {
                inputs: asked.inputs(robot),
                others: match is_wanted(ALL.len()) {
                    true => asked.others(robot).to_vec(),
                    false => Vec::new(),
                },
            });
            let all: Vec<_> = all.collect();
            let (values, gradients) = vjp(
                &all,
                &blocks,
                |all| seen(&self.task, asked, robots.start, all),
                &bars.collect::<Vec<_>>(),
            );
            let values = values.chunks(2 * length);
            let is_absurd = values.map(|values| ends_absurd(values, &self.sizes));
            let rows = gradients.iter().zip(robots);
            let rows = rows.map(|(own, robot)| asked.padded(&blocks, robot, own));
            is_absurd.zip(rows).collect::<Vec<_>>()
        };
        // Robots with a common controller cannot be simulated together, because each has its own gradient by it.
        let size = group_size(asked.robots, self.sizes.others.driven.is_some());
        let all = |stop: &Stop| each(asked.robots, size, stop, pull);
        let products = whole(in_pool(asked.robots, all)?)?;
        Ok(products.into_iter().flatten().collect())
    }

    /// For each robot its states, and then their derivatives in the direction `along`. The thread must not have the
    /// interpreter's lock.
    pub(crate) fn pushed<R: Number>(
        &self,
        asked: &Asked<R>,
        along: &Asked<R>,
    ) -> PyResult<Products<R>> {
        products(asked, |robot| {
            let [(own, others), (along, by_others)] =
                [asked, along].map(|of| (of.inputs(robot), of.others(robot)));
            let (values, slopes) = own.jvp(&along, [others, by_others], |robot_| {
                seen(&self.task, asked, robot, &[robot_])
            });
            let is_absurd = ends_absurd(&values, &self.sizes);
            (is_absurd, [values, slopes].concat())
        })
    }

    fn asked<R: Number>(&self, arrays: &[Bound<PyAny>], span: Span) -> PyResult<Asked<R>> {
        Asked::read(arrays, |data, counts, robots| {
            Asked::of(self, data, counts, robots, span)
        })
    }

    pub(crate) fn rollout_in<'py, R: Number>(
        &self,
        py: Python<'py>,
        arrays: &[Bound<'py, PyAny>],
        span: Span,
        check: bool,
    ) -> PyResult<Pair<'py>> {
        let asked = self.asked::<R>(arrays, span)?;
        let robots = asked.robots;
        let [nodes, axes] = self.sizes.points();
        let shape = [robots, asked.span.observed.len(), nodes, axes];
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

    /// The gradients of [`pulled`](Self::pulled): a row per robot.
    pub(crate) fn vjp_in<'py, R: Number>(
        &self,
        py: Python<'py>,
        arrays: &[Bound<'py, PyAny>],
        bars: [&Bound<'py, PyAny>; 2],
        span: Span,
        check: bool,
        by: u32,
    ) -> PyResult<Bound<'py, PyAny>> {
        let asked = self.asked::<R>(arrays, span)?;
        let [x, v] = bars.map(|bar| bar.extract::<PyReadonlyArrayDyn<R>>());
        let (x, v) = (x?, v?);
        let bars = [x.as_slice()?, v.as_slice()?];
        let products = py.detach(|| self.pulled(&asked, bars, by))?;
        self.rows(py, &asked, products, check)
    }

    /// For each robot one row: its positions, its velocities, and the tangents of both.
    pub(crate) fn jvp_in<'py, R: Number>(
        &self,
        py: Python<'py>,
        arrays: &[Bound<'py, PyAny>],
        tangents: &[Bound<'py, PyAny>],
        span: Span,
        check: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let asked = self.asked::<R>(arrays, span)?;
        let along = Asked::read(tangents, |data, counts, robots| {
            let span = asked.span.clone();
            Ok(Asked::along(&self.sizes, data, counts, robots, span))
        })?;
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
            } else if *is_absurd || asked.lost[robot] {
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
