//! Computes rollouts and their derivatives.

use crate::arrays::{NAMES, Seen, Sizes, array};
use crate::asked::{Asked, Stop, in_pool, whole};
use crate::device::Device;
use crate::errors::{caught, raised, refused};
use crate::memory::{simulator_fits, start_fits};
use crate::scene::Scene;
use autodiff::CotangentBound;
use cosmic::codesign::CoDesign;
use cosmic::inputs::ALL;
use cosmic::scene;
use cosmic::simulator::Span;
use cosmic::task::Task;
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use std::time::Instant;

/// Simulates robots on the lattice and in the world of a scene.
#[pyclass(frozen, module = "cosmic._core")]
pub(crate) struct Simulator {
    pub(crate) scene: scene::Scene,
    pub(crate) task: Task,
    pub(crate) sizes: Sizes,
    /// Whether rollouts run on the GPU.
    pub(crate) on_gpu: bool,
}

/// The payload at the start, in the frame of goals, m; `None` if goals are not inputs of a rollout.
pub(crate) fn goal_origin(task: &Task, sizes: &Sizes) -> Option<[f64; 2]> {
    let (lattice, ground) = (&task.lattice, task.ground());
    let origin = lattice.payload_point(&lattice.state_at_rest(), &ground);
    sizes.changes.is_some().then_some(origin.array())
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
        let every = scene::GradientSettings::COTANGENT_EVERY;
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
