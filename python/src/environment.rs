//! Robots whose activations come from Python instead of a controller.

use crate::arrays::{array, flattened};
use crate::errors::{OutOfMemoryError, caught};
use crate::simulator::Simulator;
use crate::work::{each, group_size, in_pool, whole};
use cosmic::design::{Design, Material};
use cosmic::geometry::{Dimension, Vector};
use cosmic::lattice::{Body, Lattice, State};
use cosmic::outcome::DesignFile;
use cosmic::policy::{Controller, frequency, observation};
use cosmic::projection::Projection;
use cosmic::random::{Purpose, stream};
use cosmic::record::TrajectoryFile;
use cosmic::scene::{ControllerSettings, GoalKind};
use cosmic::world::{Effort, Robot, Span, Trajectory, draw_goals};
use cosmic_lab::report::{FRAME_WIDTH, RobotFiles};
use numpy::{PyArrayDyn, PyReadonlyArray2, PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::prelude::*;
use std::sync::Arc;

/// Robots of one design whose activations the caller supplies, without a controller.
#[pyclass(frozen, module = "cosmic._core")]
pub(crate) struct Driven {
    simulator: Py<Simulator>,
    /// How robots are observed.
    settings: ControllerSettings,
    materials: Vec<Material>,
    body: Arc<Body<f64>>,
}

type Floats<'py> = Bound<'py, PyArrayDyn<f64>>;

/// Reads the positions and velocities of robots.
fn states(
    dimension: Dimension,
    x: &PyReadonlyArray3<f64>,
    v: &PyReadonlyArray3<f64>,
) -> PyResult<Vec<State<f64>>> {
    let length = dimension.count() * x.shape()[1];
    let x = x.as_slice()?.chunks_exact(length);
    let pairs = x.zip(v.as_slice()?.chunks_exact(length));
    let states = pairs.map(|(x, v)| State::from_flat(dimension, [x, v]));
    Ok(states.collect())
}

/// These settings with other factors on the observation, so that its numbers are about 1: offsets are in units of half
/// the robot's extent at rest, velocities in units of the lattice's scale divided by its time scale, and a fixed goal in
/// units of its distance from the origin. A given goal is observed by a number below 1 with any factor.
fn scaled(mut settings: ControllerSettings, lattice: &Lattice) -> ControllerSettings {
    let extent = lattice
        .extent()
        .array()
        .iter()
        .fold(1.0_f64, |a, &b| a.max(b));
    settings.offset_scale = 2.0 / (extent * lattice.spacing);
    settings.velocity_scale = lattice.time_scale() / lattice.scale;
    let distance = settings.goal.norm();
    if settings.goals == GoalKind::Fixed && distance > 0.0 {
        settings.goal_scale = 1.0 / distance;
    }
    settings
}

#[pymethods]
impl Driven {
    /// Prepares robots from their design vectors, of shape `(edges, 3)`. If `is_scaled`, their observations have numbers
    /// of about 1; otherwise they are those of the scene's controller.
    #[new]
    fn new(simulator: Py<Simulator>, z: PyReadonlyArray2<f64>, is_scaled: bool) -> PyResult<Self> {
        let z = z.as_slice()?.as_chunks().0.to_vec();
        caught(|| {
            let Simulator { scene, kind } = simulator.get();
            let (world, settings) = (&kind.world, scene.controller.clone());
            let settings = match is_scaled {
                true => scaled(settings, world.lattice()),
                false => settings,
            };
            let materials = z.iter().map(Material::dominant).collect();
            let design = Design::of_vectors(z);
            let design = world
                .projector()
                .projected(Projection::Performance, &design);
            Ok(Self {
                body: Arc::new(world.body(&design)),
                simulator,
                settings,
                materials,
            })
        })
    }

    /// The indices of the edges that respond to activations.
    #[getter]
    fn actuators(&self) -> Vec<usize> {
        let body = &self.body;
        let strains = |&edge: &usize| body.strain[edge] * body.stiffness[edge] != 0.0;
        (0..body.strain.len()).filter(strains).collect()
    }

    /// The number of values in an observation.
    #[getter]
    fn inputs(&self) -> usize {
        let sizes = &self.simulator.get().kind.sizes;
        self.settings
            .observation_length(sizes.dimension, sizes.nodes)
    }

    /// The weight of each node in the shape of a robot, from 0 to 1: 0 for a node without a bar.
    #[getter]
    fn presence(&self) -> PyResult<Vec<f64>> {
        caught(|| {
            Ok(match &self.body.presence[..] {
                [] => vec![1.0; self.body.mass.len()],
                presence => presence.to_vec(),
            })
        })
    }

    /// Draws a sequence of goals as the scene's `[goals]` say. The first one is ahead or behind with equal probability,
    /// if the settings allow both. Returns the numbers of steps at which goals change, and the goals, an array of
    /// shape `(goals, 2)`, in space `(goals, 3)`.
    fn draw_goals<'py>(&self, py: Python<'py>, seed: u64) -> PyResult<(Vec<usize>, Floats<'py>)> {
        let Simulator { scene, kind } = self.simulator.get();
        let world = &kind.world;
        let (settings, ahead) = (&scene.goals, seed.is_multiple_of(2));
        let goals = caught(|| {
            let mut stream = stream(seed, Purpose::Errands);
            Ok(draw_goals(world, settings, ahead, &mut stream))
        })?;
        let dimension = world.lattice().dimension;
        let points = goals.iter().flat_map(|goal| dimension.components(goal));
        let changes = goals.later.iter().map(|&(steps, _)| steps).collect();
        let shape = [goals.later.len() + 1, dimension.count()];
        Ok((changes, array(py, points.collect(), &shape)?))
    }

    /// Returns the position of each robot's payload, or of the body that `objective.body` names, in the ground's frame, m: an
    /// array of shape `(robots, 2)`, in space `(robots, 3)`.
    fn places<'py>(&self, py: Python<'py>, x: PyReadonlyArray3<f64>) -> PyResult<Floats<'py>> {
        let world = &self.simulator.get().kind.world;
        let (ground, dimension) = (world.ground(), world.lattice().dimension);
        let rest = world.lattice().state_at_rest();
        let place = |state| ground.vector_to_ground(self.body.marker.place(&rest.x, state));
        let states = states(dimension, &x, &x)?;
        let places: Vec<Vector<f64>> = states.iter().map(place).collect();
        array(
            py,
            dimension.flat(&places),
            &[places.len(), dimension.count()],
        )
    }

    /// Simulates `steps` steps with constant activations, of shape `(robots, edges)`. `first` is the number of steps
    /// that the robots have done before. Returns positions and velocities, each of shape `(robots, nodes, 2)` (in space 3), a
    /// list that says for each robot whether it diverged, and the energy that its actuators gave, J. The energies are 0
    /// unless `is_metered`, which costs time.
    #[expect(clippy::too_many_arguments, reason = "the signature of Python")]
    fn advance<'py>(
        &self,
        py: Python<'py>,
        activations: PyReadonlyArray2<f64>,
        x: PyReadonlyArray3<f64>,
        v: PyReadonlyArray3<f64>,
        first: usize,
        steps: usize,
        is_metered: bool,
    ) -> PyResult<(Floats<'py>, Floats<'py>, Vec<bool>, Vec<f64>)> {
        let world = &self.simulator.get().kind.world;
        let (starts, robots) = (states(world.lattice().dimension, &x, &v)?, x.shape()[0]);
        let surroundings = Arc::new(world.surroundings());
        let held = activations.as_slice()?.chunks_exact(activations.shape()[1]);
        let robot = |(held, start): (&[f64], State<f64>)| Robot {
            body: Arc::clone(&self.body),
            controller: Arc::new(Controller::given(held.to_vec())),
            surroundings: Arc::clone(&surroundings),
            start,
        };
        let all: Vec<Robot<f64>> = held.zip(starts).map(robot).collect();
        let span = Span {
            first,
            metered: is_metered,
            ..Span::from_start(vec![steps])
        };
        let work = |stop: &_| {
            let size = group_size(robots, true);
            each(robots, size, stop, |robots| world.run(&all[robots], &span))
        };
        let seen = caught(|| whole(py.detach(|| in_pool(robots, work))?))?;
        let seen: Vec<Trajectory<f64>> = seen.into_iter().flatten().collect();
        let diverged = seen.iter().map(|seen| seen.states[0].is_absurd()).collect();
        let actuators = self.actuators();
        let given = |seen: &Trajectory<f64>| -> f64 {
            let effort = seen.efforts.as_ref().map(|efforts| &efforts.of_states[0]);
            let work = |effort: &Effort<f64>| actuators.iter().map(|&edge| effort.work[edge]).sum();
            effort.map_or(0.0, work)
        };
        let energy = seen.iter().map(given).collect();
        let [x, v] = flattened(&seen);
        let [nodes, axes] = self.simulator.get().kind.sizes.points();
        let shape = [robots, nodes, axes];
        Ok((
            array(py, x, &shape)?,
            array(py, v, &shape)?,
            diverged,
            energy,
        ))
    }

    /// Returns the observation of each robot, with the entries that the paper defines. `done` contains the number of
    /// steps that each robot has done. `goals` has each robot's goal if goals are inputs of a rollout.
    fn observe<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArray3<f64>,
        v: PyReadonlyArray3<f64>,
        done: Vec<usize>,
        goals: Option<Vec<Vec<f64>>>,
    ) -> PyResult<Floats<'py>> {
        let Simulator { scene, kind } = self.simulator.get();
        let world = &kind.world;
        let mut settings = self.settings.clone();
        let dimension = world.lattice().dimension;
        let (states, ground) = (states(dimension, &x, &v)?, world.ground());
        let goals = match goals {
            Some(goals) => {
                let goals = goals.iter();
                goals.map(|goal| dimension.vector(goal)).collect()
            }
            None => vec![settings.goal; states.len()],
        };
        let robots = states.iter().zip(done).zip(goals);
        let seen = robots.flat_map(|((state, done), goal)| {
            settings.goal = goal;
            // A robot without a controller has a clock of the scene's frequency.
            let phase = settings.omega * (done as f64 * scene.physics.dt);
            observation(&settings, phase, state, &self.body.presence, &ground)
        });
        array(py, seen.collect(), &[states.len(), self.inputs()])
    }

    /// Draws a robot in the last of the states `x`, which it has after these numbers of steps. Returns the picture, an
    /// array of shape `(rows, columns, 3)`.
    fn picture<'py>(
        &self,
        py: Python<'py>,
        steps: Vec<usize>,
        x: PyReadonlyArray3<f64>,
    ) -> PyResult<Bound<'py, PyArrayDyn<u8>>> {
        let Simulator { scene, kind } = self.simulator.get();
        let world = &kind.world;
        let lattice = world.lattice();
        let layout = Design::Layout(self.materials.clone());
        let controller = Controller::xavier(&scene.controller, lattice, 0);
        let robot = RobotFiles {
            scene: scene.clone(),
            lattice: lattice.clone(),
            design: DesignFile::new(lattice, &layout, &self.materials, &controller),
            omega: frequency(&scene.controller, &controller),
        };
        let trajectory = TrajectoryFile {
            dt: scene.physics.dt,
            steps,
            // A picture shows no velocities.
            states: states(lattice.dimension, &x, &x)?,
            bars: Vec::new(),
        };
        let last = trajectory.states.len() - 1;
        let draw = || cosmic_lab::report::frame(&robot, &trajectory, last);
        let drawn = caught(|| Ok(py.detach(draw)))?;
        let short = || OutOfMemoryError::new_err("there is not enough memory for the picture");
        let drawn = drawn.ok_or_else(short)?;
        let rows = drawn.len() / 3 / FRAME_WIDTH;
        array(py, drawn, &[rows, FRAME_WIDTH, 3])
    }
}
