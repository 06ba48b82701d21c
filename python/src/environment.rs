//! Robots whose activations come from Python instead of a controller.

use crate::arrays::{array, flattened};
use crate::errors::{OutOfMemoryError, caught, unlocked};
use crate::simulator::Simulator;
use crate::work::{each, group_size, in_pool, whole};
use cosmic::design::{Design, Material};
use cosmic::geometry::Dimension;
use cosmic::lattice::{Body, Lattice, State};
use cosmic::outcome::DesignFile;
use cosmic::policy::{Controller, frequency, observation};
use cosmic::projection::Projection;
use cosmic::random::{Purpose, stream};
use cosmic::record::TrajectoryFile;
use cosmic::scene::{ControllerSettings, GoalKind};
use cosmic::world::{Effort, Robot, Span, Surroundings, Trajectory, World, draw_goals};
use cosmic_lab::report::{FRAME_WIDTH, RobotFiles, write_animation};
use numpy::{PyArrayDyn, PyReadonlyArray2, PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::prelude::*;
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

/// Robots whose activations the caller supplies, without a controller.
#[pyclass(module = "cosmic._core")]
pub(crate) struct Driven {
    simulator: Py<Simulator>,
    /// How robots are observed.
    settings: ControllerSettings,
    /// The designs. Robot `k` has the design `k`, or all robots share a single one.
    designs: Vec<Designed>,
    /// The bodies of all robots in their surroundings, with the physics that each robot has.
    robots: Vec<Placed>,
}

/// A body in its surroundings.
type Placed = (Arc<Body<f64>>, Arc<Surroundings<f64>>);

/// A design of [`Driven`] robots, with the body that it has with the physics of the scene.
struct Designed {
    materials: Vec<Material>,
    body: Arc<Body<f64>>,
    /// The edges that respond to activations.
    actuators: Vec<usize>,
}

impl Designed {
    fn new(world: &World, z: &[[f64; 3]]) -> Self {
        let materials = z.iter().map(Material::dominant).collect();
        let design = Design::of_vectors(z.to_vec());
        let design = world
            .projector()
            .projected(Projection::Performance, &design);
        let body = world.body(&design);
        let responds = |&edge: &usize| body.strain[edge] * body.stiffness[edge] != 0.0;
        Self {
            materials,
            actuators: (0..body.strain.len()).filter(responds).collect(),
            body: Arc::new(body),
        }
    }
}

impl Driven {
    fn design(&self, robot: usize) -> &Designed {
        &self.designs[robot % self.designs.len()]
    }
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
    /// Prepares robots from design vectors of shape `(designs, edges, 3)`, with a design for each robot or one for all. If
    /// `is_scaled`, their observations have numbers of about 1; otherwise they are those of the scene's controller.
    #[new]
    fn new(
        simulator: Py<Simulator>,
        z: PyReadonlyArray3<f64>,
        robots: usize,
        is_scaled: bool,
    ) -> PyResult<Self> {
        let edges = z.shape()[1];
        let z = z.as_slice()?.as_chunks().0.chunks_exact(edges);
        caught(|| {
            let Simulator { scene, kind } = simulator.get();
            let (world, settings) = (&kind.world, scene.controller.clone());
            let designs: Vec<_> = z.map(|z| Designed::new(world, z)).collect();
            let surroundings = Arc::new(world.surroundings());
            let bodies = designs.iter().cycle().take(robots);
            let robot = |design: &Designed| (Arc::clone(&design.body), Arc::clone(&surroundings));
            Ok(Self {
                robots: bodies.map(robot).collect(),
                designs,
                settings: match is_scaled {
                    true => scaled(settings, world.lattice()),
                    false => settings,
                },
                simulator,
            })
        })
    }

    /// Gives a robot other physics: numbers of its surroundings, or factors of its body, by name. Numbers without a name here
    /// are those of the scene.
    fn vary(&mut self, robot: usize, physics: Vec<(String, Vec<f64>)>) -> PyResult<()> {
        caught(|| {
            let world = &self.simulator.get().kind.world;
            let mut body = Body::clone(&self.design(robot).body);
            let mut surroundings = world.surroundings();
            for (name, numbers) in &physics {
                if !body.scale(name, numbers, &world.lattice().rest_length) {
                    surroundings = surroundings.with(name, numbers[0]);
                }
            }
            self.robots[robot] = (Arc::new(body), Arc::new(surroundings));
            Ok(())
        })
    }

    /// The indices of the edges that respond to activations in any of the designs.
    #[getter]
    fn actuators(&self) -> Vec<usize> {
        let edges = self.designs.iter().flat_map(|design| &design.actuators);
        edges
            .copied()
            .collect::<BTreeSet<_>>()
            .into_iter()
            .collect()
    }

    /// The number of values in an observation.
    #[getter]
    fn inputs(&self) -> usize {
        let sizes = &self.simulator.get().kind.sizes;
        self.settings
            .observation_length(sizes.dimension, sizes.nodes)
    }

    /// The weight of each node in the shape of each robot, from 0 to 1: 0 for a node without a bar.
    #[getter]
    fn presence(&self) -> PyResult<Vec<Vec<f64>>> {
        let of_body = |body: &Body<f64>| match &body.presence[..] {
            [] => vec![1.0; body.mass.len()],
            presence => presence.to_vec(),
        };
        caught(|| Ok(self.robots.iter().map(|(body, _)| of_body(body)).collect()))
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
        let states = states(dimension, &x, &x)?;
        let robots = states.iter().zip(&self.robots);
        let places = robots.map(|(state, (body, _))| body.marker.place(&rest.x, state));
        let places: Vec<_> = places.map(|place| ground.vector_to_ground(place)).collect();
        array(
            py,
            dimension.flat(&places),
            &[places.len(), dimension.count()],
        )
    }

    /// Simulates `steps` steps of the robots with the indices `which`, with constant activations of shape
    /// `(robots, edges)`. `first` is the number of steps that the robots have done before. Returns positions and velocities, each of shape `(robots, nodes, 2)` (in space 3), a
    /// list that says for each robot whether it diverged, and the energy that its actuators gave, J. The energies are 0
    /// unless `is_metered`, which costs time.
    #[expect(clippy::too_many_arguments, reason = "the signature of Python")]
    fn advance<'py>(
        &self,
        py: Python<'py>,
        which: Vec<usize>,
        activations: PyReadonlyArray2<f64>,
        x: PyReadonlyArray3<f64>,
        v: PyReadonlyArray3<f64>,
        first: usize,
        steps: usize,
        is_metered: bool,
    ) -> PyResult<(Floats<'py>, Floats<'py>, Vec<bool>, Vec<f64>)> {
        let world = &self.simulator.get().kind.world;
        let (starts, robots) = (states(world.lattice().dimension, &x, &v)?, which.len());
        let held = activations.as_slice()?.chunks_exact(activations.shape()[1]);
        let robot = |((&robot, held), start): ((&usize, &[f64]), State<f64>)| {
            let (body, surroundings) = &self.robots[robot];
            Robot {
                body: Arc::clone(body),
                controller: Arc::new(Controller::given(held.to_vec())),
                surroundings: Arc::clone(surroundings),
                start,
            }
        };
        let all: Vec<Robot<f64>> = which.iter().zip(held).zip(starts).map(robot).collect();
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
        let given = |(seen, &robot): (&Trajectory<f64>, &usize)| -> f64 {
            let effort = seen.efforts.as_ref().map(|efforts| &efforts.of_states[0]);
            let actuators = self.design(robot).actuators.iter();
            let work = |effort: &Effort<f64>| actuators.map(|&edge| effort.work[edge]).sum();
            effort.map_or(0.0, work)
        };
        let energy = seen.iter().zip(&which).map(given).collect();
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
        let robots = states.iter().zip(done).zip(goals).zip(&self.robots);
        let seen = robots.flat_map(|(((state, done), goal), (body, _))| {
            settings.goal = goal;
            // A robot without a controller has a clock of the scene's frequency.
            let phase = settings.omega * (done as f64 * scene.physics.dt);
            observation(&settings, phase, state, &body.presence, &ground)
        });
        array(py, seen.collect(), &[states.len(), self.inputs()])
    }

    /// Draws robot `robot` in the last of the states `x`, which it has after these numbers of steps. Returns the picture, an
    /// array of shape `(rows, columns, 3)`.
    fn picture<'py>(
        &self,
        py: Python<'py>,
        robot: usize,
        steps: Vec<usize>,
        x: PyReadonlyArray3<f64>,
    ) -> PyResult<Bound<'py, PyArrayDyn<u8>>> {
        let simulator = self.simulator.get();
        let materials = &self.design(robot).materials;
        let robot = drawable(simulator, &Design::Layout(materials.clone()), materials);
        let trajectory = motion(simulator, steps, &x)?;
        let last = trajectory.states.len() - 1;
        let draw = || cosmic_lab::report::frame(&robot, &trajectory, last);
        let drawn = caught(|| Ok(py.detach(draw)))?;
        let short = || OutOfMemoryError::new_err("there is not enough memory for the picture");
        let drawn = drawn.ok_or_else(short)?;
        let rows = drawn.len() / 3 / FRAME_WIDTH;
        array(py, drawn, &[rows, FRAME_WIDTH, 3])
    }
}

