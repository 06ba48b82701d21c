//! Robots whose activations come from Python instead of a controller.

use crate::arrays::{Given, Sizes, array, flattened};
use crate::asked::{Stop, in_groups, in_pool, whole};
use crate::errors::{caught, raised, refused};
use crate::memory::simulator_fits;
use crate::scene::Scene;
use crate::simulator::goal_origin;
use cosmic::codesign::CoDesign;
use cosmic::design::Design;
use cosmic::domain::draw_goals;
use cosmic::geometry::{Ground, flat, from_flat};
use cosmic::lattice::{Body, State};
use cosmic::policy::observation;
use cosmic::projection::Projection;
use cosmic::random::{Purpose, stream};
use cosmic::scene::{ControllerSettings, GoalsSettings, PhysicsSettings};
use cosmic::simulator::{Span, Trajectory};
use cosmic::task::Task;
use numpy::PyArrayDyn;
use pyo3::prelude::*;

/// A robot whose activations the caller supplies, without a controller.
#[pyclass(frozen, module = "cosmic._core")]
pub(crate) struct Driven {
    body: Body<f64>,
    ground: Ground,
    physics: PhysicsSettings,
    settings: ControllerSettings,
    task: Task,
    goals: GoalsSettings,
    rest: State<f64>,
    sizes: Sizes,
    actuators: Vec<usize>,
}

type Floats<'py> = Bound<'py, PyArrayDyn<f64>>;

impl Driven {
    /// Reads the states of several robots.
    fn states(&self, x: &Bound<PyAny>, v: &Bound<PyAny>) -> PyResult<Vec<State<f64>>> {
        let shape = [self.sizes.nodes, 2];
        let [x, v] = [Given::<f64>::new("x", x)?, Given::<f64>::new("v", v)?];
        let robots = x.batch(&shape)?;
        if robots.is_none() || v.batch(&shape)? != robots {
            return Err(refused(
                "x, v: both must have the shape (robots, nodes, 2)".to_owned(),
            ));
        }
        let length = 2 * self.sizes.nodes;
        let pairs = x
            .finite()?
            .chunks_exact(length)
            .zip(v.finite()?.chunks_exact(length));
        let state = |(x, v): (&[f64], &[f64])| State {
            x: from_flat(x),
            v: from_flat(v),
        };
        Ok(pairs.map(state).collect())
    }
}

#[pymethods]
impl Driven {
    /// Prepares a robot from its design vectors, of shape `(edges, 3)`.
    #[new]
    fn new(scene: &Scene, z: &Bound<PyAny>) -> PyResult<Self> {
        simulator_fits(&scene.scene)?;
        let codesign = caught(|| CoDesign::new(&scene.scene).map_err(raised))?;
        let task = codesign.task();
        let (scene, lattice) = (&scene.scene, &task.lattice);
        let sizes = Sizes::of(lattice, &scene.controller);
        let z = Given::<f64>::new("z", z)?;
        if z.batch(&[sizes.edges, 3])?.is_some() {
            return Err(refused(
                "z: expected the design of one robot, of shape (edges, 3), found several"
                    .to_owned(),
            ));
        }
        let design = Design::of_vectors(z.finite()?.as_chunks().0.to_vec());
        let body = task.body(&task.projected(Projection::Performance, &design));
        let strains = |&edge: &usize| body.strain[edge] * body.stiffness[edge] != 0.0;
        Ok(Self {
            actuators: (0..sizes.edges).filter(strains).collect(),
            ground: task.ground(),
            physics: scene.physics.clone(),
            settings: scene.controller.clone(),
            task: task.clone(),
            goals: scene.goals.clone(),
            rest: lattice.state_at_rest(),
            body,
            sizes,
        })
    }

    /// The indices of the edges that respond to activations.
    #[getter]
    fn actuators(&self) -> Vec<usize> {
        self.actuators.clone()
    }

    /// The number of values in an observation.
    #[getter]
    fn inputs(&self) -> usize {
        self.sizes.inputs
    }

    /// The length of a time step, in seconds.
    #[getter]
    fn dt(&self) -> f64 {
        self.physics.dt
    }

    /// The number of steps of a whole rollout.
    #[getter]
    fn steps(&self) -> usize {
        self.physics.steps
    }

