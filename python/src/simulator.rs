//! The class `Simulator`. Arrays from Python have an axis for robots in front.

use crate::arrays::{Number, Others, Sizes, array};
use crate::device::Device;
use crate::errors::{InputError, caught, raised};
use crate::rollouts::Pair;
use crate::scene::Scene;
use autodiff_programs::CotangentBound;
use cosmic::design::{LayoutRules, Material, VolumeBounds, snap};
use cosmic::inputs::ALL;
use cosmic::lattice::FACTORS;
use cosmic::projection::Projection;
use cosmic::scene::{self, VolumeSettings};
use cosmic::search::CoDesign;
use cosmic::world::Span;
use cosmic::world::Task;
use numpy::{PyArrayDyn, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;
use std::sync::{Arc, OnceLock};

/// Simulates robots on the lattice and in the world of a scene.
#[pyclass(frozen, module = "cosmic._core")]
pub(crate) struct Simulator {
    pub(crate) scene: scene::Scene,
    pub(crate) task: Task,
    pub(crate) sizes: Sizes,
    /// Whether rollouts run on the GPU.
    pub(crate) on_gpu: bool,
    /// Whether the first robots choose the projection.
    is_automatic: bool,
    projection: Arc<OnceLock<String>>,
}

impl Simulator {
    /// The span of a gradient. If it is `bounded`, cotangents are limited as the scene says.
    pub(crate) fn backwards(&self, span: Span, bounded: bool) -> Span {
        let every = scene::GradientSettings::COTANGENT_EVERY;
        let bound = self.scene.gradient.cotangent_bound.filter(|_| bounded);
        Span {
            cotangent_bound: bound.map(|norm| CotangentBound { norm, every }),
            ..span
        }
    }

    /// The projection of robots with these numbers `z`, which all robots may share. The first call decides what `"auto"`
    /// is. The robots that are `lost` do not count, because their inputs are not finite.
    pub(crate) fn projection_of<R: Number>(&self, z: &[R], lost: &[bool]) -> PyResult<&str> {
        let rows = z.as_chunks().0.iter();
        let rows: Vec<[f64; 3]> = rows.map(|row: &[R; 3]| row.map(Into::into)).collect();
        let is_chosen = |row: &[f64; 3]| {
            row.iter().all(|&share| share == 0.0 || share == 1.0) && row.iter().sum::<f64>() == 1.0
        };
        if self.is_automatic {
            let robots = rows.chunks(self.sizes.edges);
            let finished: Vec<bool> = robots.map(|rows| rows.iter().all(is_chosen)).collect();
            let counted = (0..lost.len()).filter(|&robot| !lost[robot]);
            let counted: Vec<bool> = counted
                .map(|robot| finished[robot % finished.len()])
                .collect();
            let Some(&is_finished) = counted.first() else {
                return Ok(self.projection.get().map_or("performance", String::as_str));
            };
            if counted.contains(&!is_finished) {
                return Err(InputError::new_err(
                    "z: the batch has finished robots, whose rows are zeros and ones, and others; simulate them with \
                     two simulators",
                ));
            }
            let own = if is_finished { "layout" } else { "performance" };
            let projection = self.projection.get_or_init(|| own.to_owned());
            if is_finished && projection != "layout" {
                return Err(InputError::new_err(
                    "z: this is a finished robot, and the first robots of this simulator were design vectors; use \
                     another simulator, or choose the projection, for example Simulator(scene, \"layout\")",
                ));
            }
        }
        let projection = self.projection();
        let is_vague = |row: &&[f64; 3]| !row.iter().any(|&share| share > 0.5);
        match rows.iter().find(is_vague) {
            Some(row) if projection == "layout" => Err(InputError::new_err(format!(
                "z: a row is {row:?}; this simulator is for finished robots (projection=\"layout\"), so one number of \
                 every row must be above 0.5; use another Simulator for other designs"
            ))),
            _ => Ok(projection),
        }
    }
}

/// The rollout that starts after `first` steps and is observed after `observed` further steps.
pub(crate) fn span(observed: Vec<usize>, first: usize) -> Span {
    Span {
        first,
        ..Span::from_start(observed)
    }
}

/// True if the arrays are in single precision. All of them have the same type.
fn is_single(arrays: &[Bound<PyAny>]) -> bool {
    arrays[0].cast::<PyArrayDyn<f32>>().is_ok()
}

#[pymethods]
impl Simulator {
    /// Prepares rollouts in a scene, on the GPU or on the processor.
    #[new]
    fn new(scene: &Scene, on_gpu: bool, projection: String) -> PyResult<Self> {
        caught(|| {
            if on_gpu {
                Device::shared()?;
            }
            let scene = scene.scene.clone();
            let codesign = CoDesign::new(&scene).map_err(raised)?;
            let task = codesign.task().clone();
            Ok(Self {
                sizes: Sizes::of(&task.lattice, &scene.controller),
                scene,
                task,
                on_gpu,
                is_automatic: projection == "auto",
                projection: Arc::new(match &*projection {
                    "auto" => OnceLock::new(),
                    _ => OnceLock::from(projection),
                }),
            })
        })
    }

    /// Returns a simulator whose robots have these arrays besides those of [`shapes`](Self::shapes), in this order:
    ///
    /// - If `driven` is a number of steps, activations of shape `(robots, driven, edges)`, in place of a controller.
    /// - If `changes` is given, goals of shape `(robots, goals, 2)`, along the ground and normal to it, m; in space 3, with
    ///   across between them. The goal changes after these numbers of steps, which ascend.
    /// - The arrays `physics`, which are names with lengths.
    fn with_others(
        &self,
        driven: Option<usize>,
        changes: Option<Vec<usize>>,
        physics: Vec<(String, usize)>,
    ) -> PyResult<Self> {
        caught(|| {
            let (mut sizes, mut task) = (self.sizes.clone(), self.task.clone());
            if driven.is_some() {
                sizes.blocks.clear();
            }
            let axes = sizes.dimension.count();
            let goals = changes
                .as_ref()
                .map_or(0, |changes| axes * (1 + changes.len()));
            if let Some(changes) = changes {
                sizes.changes = Some(changes);
                task = task.with_goals(&sizes.goals(&vec![0.0; goals]));
            }
            sizes.others = Others {
                driven,
                goals,
                physics,
            };
            Ok(Self {
                scene: self.scene.clone(),
                task,
                sizes,
                on_gpu: self.on_gpu,
                is_automatic: self.is_automatic,
                projection: Arc::clone(&self.projection),
            })
        })
    }

    /// The arrays that change the physics: their names, values in the scene, and lengths. Factors have one number per edge or
    /// node; the length of the others is 0.
    #[getter]
    fn physics(&self) -> PyResult<Vec<(String, f64, usize)>> {
        caught(|| {
            let surroundings = self.task.simulator.surroundings::<f64>();
            let numbers = surroundings.iter();
            let numbers = numbers.filter(|(name, _)| !name.starts_with("goal."));
            let numbers = numbers.map(|(name, value)| (name.to_owned(), value, 0));
            let Sizes { edges, nodes, .. } = self.sizes;
            let factors = FACTORS.iter().zip([edges, edges, edges, nodes]);
            let factors = factors.map(|(name, count)| ((*name).to_owned(), 1.0, count));
            Ok(numbers.chain(factors).collect())
        })
    }

    /// How rows of `z` become a robot; `"auto"` until the first robot decides.
    #[getter]
    fn projection(&self) -> &str {
        self.projection.get().map_or("auto", String::as_str)
    }

    /// Decides the projection of a copy, as the first robots of the original did.
    fn decide(&self, projection: String) -> PyResult<()> {
        caught(|| {
            self.projection.get_or_init(|| projection);
            Ok(())
        })
    }

    /// The point from which Python counts goals: the payload at the start, along the ground, in space across, and normal to
    /// the ground, in metres. `None` if goals are not inputs of a rollout.
    #[getter]
    fn goal_origin(&self) -> Option<Vec<f64>> {
        let (lattice, ground) = (&self.task.lattice, self.task.ground());
        let origin = lattice.payload_point(&lattice.state_at_rest(), &ground);
        let origin = || self.sizes.dimension.list(origin);
        self.sizes.changes.is_some().then(origin)
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

    /// The names of the arrays of a robot, each with its shape.
    #[getter]
    fn shapes(&self) -> Vec<(&'static str, Vec<usize>)> {
        self.sizes.shapes()
    }

    /// The nodes `[i, j]` of every edge, of shape `(edges, 2)`.
    #[getter]
    fn edges<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<i64>>> {
        let ends = self.task.lattice.edges.as_flattened().iter();
        let ends = ends.map(|&node| node as i64).collect();
        array(py, ends, &[self.sizes.edges, 2])
    }

    /// The rest length of every edge, in metres.
    #[getter]
    fn rest_length(&self) -> Vec<f64> {
        self.task.lattice.rest_length.clone()
    }

    /// The node of the payload whose displacement counts.
    #[getter]
    fn payload(&self) -> usize {
        self.task.lattice.payload[0].node
    }

    /// The unit vector along the ground, in which distances are measured.
    #[getter]
    fn along(&self) -> Vec<f64> {
        self.sizes.dimension.list(self.task.ground().tangent())
    }

    /// Returns all numbers of the robot with which an optimisation with this seed starts.
    fn initial<'py>(&self, py: Python<'py>, seed: u64) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        caught(|| {
            let codesign = CoDesign::new(&self.scene).map_err(raised)?;
            let progress = codesign.begin(seed).map_err(raised)?;
            let numbers = codesign.evaluator().inputs(&progress).get(ALL);
            let shape = [1, numbers.len()];
            array(py, numbers, &shape)
        })
    }

    /// Snaps design vectors to layouts, as an optimisation does. Both have the shape `(robots, edges, 3)`; the rows of a
    /// layout are one-hot.
    fn layouts<'py>(
        &self,
        py: Python<'py>,
        z: PyReadonlyArrayDyn<'py, f64>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        caught(|| {
            let (scene, task) = (&self.scene, &self.task);
            let rules = LayoutRules::new(&task.lattice, &scene.design);
            let bounds = VolumeBounds::widened(&scene.volume, VolumeSettings::WIDENING);
            let robots = z.as_slice()?.as_chunks().0.chunks(self.sizes.edges);
            let snapped = robots.flat_map(|z| {
                let mixtures = task.projector.mixtures(Projection::Performance, z);
                snap(&mixtures, &bounds, &rules)
            });
            array(py, snapped.flat_map(Material::one_hot).collect(), z.shape())
        })
    }

    /// Returns positions and velocities after each of the observed steps. `first` is the number of steps before the
    /// start.
    fn rollout<'py>(
        &self,
        py: Python<'py>,
        arrays: Vec<Bound<'py, PyAny>>,
        observed: Vec<usize>,
        first: usize,
        check: bool,
    ) -> PyResult<Pair<'py>> {
        let span = span(observed, first);
        caught(|| match is_single(&arrays) {
            true => self.rollout_in::<f32>(py, &arrays, span, check),
            false => self.rollout_in::<f64>(py, &arrays, span, check),
        })
    }

    /// Returns the cotangents of the arrays, given the cotangents of positions and velocities: a row per robot. `by` chooses
    /// the [`GRADIENTS`](crate::rollouts::GRADIENTS). The others may be 0.
    #[expect(clippy::too_many_arguments, reason = "the signature of Python")]
    fn vjp<'py>(
        &self,
        py: Python<'py>,
        arrays: Vec<Bound<'py, PyAny>>,
        x_bar: &Bound<'py, PyAny>,
        v_bar: &Bound<'py, PyAny>,
        observed: Vec<usize>,
        first: usize,
        bounded: bool,
        check: bool,
        by: u32,
    ) -> PyResult<Bound<'py, PyAny>> {
        let span = self.backwards(span(observed, first), bounded);
        let bars = [x_bar, v_bar];
        caught(|| match is_single(&arrays) {
            true => self.vjp_in::<f32>(py, &arrays, bars, span, check, by),
            false => self.vjp_in::<f64>(py, &arrays, bars, span, check, by),
        })
    }

    /// Returns positions and velocities, and the tangents of both, given the tangents of the arrays: a row per robot.
    fn jvp<'py>(
        &self,
        py: Python<'py>,
        arrays: Vec<Bound<'py, PyAny>>,
        tangents: Vec<Bound<'py, PyAny>>,
        observed: Vec<usize>,
        first: usize,
        check: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let span = span(observed, first);
        caught(|| match is_single(&arrays) {
            true => self.jvp_in::<f32>(py, &arrays, &tangents, span, check),
            false => self.jvp_in::<f64>(py, &arrays, &tangents, span, check),
        })
    }
}