/// A robot of a simulator as the files of a run describe it. Pictures show no controller, so any one will do.
fn drawable(
    simulator: &Simulator,
    design: &Design<[f64; 3]>,
    materials: &[Material],
) -> RobotFiles {
    let Simulator { scene, kind } = simulator;
    let lattice = kind.world.lattice();
    let controller = Controller::xavier(&scene.controller, lattice, 0);
    RobotFiles {
        scene: scene.clone(),
        lattice: lattice.clone(),
        design: DesignFile::new(lattice, design, materials, &controller),
        omega: frequency(&scene.controller, &controller),
    }
}

/// The positions `x` after these numbers of steps as the file of a run. Pictures show no velocities.
fn motion(
    simulator: &Simulator,
    steps: Vec<usize>,
    x: &PyReadonlyArray3<f64>,
) -> PyResult<TrajectoryFile> {
    Ok(TrajectoryFile {
        dt: simulator.scene.physics.dt,
        steps,
        states: states(simulator.kind.world.lattice().dimension, x, x)?,
        bars: Vec::new(),
    })
}

/// Writes the motion of a robot with the rows `z` as a GIF. The robot has the positions `x` after these numbers of steps.
#[pyfunction]
pub(crate) fn animate(
    py: Python,
    simulator: &Bound<Simulator>,
    path: PathBuf,
    z: PyReadonlyArray2<f64>,
    steps: Vec<usize>,
    x: PyReadonlyArray3<f64>,
) -> PyResult<()> {
    let z = z.as_slice()?.as_chunks().0.to_vec();
    let materials: Vec<_> = z.iter().map(Material::dominant).collect();
    let robot = drawable(simulator.get(), &Design::of_vectors(z), &materials);
    let trajectory = motion(simulator.get(), steps, &x)?;
    unlocked(py, || write_animation(&path, &robot, &trajectory).map(drop))
}
