//! Requested rollouts of robots.

use crate::arrays::{Number, Others, Sizes, flattened};
use crate::simulator::Simulator;
use crate::work::{Stop, group_size};
use autodiff::Real;
use cosmic::design::{Design, Material};
use cosmic::error::Error;
use cosmic::inputs::{ALL, Block, Inputs, WithOthers};
use cosmic::lattice::{Body, FACTORS, State};
use cosmic::policy::Controller;
use cosmic::projection::Projection;
use cosmic::world::Task;
use cosmic::world::{Robots, Span, Surroundings, Trajectory};
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
    fn new<R: Number>(projection: &str, z: &[[R; 3]]) -> Self {
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
    /// The numbers of the arrays of [`Others`](crate::arrays::Others): one list for each robot, or one for all.
    others: Vec<Vec<R>>,
    pub(crate) sizes: Sizes,
    pub(crate) mixing: Vec<Mixing>,
    pub(crate) robots: usize,
    /// The robots whose inputs are not finite.
    pub(crate) lost: Vec<bool>,
    pub(crate) span: Span,
}

impl<R: Number> Asked<R> {
    /// Reads the arrays of [`Sizes::shapes`], and then those of the other inputs. Each has an axis for robots in front, of
    /// length 1 if all robots share the array. Python has checked their shapes. `of` is [`Asked::of`] or [`Asked::along`].
    pub(crate) fn read(
        arrays: &[Bound<PyAny>],
        of: impl FnOnce(&[&[R]], &[usize], usize) -> PyResult<Self>,
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
        of(&data, &counts, robots)
    }

    /// Takes the numbers of each array, and how many robots each array describes: all, or 1 if all share it. Numbers that are
    /// not finite become 0, and their robots are lost.
    pub(crate) fn of(
        simulator: &Simulator,
        data: &[&[R]],
        counts: &[usize],
        robots: usize,
        span: Span,
    ) -> PyResult<Self> {
        let (data, lost) = finite(data, counts, robots);
        let data: Vec<&[R]> = data.iter().map(|numbers| &**numbers).collect();
        let projection = simulator.projection_of(data[0], &lost)?;
        let asked = Self::new(&simulator.sizes, &data, counts, robots, span, projection);
        Ok(Self { lost, ..asked })
    }

    /// As [`Asked::of`], for tangents.
    pub(crate) fn along(
        sizes: &Sizes,
        data: &[&[R]],
        counts: &[usize],
        robots: usize,
        span: Span,
    ) -> Self {
        Self::new(sizes, data, counts, robots, span, "none")
    }