    /// The positions of the nodes at rest, of shape `(nodes, 2)`.
    #[getter]
    fn rest<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        array(py, flat(&self.rest.x), &[self.sizes.nodes, 2])
    }

    /// As [`Simulator::goal_origin`](crate::simulator::Simulator::goal_origin).
    #[getter]
    fn goal_origin(&self) -> Option<[f64; 2]> {
        goal_origin(&self.task, &self.sizes)
    }

    /// Draws a sequence of goals as the scene's `[goals]` say. The first one is ahead or behind with equal probability,
    /// if the settings allow both. Returns the numbers of steps at which goals change, and the goals, an array of
    /// shape `(goals, 2)`.
    fn draw_goals<'py>(&self, py: Python<'py>, seed: u64) -> PyResult<(Vec<usize>, Floats<'py>)> {
        let (settings, ahead) = (&self.goals, seed.is_multiple_of(2));
        let goals = caught(|| {
            let mut stream = stream(seed, Purpose::Errands);
            Ok(draw_goals(&self.task, settings, ahead, &mut stream))
        })?;
        let points: Vec<f64> = goals.iter().flatten().collect();
        let shape = [goals.later.len() + 1, 2];
        let changes = goals.later.iter().map(|&(steps, _)| steps).collect();
        Ok((changes, array(py, points, &shape)?))
    }

    /// Returns the position along the ground of each robot's payload, or of the body that `objective.body` names, in
    /// metres.
    fn along<'py>(&self, py: Python<'py>, x: &Bound<'py, PyAny>) -> PyResult<Floats<'py>> {
        let states = self.states(x, x)?;
        let place = |state| self.body.marker.place(&self.rest.x, state);
        let along = states.iter().map(|state| self.ground.along(place(state)));
        array(py, along.collect(), &[states.len()])
    }

    /// Simulates `steps` steps with constant activations, of shape `(robots, edges)`. `first` is the number of steps
    /// that the robots have done before. Returns positions and velocities, each of shape `(robots, nodes, 2)`, and a
    /// list that says for each robot whether it diverged.
    fn advance<'py>(
        &self,
        py: Python<'py>,
        activations: &Bound<'py, PyAny>,
        x: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        first: usize,
        steps: usize,
    ) -> PyResult<(Floats<'py>, Floats<'py>, Vec<bool>)> {
        let starts = self.states(x, v)?;
        let robots = starts.len();
        let held = Given::<f64>::new("activations", activations)?;
        if held.batch(&[self.sizes.edges])? != Some(robots) {
            return Err(refused(format!(
                "activations: expected the shape ({robots}, edges)"
            )));
        }
        let held: Vec<Vec<f64>> = held
            .finite()?
            .chunks_exact(self.sizes.edges)
            .map(<[f64]>::to_vec)
            .collect();
        if steps == 0 || first.saturating_add(steps) > self.physics.steps {
            let last = self.physics.steps;
            return Err(refused(format!(
                "cannot do {steps} steps after step {first}: expected 1 or more, up to the scene's last step {last}"
            )));
        }
        let span = Span {
            first,
            ..Span::from_start(vec![steps])
        };
        let group = |robots: std::ops::Range<usize>| {
            let held: Vec<&[f64]> = held[robots.clone()].iter().map(Vec::as_slice).collect();
            (self.task.simulator).rollouts_held(&self.body, &held, &starts[robots], &span)
        };
        let work = |stop: &Stop| in_groups(robots, true, stop, group);
        let seen = caught(|| whole(in_pool(py, robots, work)?))?;
        let seen: Vec<Trajectory<f64>> = seen.into_iter().flatten().collect();
        let diverged = seen.iter().map(|seen| seen.states[0].is_absurd()).collect();
        let seen = flattened(&seen);
        let shape = [robots, self.sizes.nodes, 2];
        Ok((
            array(py, seen.x, &shape)?,
            array(py, seen.v, &shape)?,
            diverged,
        ))
    }

    /// Returns the observation of each robot, as the paper defines it. `done` contains the number of steps that each
    /// robot has done. `goals` has each robot's goal if goals are inputs of a rollout, shape `(robots, 2)`.
    fn observe<'py>(
        &self,
        py: Python<'py>,
        x: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        done: Vec<usize>,
        goals: Option<Vec<[f64; 2]>>,
    ) -> PyResult<Floats<'py>> {
        let states = self.states(x, v)?;
        let goals = goals.unwrap_or_else(|| vec![self.settings.goal; states.len()]);
        if [done.len(), goals.len()] != [states.len(); 2] {
            return Err(refused(format!(
                "done, goals: expected {} numbers of steps and as many goals, one per robot",
                states.len()
            )));
        }
        let mut settings = self.settings.clone();
        let robots = states.iter().zip(done).zip(goals);
        let seen = robots.flat_map(|((state, done), goal)| {
            settings.goal = goal;
            // A robot without a controller has a clock of the scene's frequency.
            let phase = settings.omega * (done as f64 * self.physics.dt);
            observation(&settings, phase, state, &self.body.presence, &self.ground)
        });
        array(py, seen.collect(), &[states.len(), self.sizes.inputs])
    }
}
