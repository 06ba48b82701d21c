//! Requested rollouts of robots.

use crate::arrays::{Batch, Number, Sizes, flattened};
use crate::work::{Stop, group_size};
use autodiff::Real;
use cosmic::design::{Design, Material};
use cosmic::error::Error;
use cosmic::geometry::from_flat;
use cosmic::inputs::Inputs;
use cosmic::lattice::{Body, State};
use cosmic::projection::Projection;
use cosmic::simulator::{Robots, Span, Surroundings, Trajectory};
use cosmic::task::Task;
use pyo3::prelude::*;
use rayon::prelude::*;
use std::borrow::Cow;
use std::ops::Range;
use std::sync::atomic::Ordering;

/// How the rows of the array `z` become the body of a robot.
pub(crate) enum Mixing {
    /// The rows are design vectors, which this projection turns into mixtures.
    By(Projection),
    /// The rows already are mixtures.
    AsGiven,
    /// The rows are the shares of the materials in the edges of a finished robot with this layout.
    Layout(Vec<Material>),
}

impl Mixing {
    /// Reads the argument `projection`, which Python has checked.
    fn of<R: Number>(projection: &str, z: &[[R; 3]]) -> Self {
        match projection {
            "performance" => Self::By(Projection::Performance),
            "stability" => Self::By(Projection::Stability),
            "layout" => {
                let rows = z.iter().map(|row| Material::dominant(&row.map(Into::into)));
                Self::Layout(rows.collect())
            }
            _ => Self::AsGiven,
        }
    }

    /// The body of a robot with these rows. Plain numbers, forward mode and reverse mode all use this function, so
    /// that they see the same robot.
    pub(crate) fn body<R: Real>(&self, task: &Task, z: &[[R; 3]]) -> Body<R> {
        match self {
            Self::By(projection) => task.body(&Design::Undecided(task.mixtures(*projection, z))),
            Self::AsGiven => task.body(&Design::of_shares(z)),
            Self::Layout(layout) => task.body_near(layout, z),
        }
    }
}

/// A requested rollout: the inputs of robots, and the observed steps.
pub(crate) struct Asked<R> {
    pub(crate) batch: Batch<R>,
    pub(crate) mixing: Vec<Mixing>,
    pub(crate) span: Span,
}

impl<R: Number> Asked<R> {
    pub(crate) fn new(
        sizes: &Sizes,
        arrays: &[Bound<PyAny>],
        span: Span,
        projection: &str,
    ) -> PyResult<Self> {
        let batch = Batch::new(arrays, sizes)?;
        let mixing = (0..batch.robots).map(|robot| Mixing::of(projection, batch.z(robot)));
        Ok(Self {
            mixing: mixing.collect(),
            batch,
            span,
        })
    }

    /// Returns the body with which a robot is simulated.
    pub(crate) fn body(&self, task: &Task, robot: usize) -> Body<R> {
        self.mixing[robot].body(task, self.batch.z(robot))
    }

    /// Simulates a range of robots together. If there are several, they must share one controller.
    fn group(&self, task: &Task, robots: Range<usize>) -> Vec<Trajectory<R>> {
        let bodies = robots.clone().map(|robot| self.body(task, robot));
        let bodies: Vec<Body<R>> = bodies.collect();
        let controller = self.batch.controller(robots.start);
        let starts = robots.clone().map(|robot| self.batch.start(robot));
        let starts: Vec<&State<R>> = starts.collect();
        let differ = match self.batch.shares_goals() {
            true => robots.take(1),
            false => robots.take(usize::MAX),
        };
        let surroundings = differ.map(|robot| surroundings_of(task, &self.batch.components(robot)));
        let surroundings: Vec<_> = surroundings.collect();
        let robots = Robots {
            surroundings: &surroundings,
            bodies: &bodies,
            controllers: std::slice::from_ref(controller),
        };
        task.simulator.rollouts(&robots, &starts, &self.span)
    }

