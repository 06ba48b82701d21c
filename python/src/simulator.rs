//! Computes rollouts and their derivatives.

use crate::arrays::{Given, NAMES, Number, Sizes, array, behind};
use crate::asked::{Asked, Stop, each, ends_absurd, in_pool, seen, whole};
use crate::device::Device;
use crate::errors::{caught, of_class, raised, refused};
use crate::memory::{has_room, kept, simulator_fits, start_fits};
use crate::pool::usual_threads;
use crate::scene::Scene;
use autodiff::{CotangentBound, Dual};
use cosmic::codesign::CoDesign;
use cosmic::error::Error;
use cosmic::inputs::{ALL, Inputs};
use cosmic::scene;
use cosmic::simulator::Span;
use cosmic::task::Task;
use numpy::{PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::sync::Arc;
use std::time::Instant;

/// Simulates robots on the lattice and in the world of a scene.
#[pyclass(frozen, module = "cosmic._core")]
pub(crate) struct Simulator {
    scene: scene::Scene,
    task: Task,
    sizes: Sizes,
    /// Whether rollouts run on the GPU.
    on_gpu: bool,
}

/// Work for the GPU runs in the thread pool like that of several robots, so that signals are noticed.
const IN_POOL: usize = 2;

/// Two arrays: the observed positions and the observed velocities.
type Seen<'py> = [Bound<'py, PyAny>; 2];

impl Simulator {
    /// Checks that the scene has the observed steps of a rollout. They are counted from step `first`, at which the
    /// rollout starts.
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

    fn rollout_in<'py, R: Number>(
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

    fn vjp_in<'py, R: Number>(
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

