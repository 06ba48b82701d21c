//! Requested rollouts of robots.

use crate::arrays::{Number, Sizes, flattened};
use crate::work::{Stop, group_size};
use autodiff::Real;
use cosmic::design::{Design, Material};
use cosmic::error::Error;
use cosmic::geometry::from_flat;
use cosmic::inputs::Inputs;
use cosmic::lattice::{Body, State};
use cosmic::policy::{Controller, Goals};
use cosmic::projection::Projection;
use cosmic::simulator::{Robots, Span, Surroundings, Trajectory};
use cosmic::task::Task;
use numpy::{PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
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
            Self::By(projection) => {
                task.body(&Design::Undecided(task.projector.mixtures(*projection, z)))
            }
            Self::AsGiven => task.body(&Design::of_shares(z)),
            Self::Layout(layout) => task.body_near(layout, z),
        }
    }
}

/// Requested rollouts: the inputs of robots, and the observed steps. Inputs that all robots share are stored once.
pub(crate) struct Asked<R> {
    z: Vec<Vec<[R; 3]>>,
    controllers: Vec<Controller<R>>,
    starts: Vec<State<R>>,
    /// The goals of each robot; empty if the robots have the scene's goal.
    goals: Vec<Goals<R>>,
    pub(crate) mixing: Vec<Mixing>,
    pub(crate) robots: usize,
    pub(crate) span: Span,
}

impl<R: Number> Asked<R> {
    /// Reads the arrays of [`Sizes::shapes`], and the goals if there is one array more. Each has an axis for robots in
    /// front, of length 1 if all robots share the array. Python has checked their shapes and their numbers.
    pub(crate) fn new(
        sizes: &Sizes,
        arrays: &[Bound<PyAny>],
        span: Span,
        projection: &str,
    ) -> PyResult<Self> {
        let arrays = arrays.iter().map(|array| {
            let array = array.cast::<PyArrayDyn<R>>()?;
            Ok(array.try_readonly()?)
        });
        let arrays: Vec<_> = arrays.collect::<PyResult<_>>()?;
        let counts: Vec<usize> = arrays.iter().map(|array| array.shape()[0]).collect();
        let data = arrays.iter().map(|array| Ok(array.as_slice()?));
        let data: Vec<&[R]> = data.collect::<PyResult<_>>()?;
        let robots = counts.iter().copied().max().unwrap_or(0);
        Ok(Self::of(sizes, &data, &counts, robots, span, projection))
    }

    /// As [`Asked::new`], from the numbers of each array, and how many robots each array describes: all, or 1 if all share
    /// it.
    pub(crate) fn of(
        sizes: &Sizes,
        data: &[&[R]],
        counts: &[usize],
        robots: usize,
        span: Span,
        projection: &str,
    ) -> Self {
        let part = |array: usize, robot: usize| {
            let length = data[array].len() / counts[array];
            &data[array][robot % counts[array] * length..][..length]
        };
        // The numbers of the robots that differ in at least one of these arrays.
        let differ = |arrays: Range<usize>| 0..counts[arrays].iter().copied().max().unwrap_or(0);
        let x0 = 1 + sizes.blocks.len();
        let own = |robot: usize| (1..x0).flat_map(move |array| part(array, robot)).copied();
        let state = |robot: usize| State {
            x: from_flat(part(x0, robot)),
            v: from_flat(part(x0 + 1, robot)),
        };
        let z: Vec<_> = differ(0..1)
            .map(|robot| part(0, robot).as_chunks().0.to_vec())
            .collect();
        let mixing = (0..robots).map(|robot| Mixing::of(projection, &z[robot % z.len()]));
        Self {
            mixing: mixing.collect(),
            z,
            controllers: (differ(1..x0))
                .map(|robot| Controller::new(&sizes.blocks, own(robot).collect()))
                .collect(),
            starts: differ(x0..x0 + 2).map(state).collect(),
            goals: (differ(x0 + 2..counts.len()))
                .map(|robot| sizes.goals(part(x0 + 2, robot)))
                .collect(),
            robots,
            span,
        }
    }

    /// Returns the controller of all robots, if they share one.
    pub(crate) fn shared_controller(&self) -> Option<&Controller<R>> {
        match &self.controllers[..] {
            [controller] => Some(controller),
            _ => None,
        }
    }

    pub(crate) fn z(&self, robot: usize) -> &[[R; 3]] {
        &self.z[robot % self.z.len()]
    }

    pub(crate) fn controller(&self, robot: usize) -> &Controller<R> {
        &self.controllers[robot % self.controllers.len()]
    }

    pub(crate) fn start(&self, robot: usize) -> &State<R> {
        &self.starts[robot % self.starts.len()]
    }

    /// Returns the goals of a robot; `None` if it has the scene's goal.
    pub(crate) fn goals(&self, robot: usize) -> Option<&Goals<R>> {
        self.goals.get(robot % self.goals.len().max(1))
    }

    /// Returns the components of a robot's goals; empty if it has the scene's goal.
    pub(crate) fn components(&self, robot: usize) -> Vec<R> {
        let goals = self.goals(robot).into_iter().flat_map(Goals::iter);
        goals.flatten().collect()
    }

    /// True if all robots have the same design vectors.
    #[cfg(feature = "gpu")]
    pub(crate) fn shares_design(&self) -> bool {
        self.z.len() < 2
    }

    /// True if all robots have the same goals.
    pub(crate) fn shares_goals(&self) -> bool {
        self.goals.len() < 2
    }

    pub(crate) fn inputs(&self, robot: usize) -> Inputs<R> {
        Inputs {
            z: self.z(robot).to_vec(),
            controller: self.controller(robot).clone(),
            start: self.start(robot).clone(),
        }
    }

    /// Returns the body with which a robot is simulated.
    pub(crate) fn body(&self, task: &Task, robot: usize) -> Body<R> {
        self.mixing[robot].body(task, self.z(robot))
    }

    /// Simulates a range of robots together. If there are several, they must share one controller.
    fn group(&self, task: &Task, robots: Range<usize>) -> Vec<Trajectory<R>> {
        let bodies = robots.clone().map(|robot| self.body(task, robot));
        let bodies: Vec<Body<R>> = bodies.collect();
        let controller = self.controller(robots.start);
        let starts = robots.clone().map(|robot| self.start(robot));
        let starts: Vec<&State<R>> = starts.collect();
        let differ = match self.shares_goals() {
            true => robots.take(1),
            false => robots.take(usize::MAX),
        };
        let surroundings = differ.map(|robot| surroundings_of(task, &self.components(robot)));
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
        let robots = self.robots;
        let together = group_size(robots, self.shared_controller().is_some());
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
        let (start, controller) = (self.start(robot), self.controller(robot));
        let (start, controller) = (start.map(Into::into), controller.map(Into::into));
        let body = self.body(task, robot).map(Into::into);
        let goals = self.goals(robot).map(|goals| goals.map(Into::into));
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