    /// Simulates all robots and writes their positions and velocities into the arrays `x` and `v`. A robot that
    /// diverges gets NaN from its first absurd state on (see [`State::absurd_node`]). Robots that have not begun when
    /// the work is stopped get NaN.
    ///
    /// Returns the number of the first robot whose last state is absurd.
    pub(crate) fn fill(&self, task: &Task, [x, v]: [&mut [R]; 2], stop: &Stop) -> Option<usize> {
        let robots = self.batch.robots;
        let together = group_size(robots, self.batch.shared_controller().is_some());
        let length = together * x.len() / robots;
        let places = x.chunks_mut(length).zip(v.chunks_mut(length)).enumerate();
        // Each thread copies the states of its robots into the arrays and then drops them, to save memory.
        let step = |(group, (x, v)): (usize, (&mut [R], &mut [R]))| {
            if stop.load(Ordering::Relaxed) {
                x.fill(R::lit(f64::NAN));
                v.fill(R::lit(f64::NAN));
                return None;
            }
            let first = group * together;
            let seen = self.group(task, first..(first + together).min(robots));
            write(&seen, [x, v]).map(|robot| first + robot)
        };
        match robots {
            1 => places.map(step).next().flatten(),
            _ => places.par_bridge().filter_map(step).min(),
        }
    }

    /// Repeats the rollout of a robot in double precision, to find where and why it diverges.
    pub(crate) fn divergence(&self, task: &Task, robot: usize) -> Error {
        let (start, controller) = (self.batch.start(robot), self.batch.controller(robot));
        let (start, controller) = (start.map(Into::into), controller.map(Into::into));
        let body = self.body(task, robot).map(Into::into);
        let goals = self.batch.goals(robot).map(|goals| goals.map(Into::into));
        let task = goals.map_or(Cow::Borrowed(task), |goals| {
            Cow::Owned(task.with_goals(&goals))
        });
        let guarded = (task.simulator).guarded(&body, &controller, &start, &self.span);
        let not_again = || {
            Error::NoFigure("the rollout diverged in single but not in double precision".to_owned())
        };
        (guarded.divergence.as_ref()).map_or_else(not_again, Error::from)
    }
}

/// Writes the positions and velocities of robots into `x` and `v`. If a robot diverged, NaN replaces its states from the
/// first absurd state on. Returns the place of the first robot whose last state is absurd.
pub(crate) fn write<R: Number>(walks: &[Trajectory<R>], [x, v]: [&mut [R]; 2]) -> Option<usize> {
    let length = x.len() / walks.len();
    let places = x.chunks_exact_mut(length).zip(v.chunks_exact_mut(length));
    for (walk, (x, v)) in walks.iter().zip(places) {
        let [of_x, of_v] = flattened(std::slice::from_ref(walk));
        x.copy_from_slice(&of_x);
        v.copy_from_slice(&of_v);
        if is_absurd(walk) {
            let first = walk.states.iter().position(is_absurd_state);
            let first = first.unwrap_or_default() * length / walk.states.len();
            x[first..].fill(R::lit(f64::NAN));
            v[first..].fill(R::lit(f64::NAN));
        }
    }
    walks.iter().position(is_absurd)
}

fn is_absurd<R: Number>(walk: &Trajectory<R>) -> bool {
    walk.states.last().is_some_and(is_absurd_state)
}

fn is_absurd_state<R: Number>(state: &State<R>) -> bool {
    let state: State<f64> = state.map(Into::into);
    state.is_absurd()
}

/// True if the last state is absurd. `seen` contains the numbers that the function [`seen`] returned.
pub(crate) fn ends_absurd<R: Number>(seen: &[R], nodes: usize) -> bool {
    let last = |half: &[R]| from_flat(&half[half.len() - 2 * nodes..]);
    let (x, v) = seen.split_at(seen.len() / 2);
    is_absurd_state(&State {
        x: last(x),
        v: last(v),
    })
}

/// Returns the surroundings of a robot with these components of its goals. If there are none, it has the scene's goal.
pub(crate) fn surroundings_of<R: Real>(task: &Task, goals: &[R]) -> Surroundings<R> {
    let scene = task.simulator.surroundings();
    (goals.iter().enumerate()).fold(scene, |surroundings, (k, &number)| {
        let axis = ["along", "above"][k % 2];
        surroundings.with(&format!("goal.{}.{axis}", k / 2), number)
    })
}

/// Simulates a robot. `goals` has the components of its goals, and is empty if it has the scene's goal. Returns one
/// list: its observed positions, then its observed velocities.
pub(crate) fn seen<R: Real>(
    task: &Task,
    mixing: &Mixing,
    inputs: &Inputs<R>,
    goals: &[R],
    span: &Span,
) -> Vec<R> {
    let body = mixing.body(task, &inputs.z);
    let (controller, start) = (&inputs.controller, &inputs.start);
    let surroundings = surroundings_of(task, goals);
    let robot = Robots::one(&surroundings, &body, controller);
    flattened(&task.simulator.rollouts(&robot, &[start], span)).concat()
}