    fn jvp_in<'py, R: Number>(
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

/// The payload at the start, in the frame of goals, m; `None` if goals are not inputs of a rollout.
pub(crate) fn goal_origin(task: &Task, sizes: &Sizes) -> Option<[f64; 2]> {
    let (lattice, ground) = (&task.lattice, task.ground());
    let origin = lattice.payload_point(&lattice.state_at_rest(), &ground);
    sizes.changes.is_some().then_some(origin.array())
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

/// True if the arrays are in single precision. The first array decides, because all have the same type. Goals may be
/// an eighth array.
fn is_single(arrays: &[Bound<PyAny>]) -> PyResult<bool> {
    match arrays {
        [first, ..] if [7, 8].contains(&arrays.len()) => {
            Ok(first.cast::<PyArrayDyn<f32>>().is_ok())
        }
        _ => Err(refused(format!(
            "expected the {} arrays of Inputs",
            NAMES.len()
        ))),
    }
}

#[pymethods]
impl Simulator {
    /// Prepares rollouts in a scene, on the GPU or on the processor.
    #[new]
    fn new(scene: &Scene, on_gpu: bool) -> PyResult<Self> {
        caught(|| {
            if on_gpu {
                Device::shared()?;
            }
            simulator_fits(&scene.scene)?;
            let mut scene = scene.scene.clone();
            // The arrays of a controller do not contain a tempo.
            scene.controller.clock = scene::ClockKind::Fixed;
            let codesign = CoDesign::new(&scene).map_err(raised)?;
            let task = codesign.task().clone();
            let sizes = Sizes::of(&task.lattice, &scene.controller);
            Ok(Self {
                scene,
                task,
                sizes,
                on_gpu,
            })
        })
    }

    /// Returns a simulator for rollouts in which the goal changes after these numbers of steps, which ascend. The goals
    /// are an eighth array, of shape `(goals, 2)`: along the ground and normal to it, m.
    fn with_changes(&self, changes: Vec<usize>) -> PyResult<Self> {
        caught(|| {
            let mut sizes = self.sizes.clone();
            let goals = vec![0.0; 2 + 2 * changes.len()];
            sizes.changes = Some(changes);
            Ok(Self {
                scene: self.scene.clone(),
                task: self.task.with_goals(&sizes.goals(&goals)),
                sizes,
                on_gpu: self.on_gpu,
            })
        })
    }

    /// The point from which Python counts goals: the payload at the start, along the ground and normal to it, in
    /// metres. `None` if goals are not inputs of a rollout.
    #[getter]
    fn goal_origin(&self) -> Option<[f64; 2]> {
        goal_origin(&self.task, &self.sizes)
    }

    /// The length of a time step, in seconds.
    #[getter]
    fn dt(&self) -> f64 {
        self.scene.physics.dt
    }

    /// The number of steps of a whole rollout.
    #[getter]
    fn steps(&self) -> usize {
        self.scene.physics.steps
    }

    /// The names of the arrays of `Inputs`, each with its shape.
    #[getter]
    fn shapes(&self) -> Vec<(&'static str, Vec<usize>)> {
        NAMES.into_iter().zip(self.sizes.shapes()).collect()
    }

    /// The nodes `[i, j]` of every edge, of shape `(edges, 2)`.
    #[getter]
    fn edges<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<i64>>> {
        let ends = self.task.lattice.edges.as_flattened().iter();
        array(
            py,
            ends.map(|&node| node as i64).collect(),
            &[self.sizes.edges, 2],
        )
    }

    /// The rest length of every edge, in metres.
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
        self.task.ground().tangent().array()
    }

    /// Returns the seven arrays with which an optimisation with this seed starts.
    fn initial<'py>(
        &self,
        py: Python<'py>,
        seed: u64,
    ) -> PyResult<Vec<Bound<'py, PyArrayDyn<f64>>>> {
        caught(|| {
            start_fits(&self.scene, &self.sizes, 3.0)?;
            let codesign = CoDesign::new(&self.scene).map_err(raised)?;
            let progress = codesign.begin(seed).map_err(raised)?;
            let inputs = codesign.evaluator().inputs(&progress).get(ALL);
            let arrays = self.sizes.split(&inputs).into_iter();
            let arrays = arrays.zip(self.sizes.shapes());
            arrays
                .map(|(numbers, shape)| array(py, numbers, &shape))
                .collect()
        })
    }

    /// Raises an exception if the scene has no rollout with these observed steps.
    fn check_span(&self, observed: Vec<usize>, first: usize) -> PyResult<()> {
        self.span(observed, first).map(drop)
    }

    /// Returns positions and velocities after each of the observed steps. `first` is the number of steps before the
    /// start.
    fn rollout<'py>(
        &self,
        py: Python<'py>,
        arrays: Vec<Bound<'py, PyAny>>,
        observed: Vec<usize>,
        first: usize,
        projection: &str,
        check: bool,
    ) -> PyResult<Seen<'py>> {
        caught(|| {
            let span = self.span(observed, first)?;
            if is_single(&arrays)? {
                self.rollout_in::<f32>(py, &arrays, span, projection, check)
            } else {
                self.rollout_in::<f64>(py, &arrays, span, projection, check)
            }
        })
    }

    /// Returns the time in seconds that the library takes for the rollouts, without the conversion from and to Python:
    /// the minimum of `rounds` rounds. `benches/overhead.py` compares it with the time of a call.
    fn library_seconds<'py>(
        &self,
        py: Python<'py>,
        arrays: Vec<Bound<'py, PyAny>>,
        observed: Vec<usize>,
        rounds: usize,
    ) -> PyResult<f64> {
        let span = self.span(observed, 0)?;
        let asked = Asked::<f64>::new(&self.sizes, &arrays, span, "auto")?;
        let work = |_: &Stop| {
            let seconds = (0..rounds).map(|_| {
                let began = Instant::now();
                std::hint::black_box(asked.rollouts(&self.task));
                began.elapsed().as_secs_f64()
            });
            seconds.fold(f64::INFINITY, f64::min)
        };
        caught(|| whole(in_pool(py, asked.batch.robots(), work)?))
    }

    /// Returns the cotangents of the seven arrays, given the cotangents of positions and velocities.
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
        check: bool,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let gradient = &self.scene.gradient;
        let every = gradient.cotangent_every;
        let bound = gradient.cotangent_bound.filter(|_| bounded);
        let bars = [x_bar, v_bar];
        caught(|| {
            let span = Span {
                cotangent_bound: bound.map(|norm| CotangentBound { norm, every }),
                ..self.span(observed, first)?
            };
            if is_single(&arrays)? {
                self.vjp_in::<f32>(py, &arrays, bars, span, projection, check)
            } else {
                self.vjp_in::<f64>(py, &arrays, bars, span, projection, check)
            }
        })
    }

    /// Returns positions and velocities, and the tangents of both, given the tangents of the seven arrays.
    #[expect(clippy::too_many_arguments, reason = "the signature of Python")]
    fn jvp<'py>(
        &self,
        py: Python<'py>,
        arrays: Vec<Bound<'py, PyAny>>,
        tangents: Vec<Bound<'py, PyAny>>,
        observed: Vec<usize>,
        first: usize,
        projection: &str,
        check: bool,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        caught(|| {
            let span = self.span(observed, first)?;
            let is_single = [is_single(&arrays)?, is_single(&tangents)?] == [true, true];
            if is_single {
                self.jvp_in::<f32>(py, &arrays, &tangents, span, projection, check)
            } else {
                self.jvp_in::<f64>(py, &arrays, &tangents, span, projection, check)
            }
        })
    }
}