    fn new(
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
        let state =
            |robot| State::from_flat(sizes.dimension, [part(x0, robot), part(x0 + 1, robot)]);
        let z: Vec<_> = differ(0..1)
            .map(|robot| part(0, robot).as_chunks().0.to_vec())
            .collect();
        let mixing = (0..robots).map(|robot| Mixing::new(projection, &z[robot % z.len()]));
        Self {
            mixing: mixing.collect(),
            z,
            // Robots with given activations share a controller without blocks.
            controllers: (0..differ(1..x0).end.max(1))
                .map(|robot| Controller::new(&sizes.blocks, own(robot).collect()))
                .collect(),
            starts: differ(x0..x0 + 2).map(state).collect(),
            others: (differ(x0 + 2..counts.len()))
                .map(|robot| {
                    let others = (x0 + 2..counts.len()).flat_map(|array| part(array, robot));
                    others.copied().collect()
                })
                .collect(),
            sizes: sizes.clone(),
            robots,
            lost: Vec::new(),
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

    /// Returns the numbers of a robot's other inputs.
    pub(crate) fn others(&self, robot: usize) -> &[R] {
        let others = self.others.get(robot % self.others.len().max(1));
        others.map_or(&[], |others| others)
    }

    /// True if all robots have the same surroundings.
    pub(crate) fn shares_surroundings(&self) -> bool {
        let Others { goals, physics, .. } = &self.sizes.others;
        self.others.len() < 2 || *goals == 0 && physics.is_empty()
    }

    /// True if all robots have the same body.
    pub(crate) fn shares_body(&self) -> bool {
        self.z.len() < 2 && (self.others.len() < 2 || self.sizes.others.physics.is_empty())
    }

    /// Returns a gradient of a robot by all inputs and other inputs. `gradient` has only the numbers of `blocks`, and those of
    /// the other inputs if there are more numbers; the others are 0.
    pub(crate) fn padded(&self, blocks: &[Block], robot: usize, mut gradient: &[R]) -> Vec<R> {
        let inputs = self.inputs(robot);
        let mut padded = Vec::new();
        for block in ALL {
            let length = inputs.block(*block).len();
            match blocks.contains(block) {
                true => {
                    padded.extend_from_slice(&gradient[..length]);
                    gradient = &gradient[length..];
                }
                false => padded.resize(padded.len() + length, R::zero()),
            }
        }
        padded.extend_from_slice(gradient);
        let length = padded.len() - gradient.len() + self.others(robot).len();
        padded.resize(length, R::zero());
        padded
    }

    pub(crate) fn inputs(&self, robot: usize) -> Inputs<R> {
        Inputs {
            z: self.z(robot).to_vec(),
            controller: self.controller(robot).clone(),
            start: self.start(robot).clone(),
        }
    }

    /// Returns the surroundings in which a robot is simulated.
    pub(crate) fn surroundings(&self, task: &Task, robot: usize) -> Surroundings<R> {
        surroundings_of(task, &self.sizes, self.others(robot))
    }

    /// Returns the body with which a robot is simulated.
    pub(crate) fn body(&self, task: &Task, robot: usize) -> Body<R> {
        let body = self.mixing[robot].body(task, self.z(robot));
        scaled(task, &self.sizes, body, self.others(robot))
    }

    /// Simulates a range of robots together. If there are several, they must share one controller.
    fn group(&self, task: &Task, robots: Range<usize>) -> Vec<Trajectory<R>> {
        let each = |is_shared: bool| robots.clone().take(if is_shared { 1 } else { usize::MAX });
        let surroundings = each(self.shares_surroundings()).map(|k| self.surroundings(task, k));
        let bodies = each(self.shares_body()).map(|k| self.body(task, k));
        let (surroundings, bodies): (Vec<_>, Vec<_>) = (surroundings.collect(), bodies.collect());
        let starts: Vec<&State<R>> = robots.clone().map(|robot| self.start(robot)).collect();
        let all = Robots {
            surroundings: &surroundings,
            bodies: &bodies,
            controllers: std::slice::from_ref(self.controller(robots.start)),
        };
        let others: Vec<&[R]> = robots.map(|robot| self.others(robot)).collect();
        walks(task, &self.sizes, &all, &others, &starts, &self.span)
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

    /// Repeats the rollout of a robot in double precision, to find where and why it diverges. The reason is only known for a
    /// robot with a controller in the physics of the scene.
    pub(crate) fn divergence(&self, task: &Task, robot: usize) -> Error {
        let not_again = || {
            Error::NoFigure("the rollout diverged in single but not in double precision".to_owned())
        };
        let of: Vec<f64> = self.others(robot).iter().map(|&x| x.into()).collect();
        let inputs = self.inputs(robot).map(Into::into);
        let Sizes { others, .. } = &self.sizes;
        if others.driven.is_none() && others.physics.is_empty() {
            let goals = (others.goals > 0).then(|| self.sizes.goals(&of));
            let task = goals.map_or(Cow::Borrowed(task), |goals| {
                Cow::Owned(task.with_goals(&goals))
            });
            let body = self.mixing[robot].body(&task, &inputs.z);
            let Inputs {
                controller, start, ..
            } = inputs;
            let guarded = (task.simulator).guarded(&body, &controller, &start, &self.span);
            return (guarded.divergence.as_ref()).map_or_else(not_again, Error::from);
        }
        let steps = self.span.observed.last().copied().unwrap_or(0);
        let every = Span {
            observed: (0..=steps).collect(),
            ..self.span.clone()
        };
        let body = self.mixing[robot].body(task, &inputs.z);
        let body = scaled(task, &self.sizes, body, &of);
        let surroundings = surroundings_of(task, &self.sizes, &of);
        let one = Robots::one(&surroundings, &body, &inputs.controller);
        let walk = walks(task, &self.sizes, &one, &[&of], &[&inputs.start], &every).remove(0);
        let mut states = walk.states.iter().enumerate();
        states
            .find_map(|(k, state)| Some((k, state, state.absurd_node()?)))
            .map_or_else(not_again, |(k, state, node)| Error::Diverged {
                step: self.span.first + k.saturating_sub(1),
                node,
                position: state.x[node],
                velocity: state.v[node],
                cause: match (others.driven.is_some(), others.physics.is_empty()) {
                    (true, true) => "under the given activations",
                    (false, _) => "under the given physics",
                    (true, false) => "under the given activations and physics",
                }
                .to_owned(),
            })
    }
}

/// Replaces numbers that are not finite by 0, and such rows of `z`, which is the first array, by void, because not every
/// projection takes a row of zeros. Returns the numbers of each array, and which robots had such numbers.
fn finite<'a, R: Number>(
    data: &[&'a [R]],
    counts: &[usize],
    robots: usize,
) -> (Vec<Cow<'a, [R]>>, Vec<bool>) {
    let is_finite = |number: &R| Into::<f64>::into(*number).is_finite();
    let mut lost = vec![false; robots];
    let mut cleaned: Vec<_> = data.iter().copied().map(Cow::Borrowed).collect();
    for (k, (numbers, count)) in cleaned.iter_mut().zip(counts).enumerate() {
        if numbers.iter().all(is_finite) {
            continue;
        }
        let parts: Vec<_> = numbers.chunks(numbers.len() / count).collect();
        for (robot, lost) in lost.iter_mut().enumerate() {
            *lost |= !parts[robot % count].iter().all(is_finite);
        }
        let numbers = numbers.to_mut();
        if k == 0 {
            let rows = numbers.as_chunks_mut().0.iter_mut();
            rows.filter(|row: &&mut [R; 3]| !row.iter().all(is_finite))
                .for_each(|row| *row = [R::one(), R::zero(), R::zero()]);
        }
        let rest = numbers.iter_mut().filter(|number| !is_finite(number));
        rest.for_each(|number| *number = R::zero());
    }
    (cleaned, lost)
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
pub(crate) fn ends_absurd<R: Number>(seen: &[R], sizes: &Sizes) -> bool {
    let length = sizes.points().iter().product::<usize>();
    let (x, v) = seen.split_at(seen.len() / 2);
    let last = [x, v].map(|half| &half[half.len() - length..]);
    is_absurd_state(&State::from_flat(sizes.dimension, last))
}

/// Returns the surroundings of a robot whose other inputs have the numbers `others`.
pub(crate) fn surroundings_of<R: Real>(
    task: &Task,
    sizes: &Sizes,
    others: &[R],
) -> Surroundings<R> {
    let (_, goals, physics) = sizes.others.split(sizes.edges, others);
    let scene = task.simulator.surroundings();
    let with_goals = (goals.iter().enumerate()).fold(scene, |surroundings, (k, &number)| {
        let names = sizes.dimension.names();
        let (goal, axis) = (k / names.len(), names[k % names.len()]);
        surroundings.with(&format!("goal.{goal}.{axis}"), number)
    });
    let numbers = physics.filter(|(name, _)| !FACTORS.contains(name));
    numbers.fold(with_goals, |surroundings, (name, numbers)| {
        surroundings.with(name, numbers[0])
    })
}

/// Returns the body that design vectors determine, multiplied by the factors among the other inputs, which have the numbers
/// `others`.
pub(crate) fn scaled<R: Real>(
    task: &Task,
    sizes: &Sizes,
    mut body: Body<R>,
    others: &[R],
) -> Body<R> {
    let (.., physics) = sizes.others.split(sizes.edges, others);
    for (name, factors) in physics {
        body.scale(name, factors, &task.lattice.rest_length);
    }
    body
}

/// Simulates robots whose other inputs have the numbers `others`. If they have no given activations, they have the first of
/// the controllers.
fn walks<R: Real>(
    task: &Task,
    sizes: &Sizes,
    robots: &Robots<R>,
    others: &[&[R]],
    starts: &[&State<R>],
    span: &Span,
) -> Vec<Trajectory<R>> {
    if sizes.others.driven.is_none() {
        return task.simulator.rollouts(robots, starts, span);
    }
    let given = others
        .iter()
        .map(|others| sizes.others.split(sizes.edges, others).0);
    let given: Vec<&[R]> = given.collect();
    (task.simulator).driven(robots.surroundings, robots.bodies, &given, starts, span)
}

/// Simulates robots of a request, of which `first` is the number of the first. They must share a controller, unless there is
/// only one. Returns one list: for each robot, its observed positions and then its observed velocities.
pub(crate) fn seen<R: Real>(
    task: &Task,
    asked: &Asked<impl Number>,
    first: usize,
    robots: &[WithOthers<R>],
) -> Vec<R> {
    // If the other inputs have no derivatives, the robots do not have them.
    let lift = |k: usize| -> Vec<R> {
        let others = asked.others(k).iter();
        others.map(|&x| R::lit(x.into())).collect()
    };
    let others = robots.iter().zip(first..);
    let others = others.map(|(robot, k)| match robot.others.is_empty() {
        true => lift(k),
        false => robot.others.clone(),
    });
    let others: Vec<Vec<R>> = others.collect();
    let surroundings = others
        .iter()
        .map(|others| surroundings_of(task, &asked.sizes, others));
    let surroundings: Vec<_> = surroundings.collect();
    let bodies = robots.iter().zip(&others).zip(first..);
    let bodies = bodies.map(|((robot, others), k)| {
        let body = asked.mixing[k].body(task, &robot.inputs.z);
        scaled(task, &asked.sizes, body, others)
    });
    let bodies: Vec<_> = bodies.collect();
    let all = Robots {
        surroundings: &surroundings,
        bodies: &bodies,
        controllers: std::slice::from_ref(&robots[0].inputs.controller),
    };
    let others: Vec<&[R]> = others.iter().map(Vec::as_slice).collect();
    let starts: Vec<&State<R>> = robots.iter().map(|robot| &robot.inputs.start).collect();
    let walks = walks(task, &asked.sizes, &all, &others, &starts, &asked.span);
    let numbers = walks.chunks(1).flat_map(|walk| flattened(walk).concat());
    numbers.collect()
}
