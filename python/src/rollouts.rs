//! Rollouts and their derivatives. All arrays have an axis for robots in front.

use crate::arrays::{Arrays, Number, array};
use crate::asked::{Asked, ends_absurd, write};
use crate::device::Device;
use crate::errors::of_class;
use crate::kind::Kind;
use crate::work::{Interruptible, Stop, each, group_size, in_pool, whole};
use autodiff::{Var, jvp, vjp};
use cosmic::world::{Robot, Span};
use numpy::{PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::ops::Range;
use std::sync::Arc;

/// Two arrays, such as positions and velocities.
pub(crate) type Pair<'py> = [Bound<'py, PyAny>; 2];

/// Work for the GPU runs in the thread pool like that of several robots, so that signals are noticed.
const IN_POOL: usize = 2;

/// For each robot, whether its last state is absurd, and numbers.
pub(crate) type Products<R> = Vec<(bool, Vec<R>)>;

impl<R: Number> Asked<'_, R> {
    /// The GPU, if rollouts run there.
    fn device(&self) -> PyResult<Option<Arc<Device>>> {
        self.kind.on_gpu.then(Device::shared).transpose()
    }

    /// Returns the exception for a robot whose rollout diverges.
    fn diverged(&self, robot: usize) -> PyErr {
        let error = self.divergence(robot);
        match self.count {
            1 => of_class(&error, error.within()),
            _ => of_class(&error, format!("robot {robot}: {}", error.within())),
        }
    }

    /// Simulates all robots into the arrays `x` and `v`, as [`Asked::fill`] does. Lost robots get NaN. The thread must not have
    /// the interpreter's lock.
    pub(crate) fn filled(&self, [x, v]: [&mut [R]; 2]) -> PyResult<Interruptible<Option<usize>>> {
        let done = match self.device()? {
            None => in_pool(self.count, |stop| self.fill([x, v], stop))?,
            Some(device) => {
                let (walks, interrupt) = in_pool(IN_POOL, |_| device.rollouts(self))?;
                let walks = walks.map_err(|why| device.failed(&why))?;
                (write(&walks, [x, v]), interrupt)
            }
        };
        let length = x.len() / self.count;
        let parts = x.chunks_mut(length).zip(v.chunks_mut(length));
        for ((x, v), _) in parts.zip(&self.lost).filter(|(_, is_lost)| **is_lost) {
            x.fill(R::lit(f64::NAN));
            v.fill(R::lit(f64::NAN));
        }
        Ok(done)
    }

    /// For each robot, the gradient of its states times `bars`, by all its arrays. Gradients whose bit in `by` (see
    /// [`GRADIENTS`](crate::arrays::GRADIENTS)) is not set may be 0. The thread must not have the interpreter's lock.
    pub(crate) fn pulled(&self, bars: [&[R]; 2], by: u32) -> PyResult<Products<R>> {
        if let Some(device) = self.device()? {
            let pulled = whole(in_pool(IN_POOL, |_| device.pulled(self, bars))?)?;
            return pulled.map_err(|why| device.failed(&why));
        }
        let (places, sizes) = (self.kind.sizes.places(by), &self.kind.sizes);
        let length = bars[0].len() / self.count;
        let pull = |robots: Range<usize>| {
            let rows: Vec<Vec<R>> = robots.clone().map(|robot| self.arrays.row(robot)).collect();
            let own = rows.iter().flat_map(|row| places.iter().map(|&at| row[at]));
            let bars = robots.clone().flat_map(|robot| {
                let own = bars.map(|bar| &bar[robot * length..][..length]);
                own.concat()
            });
            let of_robot = |k: usize| k * places.len()..(k + 1) * places.len();
            let seen = |variables: &[Var<R>]| {
                let all = rows.iter().zip(robots.clone()).enumerate();
                let all = all.map(|(k, (row, robot))| {
                    let mut row: Vec<Var<R>> = row.iter().copied().map(Var::constant).collect();
                    set(&mut row, &places, &variables[of_robot(k)]);
                    self.robot(robot, &row, None)
                });
                self.seen(&all.collect::<Vec<Robot<_>>>())
            };
            let (own, bars): (Vec<R>, Vec<R>) = (own.collect(), bars.collect());
            let (values, gradient) = vjp(seen, &own, &bars);
            let values = values.chunks(2 * length);
            let is_absurd = values.map(|values| ends_absurd(values, sizes));
            let gradients = rows.iter().enumerate().map(|(k, row)| {
                let mut padded = vec![R::zero(); row.len()];
                set(&mut padded, &places, &gradient[of_robot(k)]);
                padded
            });
            is_absurd.zip(gradients).collect::<Vec<_>>()
        };
        // Robots with a common controller cannot be simulated together, because each has its own gradient by it.
        products(self.count, sizes.others.driven.is_some(), pull)
    }

    /// For each robot its states, and then their derivatives in the direction `along`. The thread must not have the
    /// interpreter's lock.
    pub(crate) fn pushed(&self, along: &Arrays<R>) -> PyResult<Products<R>> {
        products(self.count, false, |robots| {
            let robot = robots.start;
            let (values, slopes) = jvp(
                |row| self.seen(&[self.robot(robot, row, None)]),
                &self.arrays.row(robot),
                &along.row(robot),
            );
            let is_absurd = ends_absurd(&values, &self.kind.sizes);
            vec![(is_absurd, [values, slopes].concat())]
        })
    }

    /// Makes an array with a row for each robot. The numbers of a robot that diverged are NaN, or an exception if `check`
    /// is true.
    fn rows<'py>(
        &self,
        py: Python<'py>,
        mut products: Products<R>,
        check: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        for (robot, (is_absurd, numbers)) in products.iter_mut().enumerate() {
            if *is_absurd && check {
                return Err(self.diverged(robot));
            } else if *is_absurd || self.lost[robot] {
                numbers.fill(R::lit(f64::NAN));
            }
        }
        let shape = [products.len(), products[0].1.len()];
        let numbers = products.into_iter().flat_map(|(_, numbers)| numbers);
        Ok(array(py, numbers.collect(), &shape)?.into_any())
    }
}

