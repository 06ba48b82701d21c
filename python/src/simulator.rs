//! The class `Simulator`. Arrays from Python have an axis for robots in front.

use crate::arrays::{Sizes, array};
use crate::device::Device;
use crate::errors::{caught, raised};
use crate::kind::Kind;
use crate::rollouts::{self, Pair};
use crate::scene::Scene;
use autodiff_programs::CotangentBound;
use cosmic::design::{LayoutRules, Material, VolumeBounds, snap};
use cosmic::inputs::ALL;
use cosmic::lattice::SCALABLE;
use cosmic::projection::Projection;
use cosmic::scene::{self, VolumeSettings};
use cosmic::search::CoDesign;
use cosmic::world::Span;
use numpy::{PyArrayDyn, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;

/// Simulates robots on the lattice and in the world of a scene.
#[pyclass(frozen, module = "cosmic._core")]
pub(crate) struct Simulator {
    pub(crate) scene: scene::Scene,
    pub(crate) kind: Kind,
}

impl Simulator {
    /// The span of a gradient, with the memory that the scene allows. If it is `bounded`, cotangents are limited as the scene
    /// says.
    pub(crate) fn backwards(&self, span: Span, bounded: bool) -> Span {
        let (every, gradient) = (
            scene::GradientSettings::COTANGENT_EVERY,
            &self.scene.gradient,
        );
        let bound = gradient.cotangent_bound.filter(|_| bounded);
        Span {
            cotangent_bound: bound.map(|norm| CotangentBound { norm, every }),
            memory: gradient.budget(),
            ..span
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
            let world = codesign.world().clone();
            Ok(Self {
                kind: Kind::new(world, &scene.controller, on_gpu, projection),
                scene,
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
            Ok(Self {
                scene: self.scene.clone(),
                kind: self.kind.with_others(driven, changes, physics),
            })
        })
    }

    /// The arrays that change the physics: their names, values in the scene, and lengths. Factors have one number per edge or
    /// node; the length of the others is 0.
    #[getter]
    fn physics(&self) -> PyResult<Vec<(String, f64, usize)>> {
        caught(|| {
            let surroundings = self.kind.world.surroundings::<f64>();
            let numbers = surroundings
                .iter()
                .map(|(name, value)| (name.to_owned(), value, 0));
            let Sizes { edges, nodes, .. } = self.kind.sizes;
            let factors = SCALABLE.iter().zip([edges, edges, edges, nodes]);
            let factors = factors.map(|(name, count)| ((*name).to_owned(), 1.0, count));
            Ok(numbers.chain(factors).collect())
        })
    }

    /// How rows of `z` become a robot; `"auto"` until the first robot decides.
    #[getter]
    fn projection(&self) -> &str {
        self.kind.projection()
    }

    /// Decides the projection of a copy, as the first robots of the original did.
    fn decide(&self, projection: String) -> PyResult<()> {
        caught(|| {
            self.kind.decide(projection);
            Ok(())
        })
    }

    /// The point from which Python counts goals: the payload at the start, along the ground, in space across, and normal to
    /// the ground, in metres. `None` if goals are not inputs of a rollout.
    #[getter]
    fn goal_origin(&self) -> Option<Vec<f64>> {
        let Kind { world, sizes, .. } = &self.kind;
        let (lattice, ground) = (world.lattice(), world.ground());
        let origin = lattice.payload_point(&lattice.state_at_rest(), &ground);
        let origin = || sizes.dimension.list(origin);
        sizes.changes.is_some().then(origin)
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
        self.kind.sizes.shapes()
    }

    /// The nodes `[i, j]` of every edge, of shape `(edges, 2)`.
    #[getter]
    fn edges<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<i64>>> {
        let ends = self.kind.world.lattice().edges.as_flattened().iter();
        let ends = ends.map(|&node| node as i64).collect();
        array(py, ends, &[self.kind.sizes.edges, 2])
    }

    /// The rest length of every edge, in metres.
    #[getter]
    fn rest_length(&self) -> Vec<f64> {
        self.kind.world.lattice().rest_length.clone()
    }

    /// The node of the payload whose displacement counts.
    #[getter]
    fn payload(&self) -> usize {
        self.kind.world.lattice().payload[0].node
    }

    /// The unit vector along the ground, in which distances are measured.
    #[getter]
    fn along(&self) -> Vec<f64> {
        self.kind
            .sizes
            .dimension
            .list(self.kind.world.ground().tangent())
    }

    /// The corners of the ground, `[along, height]` in the frame of the ground line, m; none if the ground is that line.
    #[getter]
    fn terrain(&self) -> PyResult<Vec<[f64; 2]>> {
        caught(|| Ok(self.kind.world.physics().ground.resolved().pairs()))
    }

    /// Returns all numbers of the robot with which an optimisation with this seed starts.
    fn initial<'py>(&self, py: Python<'py>, seed: u64) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        caught(|| {
            let codesign = CoDesign::new(&self.scene).map_err(raised)?;
            let progress = codesign.begin(seed).map_err(raised)?;
            let numbers = codesign.inputs(&progress).get(ALL);
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
            let (scene, world) = (&self.scene, &self.kind.world);
            let rules = LayoutRules::new(world.lattice(), &scene.design);
            let bounds = VolumeBounds::widened(&scene.volume, VolumeSettings::WIDENING);
            let robots = z.as_slice()?.as_chunks().0.chunks(self.kind.sizes.edges);
            let snapped = robots.flat_map(|z| {
                let mixtures = world.projector().mixtures(Projection::Performance, z);
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
        let (kind, span) = (&self.kind, span(observed, first));
        caught(|| match is_single(&arrays) {
            true => rollouts::states::<f32>(py, kind, &arrays, span, check),
            false => rollouts::states::<f64>(py, kind, &arrays, span, check),
        })
    }

    /// Returns the cotangents of the arrays, given the cotangents of positions and velocities: a row per robot. `by` chooses
    /// the [`GRADIENTS`](crate::arrays::GRADIENTS). The others may be 0.
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
        let (kind, bars) = (&self.kind, [x_bar, v_bar]);
        caught(|| match is_single(&arrays) {
            true => rollouts::gradients::<f32>(py, kind, &arrays, bars, span, check, by),
            false => rollouts::gradients::<f64>(py, kind, &arrays, bars, span, check, by),
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
        let (kind, span) = (&self.kind, span(observed, first));
        caught(|| match is_single(&arrays) {
            true => rollouts::tangents::<f32>(py, kind, &arrays, &tangents, span, check),
            false => rollouts::tangents::<f64>(py, kind, &arrays, &tangents, span, check),
        })
    }
}
