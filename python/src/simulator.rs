//! Rollouts and their derivatives.

use crate::arrays::{Given, NAMES, Number, Sizes, array, behind};
use crate::asked::{Asked, each, in_pool, seen};
use crate::errors::{raised, refused};
use crate::scene::Scene;
use autodiff::CotangentBound;
use cosmic::codesign::CoDesign;
use cosmic::error::Error;
use cosmic::inputs::{ALL, Inputs};
use cosmic::scene;
use cosmic::simulator::Span;
use cosmic::task::Task;
use numpy::{PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;
use std::time::Instant;

/// A scene's lattice in its surroundings.
#[pyclass(frozen, module = "cosmic._core")]
pub(crate) struct Simulator {
    scene: scene::Scene,
    task: Task,
    sizes: Sizes,
}

/// Positions and velocities.
type Seen<'py> = [Bound<'py, PyAny>; 2];

impl Simulator {
    /// Checks steps and looks at them.
    fn span(&self, observed: Vec<usize>, first: usize) -> PyResult<Span> {
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
                "step {wanted} is beyond the scene's last, {planned}: set physics.steps higher"
            )));
        }
        Ok(Span {
            first,
            ..Span::from_start(observed)
        })
    }

    fn shape(&self, batch: Option<usize>, span: &Span) -> Vec<usize> {
        behind(batch, &[span.observed.len(), self.sizes.nodes, 2])
    }

    fn rollout_in<'py, R: Number>(
        &self,
        py: Python<'py>,
        arrays: &[Bound<'py, PyAny>],
        span: Span,
        projection: &str,
        check: bool,
    ) -> PyResult<Seen<'py>> {
        let asked = Asked::<R>::new(&self.sizes, arrays, span, projection)?;
        let shape = self.shape(asked.batch.size, &asked.span);
        // NumPy asks for large arrays in large pages, which cost a tenth of the others.
        let [x, v] = [(); 2].map(|()| PyArrayDyn::<R>::zeros(py, shape.clone(), false));
        let (mut x_place, mut v_place) = (x.readwrite(), v.readwrite());
        let places = [x_place.as_slice_mut()?, v_place.as_slice_mut()?];
        let work = || asked.fill(&self.task, places, check);
        let done = in_pool(py, asked.batch.robots(), work)?;
        done.map_err(|(robot, error)| match asked.batch.size {
            None => raised(error),
            Some(_) => of_robot(robot, error),
        })?;
        drop((x_place, v_place));
        Ok([x.into_any(), v.into_any()])
    }

    fn vjp_in<'py, R: Number>(
        &self,
        py: Python<'py>,
        arrays: &[Bound<'py, PyAny>],
        cotangents: [&Bound<'py, PyAny>; 2],
        span: Span,
        projection: &str,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let asked = Asked::<R>::new(&self.sizes, arrays, span, projection)?;
        let shape = self.shape(asked.batch.size, &asked.span);
        let [x_bar, v_bar] = [
            cotangent::<R>("x_bar", cotangents[0], &shape)?,
            cotangent::<R>("v_bar", cotangents[1], &shape)?,
        ];
        let robots = asked.batch.robots();
        let length = x_bar.len() / robots;
        let product = |robot: usize| {
            let part = |bar: &[R]| bar[robot * length..][..length].to_vec();
            let cotangents = [part(&x_bar), part(&v_bar)].concat();
            let mixing = asked.mixing[robot];
            let inputs = asked.batch.inputs(robot);
            let function = |inputs: &Inputs<_>| seen(&self.task, mixing, inputs, &asked.span);
            inputs.vjp(ALL, function, &cotangents).1
        };
        let gradients: Vec<Vec<R>> = in_pool(py, robots, || each(robots, product))?;
        let shapes = self.sizes.shapes();
        let mut begin = 0;
        let blocks = shapes.iter().map(|shape| {
            let length: usize = shape.iter().product();
            let block = begin..begin + length;
            begin += length;
            let numbers = gradients
                .iter()
                .flat_map(|gradient| &gradient[block.clone()]);
            let numbers: Vec<R> = numbers.copied().collect();
            Ok(array(py, numbers, &behind(asked.batch.size, shape))?.into_any())
        });
        blocks.collect()
    }

    fn jvp_in<'py, R: Number>(
        &self,
        py: Python<'py>,
        arrays: &[Bound<'py, PyAny>],
        tangents: &[Bound<'py, PyAny>],
        span: Span,
        projection: &str,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let asked = Asked::<R>::new(&self.sizes, arrays, span, projection)?;
        let along = Asked::<R>::new(&self.sizes, tangents, asked.span.clone(), "none")?;
        if along
            .batch
            .size
            .is_some_and(|size| Some(size) != asked.batch.size)
        {
            return Err(refused(
                "tangents: a batch, and the inputs are not one of that size".to_owned(),
            ));
        }
        let robots = asked.batch.robots();
        let product = |robot: usize| {
            let (mixing, inputs) = (asked.mixing[robot], asked.batch.inputs(robot));
            let tangents = along.batch.inputs(robot % along.batch.robots());
            inputs.jvp(&tangents, |inputs| {
                seen(&self.task, mixing, inputs, &asked.span)
            })
        };
        let products: Vec<(Vec<R>, Vec<R>)> = in_pool(py, robots, || each(robots, product))?;
        let shape = self.shape(asked.batch.size, &asked.span);
        let (values, slopes): (Vec<_>, Vec<_>) = products.into_iter().unzip();
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

fn of_robot(robot: usize, error: Error) -> PyErr {
    crate::errors::DivergedError::new_err(format!("robot {robot}: {}", error.within()))
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

/// True for arrays in single precision.
fn is_single(arrays: &[Bound<PyAny>]) -> PyResult<bool> {
    match arrays {
        [first, ..] if arrays.len() == NAMES.len() => Ok(first.cast::<PyArrayDyn<f32>>().is_ok()),
        _ => Err(refused(format!(
            "expected the {} arrays of Inputs",
            NAMES.len()
        ))),
    }
}

#[pymethods]
impl Simulator {
    /// Prepares rollouts of a scene's lattice.
    #[new]
    fn new(scene: &Scene) -> PyResult<Self> {
        let scene = scene.scene.clone();
        let codesign = CoDesign::new(&scene).map_err(raised)?;
        let task = codesign.task().clone();
        let sizes = Sizes::of(&task.lattice, &scene.controller);
        Ok(Self { scene, task, sizes })
    }

    /// Length of a step, s.
    #[getter]
    fn dt(&self) -> f64 {
        self.scene.physics.dt
    }

    /// The number of steps of a whole rollout.
    #[getter]
    fn steps(&self) -> usize {
        self.scene.physics.steps
    }

    /// The shapes of the arrays of `Inputs`, by their names.
    #[getter]
    fn shapes(&self) -> Vec<(&'static str, Vec<usize>)> {
        NAMES.into_iter().zip(self.sizes.shapes()).collect()
    }

    /// Nodes `[i, j]` of every edge, shape `(edges, 2)`.
    #[getter]
    fn edges<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<i64>>> {
        let ends = self.task.lattice.edges.as_flattened().iter();
        array(
            py,
            ends.map(|&node| node as i64).collect(),
            &[self.sizes.edges, 2],
        )
    }

    /// Rest length of every edge, m.
    #[getter]
    fn rest_length<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        array(
            py,
            self.task.lattice.rest_length.clone(),
            &[self.sizes.edges],
        )
    }

    /// The unit vector along the ground, in which distances are measured.
    #[getter]
    fn along(&self) -> [f64; 2] {
        self.task.ground().tangent()
    }

    /// The seven arrays that a seed starts from.
    fn initial<'py>(
        &self,
        py: Python<'py>,
        seed: u64,
    ) -> PyResult<Vec<Bound<'py, PyArrayDyn<f64>>>> {
        let codesign = CoDesign::new(&self.scene).map_err(raised)?;
        let progress = codesign.begin(seed).map_err(raised)?;
        let inputs = Inputs {
            z: progress.z,
            controller: progress.controller,
            start: self.task.lattice.state_at_rest(),
        };
        let blocks = ALL.iter().zip(self.sizes.shapes());
        blocks
            .map(|(&block, shape)| array(py, inputs.block(block).to_vec(), &shape))
            .collect()
    }

    /// Positions and velocities after the observed steps. `first` is the number of steps before the start.
    fn rollout<'py>(
        &self,
        py: Python<'py>,
        arrays: Vec<Bound<'py, PyAny>>,
        observed: Vec<usize>,
        first: usize,
        projection: &str,
        check: bool,
    ) -> PyResult<Seen<'py>> {
        let span = self.span(observed, first)?;
        if is_single(&arrays)? {
            self.rollout_in::<f32>(py, &arrays, span, projection, check)
        } else {
            self.rollout_in::<f64>(py, &arrays, span, projection, check)
        }
    }

    /// The least seconds, of so many rounds, that the library takes for the rollouts alone: what
    /// `benches/overhead.py` compares a call with.
    fn library_seconds<'py>(
        &self,
        py: Python<'py>,
        arrays: Vec<Bound<'py, PyAny>>,
        observed: Vec<usize>,
        rounds: usize,
    ) -> PyResult<f64> {
        let span = self.span(observed, 0)?;
        let asked = Asked::<f64>::new(&self.sizes, &arrays, span, "auto")?;
        let work = || {
            let seconds = (0..rounds).map(|_| {
                let began = Instant::now();
                std::hint::black_box(asked.rollouts(&self.task));
                began.elapsed().as_secs_f64()
            });
            seconds.fold(f64::INFINITY, f64::min)
        };
        in_pool(py, asked.batch.robots(), work)
    }

    /// The cotangents of the seven arrays, from those of positions and velocities.
    #[expect(clippy::too_many_arguments, reason = "the signature of Python")]
    fn vjp<'py>(
        &self,
        py: Python<'py>,
        arrays: Vec<Bound<'py, PyAny>>,
        x_bar: &Bound<'py, PyAny>,
        v_bar: &Bound<'py, PyAny>,
        observed: Vec<usize>,
        first: usize,
        projection: &str,
        bounded: bool,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let gradient = &self.scene.gradient;
        let every = gradient.cotangent_every;
        let bound = gradient.cotangent_bound.filter(|_| bounded);
        let span = Span {
            cotangent_bound: bound.map(|norm| CotangentBound { norm, every }),
            ..self.span(observed, first)?
        };
        if is_single(&arrays)? {
            self.vjp_in::<f32>(py, &arrays, [x_bar, v_bar], span, projection)
        } else {
            self.vjp_in::<f64>(py, &arrays, [x_bar, v_bar], span, projection)
        }
    }

    /// Positions, velocities, and the tangents of both along those of the seven arrays.
    fn jvp<'py>(
        &self,
        py: Python<'py>,
        arrays: Vec<Bound<'py, PyAny>>,
        tangents: Vec<Bound<'py, PyAny>>,
        observed: Vec<usize>,
        first: usize,
        projection: &str,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let span = self.span(observed, first)?;
        if is_single(&arrays)? && is_single(&tangents)? {
            self.jvp_in::<f32>(py, &arrays, &tangents, span, projection)
        } else {
            self.jvp_in::<f64>(py, &arrays, &tangents, span, projection)
        }
    }
}