/// Reads the request of Python for the rollouts of all robots of these arrays.
fn read<'a, R: Number>(
    kind: &'a Kind,
    arrays: &[Bound<PyAny>],
    span: Span,
) -> PyResult<Asked<'a, R>> {
    let arrays = Arrays::read(arrays)?;
    let robots = arrays.robots();
    Asked::new(kind, arrays, robots, span)
}

/// Returns the positions and the velocities of robots.
pub(crate) fn states<'py, R: Number>(
    py: Python<'py>,
    kind: &Kind,
    arrays: &[Bound<'py, PyAny>],
    span: Span,
    check: bool,
) -> PyResult<Pair<'py>> {
    let asked = read::<R>(kind, arrays, span)?;
    let [nodes, axes] = kind.sizes.points();
    let shape = [asked.count, asked.span.observed.len(), nodes, axes];
    // The arrays are made by NumPy: it requests large memory pages for large arrays, which makes them ten times
    // cheaper.
    let (x, v) = (zeros::<R>(py, &shape)?, zeros::<R>(py, &shape)?);
    let (mut x_place, mut v_place) = (x.readwrite(), v.readwrite());
    let places = [x_place.as_slice_mut()?, v_place.as_slice_mut()?];
    let (absurd, interrupt) = py.detach(|| asked.filled(places))?;
    drop((x_place, v_place));
    if let Some(error) = interrupt {
        // The finished states become an attribute of the exception, if it accepts attributes.
        _ = error.value(py).setattr("trajectory", (x, v));
        return Err(error);
    }
    match absurd.filter(|_| check) {
        Some(robot) => Err(asked.diverged(robot)),
        None => Ok([x.into_any(), v.into_any()]),
    }
}

/// The gradients of [`pulled`](Asked::pulled): a row per robot.
pub(crate) fn gradients<'py, R: Number>(
    py: Python<'py>,
    kind: &Kind,
    arrays: &[Bound<'py, PyAny>],
    bars: [&Bound<'py, PyAny>; 2],
    span: Span,
    check: bool,
    by: u32,
) -> PyResult<Bound<'py, PyAny>> {
    let asked = read::<R>(kind, arrays, span)?;
    let [x, v] = bars.map(|bar| bar.extract::<PyReadonlyArrayDyn<R>>());
    let (x, v) = (x?, v?);
    let bars = [x.as_slice()?, v.as_slice()?];
    let products = py.detach(|| asked.pulled(bars, by))?;
    asked.rows(py, products, check)
}

/// For each robot one row: its positions, its velocities, and the tangents of both.
pub(crate) fn tangents<'py, R: Number>(
    py: Python<'py>,
    kind: &Kind,
    arrays: &[Bound<'py, PyAny>],
    along: &[Bound<'py, PyAny>],
    span: Span,
    check: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let asked = read::<R>(kind, arrays, span)?;
    let along = Arrays::read(along)?;
    let products = py.detach(|| asked.pushed(&along))?;
    asked.rows(py, products, check)
}

/// Applies a function to all robots, in groups if they can walk together.
fn products<R: Number>(
    robots: usize,
    together: bool,
    of: impl Fn(Range<usize>) -> Products<R> + Sync + Send,
) -> PyResult<Products<R>> {
    let all = |stop: &Stop| each(robots, group_size(robots, together), stop, of);
    let products = whole(in_pool(robots, all)?)?;
    Ok(products.into_iter().flatten().collect())
}

/// Writes numbers to their places.
fn set<T: Copy>(row: &mut [T], places: &[usize], numbers: &[T]) {
    for (&at, &number) in places.iter().zip(numbers) {
        row[at] = number;
    }
}

/// Returns an array of zeros, or NumPy's exception if there is no memory for it.
fn zeros<'py, R: Number>(py: Python<'py>, shape: &[usize]) -> PyResult<Bound<'py, PyArrayDyn<R>>> {
    let numpy = py.import("numpy")?;
    let made = numpy.call_method1("zeros", (PyTuple::new(py, shape)?, numpy::dtype::<R>(py)))?;
    Ok(made.cast_into()?)
}
