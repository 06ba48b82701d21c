//! A requested rollout of one robot or of several.

use crate::arrays::{Batch, Given, NAMES, Number, Sizes, flattened};
use crate::errors::{InternalError, refused};
use crate::pool;
use autodiff::Real;
use cosmic::design::{Design, Material};
use cosmic::error::Error;
use cosmic::geometry::{flat, from_flat};
use cosmic::inputs::Inputs;
use cosmic::lattice::{Body, State};
use cosmic::projection::Projection;
use cosmic::simulator::{Robots, Span, Surroundings, Trajectory};
use cosmic::task::{Task, together};
use pyo3::prelude::*;
use rayon::prelude::*;
use std::borrow::Cow;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

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
    /// Reads the argument `projection`, here `name`.
    fn of<R: Number>(name: &str, z: &[[R; 3]]) -> PyResult<Self> {
        match name {
            "performance" => Ok(Self::By(Projection::Performance)),
            "stability" => Ok(Self::By(Projection::Stability)),
            "none" => Ok(Self::AsGiven),
            "layout" => {
                let rows = z.iter().enumerate();
                let layout = rows.map(|(edge, row)| material_of(edge, row.map(Into::into)));
                Ok(Self::Layout(layout.collect::<PyResult<_>>()?))
            }
            _ => Err(refused(format!(
                "projection: {name:?}: allowed: \"auto\", \"performance\", \"stability\", \"none\", \"layout\""
            ))),
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

/// The material of an edge of a finished robot: the one with more than half of the share.
fn material_of(edge: usize, row: [f64; 3]) -> PyResult<Material> {
    let material = Material::dominant(&row);
    if material.of(&row) > 0.5 {
        return Ok(material);
    }
    Err(refused(format!(
        "z: row {edge} is {row:?}; this simulator is for finished robots (projection=\"layout\"), so one number of \
         every row must be above 0.5; use another Simulator for other designs"
    )))
}

/// A requested rollout: the inputs of one robot or of several, and the observed steps.
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
        let names = NAMES.iter().chain(&["goal"]).zip(arrays);
        let given = names.map(|(name, object)| Given::new(name, object));
        let given: Vec<Given<R>> = given.collect::<PyResult<_>>()?;
        let batch = Batch::new(&given, sizes)?;
        let mixing = (0..batch.robots()).map(|robot| Mixing::of(projection, batch.z(robot)));
        Ok(Self {
            mixing: mixing.collect::<PyResult<_>>()?,
            batch,
            span,
        })
    }

    /// Returns the body with which a robot is simulated.
    pub(crate) fn body(&self, task: &Task, robot: usize) -> Body<R> {
        self.mixing[robot].body(task, self.batch.z(robot))
    }

    /// Returns the number of robots that a thread simulates together.
    fn together(&self) -> usize {
        group_size(
            self.batch.robots(),
            self.batch.shared_controller().is_some(),
        )
    }

    /// Simulates a range of robots together. If there are several, they must share one controller.
    fn group(&self, task: &Task, robots: Range<usize>) -> Vec<Trajectory<R>> {
        let bodies = robots.clone().map(|robot| self.body(task, robot));
        let bodies: Vec<Body<R>> = bodies.collect();
        let controller = self.batch.controller(robots.start);
        let starts: Vec<&State<R>> = (robots.clone())
            .map(|robot| self.batch.start(robot))
            .collect();
        let differ = if self.batch.shares_goals() {
            1
        } else {
            robots.len()
        };
        let surroundings = robots.take(differ);
        let surroundings =
            surroundings.map(|robot| surroundings_of(task, &self.batch.components(robot)));
        let surroundings: Vec<_> = surroundings.collect();
        let robots = Robots {
            surroundings: &surroundings,
            bodies: &bodies,
            controllers: std::slice::from_ref(controller),
        };
        task.simulator.rollouts(&robots, &starts, &self.span)
    }

    /// Returns the observed states of every robot, without converting them to arrays. Used to measure the library's
    /// time.
    pub(crate) fn rollouts(&self, task: &Task) -> Vec<Vec<Trajectory<R>>> {
        let robots = self.batch.robots();
        let shared = self.batch.shared_controller().is_some();
        in_groups(robots, shared, &Stop::new(false), |group| {
            self.group(task, group)
        })
    }

    /// Simulates all robots and writes their positions and velocities into the arrays `x` and `v`. A robot that
    /// diverges gets NaN from its first absurd state on (see [`State::absurd_node`]). Robots that have not begun when
    /// the work is stopped get NaN.
    ///
    /// If `check` is true: the number of the first robot whose last state is absurd, and the reason.
    pub(crate) fn fill(
        &self,
        task: &Task,
        [x, v]: [&mut [R]; 2],
        stop: &Stop,
        check: bool,
    ) -> Result<(), (usize, Error)> {
        let (robots, together) = (self.batch.robots(), self.together());
        let length = self.span.observed.len() * 2 * task.lattice.nodes();
        let places = x.chunks_mut(together * length);
        let places = places.zip(v.chunks_mut(together * length)).enumerate();
        // Each thread copies the states of its robots into the arrays and then drops them, to save memory.
        let step = |(group, (x, v)): (usize, (&mut [R], &mut [R]))| {
            if stop.load(Ordering::Relaxed) {
                x.fill(R::lit(f64::NAN));
                v.fill(R::lit(f64::NAN));
                return None;
            }
            let first = group * together;
            let seen = self.group(task, first..(first + together).min(robots));
            let parts = x.chunks_exact_mut(length).zip(v.chunks_exact_mut(length));
            for (seen, (x, v)) in seen.iter().zip(parts) {
                copy(seen, x, v);
            }
            seen.iter().position(is_absurd).map(|robot| first + robot)
        };
        let absurd = match robots {
            1 => places.map(step).next().flatten(),
            _ => places.par_bridge().filter_map(step).min(),
        };
        self.checked(task, absurd.filter(|_| check))
    }

    /// Writes walks that a device has computed, like [`fill`](Self::fill).
    pub(crate) fn write(
        &self,
        task: &Task,
        walks: &[Trajectory<R>],
        [x, v]: [&mut [R]; 2],
        check: bool,
    ) -> Result<(), (usize, Error)> {
        let length = self.span.observed.len() * 2 * task.lattice.nodes();
        let places = x.chunks_exact_mut(length).zip(v.chunks_exact_mut(length));
        for (walk, (x, v)) in walks.iter().zip(places) {
            copy(walk, x, v);
        }
        self.checked(task, walks.iter().position(is_absurd).filter(|_| check))
    }

    /// An error if a robot is absurd, with the reason.
    fn checked(&self, task: &Task, absurd: Option<usize>) -> Result<(), (usize, Error)> {
        match absurd {
            None => Ok(()),
            Some(robot) => Err((robot, self.divergence(task, robot))),
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
        guarded.divergence.as_ref().map_or_else(
            || {
                Error::NoFigure(
                    "the rollout diverged in single but not in double precision".to_owned(),
                )
            },
            Error::from,
        )
    }
}

/// Copies the positions and velocities of the states into `x` and `v`. If the robot diverged, NaN replaces the states
/// from the first absurd state on.
fn copy<R: Number>(seen: &Trajectory<R>, x: &mut [R], v: &mut [R]) {
    let nodes = seen.states.first().map_or(1, |state| 2 * state.x.len());
    let places = x.chunks_exact_mut(nodes).zip(v.chunks_exact_mut(nodes));
    for (state, (x, v)) in seen.states.iter().zip(places) {
        x.copy_from_slice(&flat(&state.x));
        v.copy_from_slice(&flat(&state.v));
    }
    if is_absurd(seen) {
        let first = seen.states.iter().position(is_absurd_state);
        let first = first.unwrap_or_default() * nodes;
        x[first..].fill(R::lit(f64::NAN));
        v[first..].fill(R::lit(f64::NAN));
    }
}

fn is_absurd<R: Number>(seen: &Trajectory<R>) -> bool {
    seen.states.last().is_some_and(is_absurd_state)
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
    let seen = flattened(&task.simulator.rollouts(&robot, &[start], span));
    [seen.x, seen.v].concat()
}

/// A flag that becomes true when the work must stop. Robots that have not begun by then are skipped.
pub(crate) type Stop = AtomicBool;

/// The interval between checks for signals.
const LOOK: Duration = Duration::from_millis(50);

/// The result of work, and the exception that a signal raised during the work, if any.
pub(crate) type Interruptible<T> = (T, Option<PyErr>);

/// Runs `work` without the interpreter's lock. If there are several robots, it runs in the thread pool, and a signal
/// stops it after the robots in progress.
pub(crate) fn in_pool<T: Send>(
    py: Python,
    robots: usize,
    work: impl FnOnce(&Stop) -> T + Send,
) -> PyResult<Interruptible<T>> {
    let stop = Stop::new(false);
    if robots == 1 {
        return Ok((py.detach(|| work(&stop)), None));
    }
    let pool = pool::shared()?;
    let (sender, receiver) = channel();
    let mut raised = None;
    let (stop, interrupt) = (&stop, &mut raised);
    let ended = py.detach(move || {
        pool.in_place_scope(|scope| {
            // Sending fails only if the receiver is gone, and it is gone only after a panic.
            scope.spawn(move |_| _ = sender.send(work(stop)));
            loop {
                match receiver.recv_timeout(LOOK) {
                    Ok(done) => return Some(done),
                    // The work panicked. The scope propagates the panic.
                    Err(RecvTimeoutError::Disconnected) => return None,
                    Err(RecvTimeoutError::Timeout) => {}
                }
                if let Err(error) = Python::attach(|py| py.check_signals()) {
                    stop.store(true, Ordering::Relaxed);
                    interrupt.get_or_insert(error);
                }
            }
        })
    });
    let done = ended.ok_or_else(|| InternalError::new_err("the simulation ended without a result; this is an error of the package, please report it"))?;
    Ok((done, raised))
}

/// Returns the result of work. If a signal interrupted the work, drops the partial result and returns the exception.
pub(crate) fn whole<T>((done, raised): Interruptible<T>) -> PyResult<T> {
    raised.map_or(Ok(done), Err)
}

/// Returns the number of robots that a thread simulates together: several if they share the controller, otherwise one.
/// For a single robot, the function starts no thread pool to count its threads.
fn group_size(robots: usize, shared: bool) -> usize {
    if robots > 1 && shared {
        together(robots)
    } else {
        1
    }
}

/// Applies a function to every group of robots that a thread simulates together, and returns the results.
pub(crate) fn in_groups<T: Send>(
    robots: usize,
    shared: bool,
    stop: &Stop,
    of: impl Fn(Range<usize>) -> T + Sync + Send,
) -> Vec<T> {
    let size = group_size(robots, shared);
    each(robots.div_ceil(size), stop, |group| {
        of(group * size..((group + 1) * size).min(robots))
    })
}

/// Applies a function to the number of every robot, and returns the results. Robots that have not begun when the work
/// is stopped are skipped.
pub(crate) fn each<T: Send>(
    robots: usize,
    stop: &Stop,
    of: impl Fn(usize) -> T + Sync + Send,
) -> Vec<T> {
    if robots == 1 {
        return vec![of(0)];
    }
    let robots = (0..robots).into_par_iter();
    robots
        .filter_map(|robot| (!stop.load(Ordering::Relaxed)).then(|| of(robot)))
        .collect()
}
