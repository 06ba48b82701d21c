//! Domain randomisation: draws random variations of a robot and its surroundings.

use std::borrow::{Borrow, Cow};

use autodiff::Real;
use rand::rngs::ChaCha8Rng;

use crate::design::{Design, Mixture};
use crate::geometry::Vector;
use crate::lattice::State;
use crate::policy::{Controller, Goals};
use crate::projection::Variation;
use crate::random::symmetric;
use crate::scene::{GoalsSettings, Scatter};
use crate::simulator::{Robots, Span, Trajectory};
use crate::task::Task;

/// One robot in its surroundings: the task that simulates it, and its initial state. The numbers of the task may be
/// drawn at random.
#[derive(Clone, Debug)]
pub struct Domain<'a> {
    /// The task.
    pub task: Cow<'a, Task>,
    /// Initial positions and velocities.
    pub start: State<f64>,
}

impl<'a> Domain<'a> {
    /// The domain that simulates `task` as it is. The robot starts in the state `start`.
    pub fn of(task: &'a Task, start: State<f64>) -> Self {
        Self {
            task: Cow::Borrowed(task),
            start,
        }
    }

    /// This domain without feedback (open loop): the controller observes the state `seen` in every step, so that only
    /// its clock changes.
    #[must_use]
    pub fn without_feedback(&self, seen: &State<f64>) -> Domain<'static> {
        Domain {
            task: Cow::Owned(self.task.without_feedback(seen)),
            start: self.start.clone(),
        }
    }
}

/// True if all domains have the same task. Their robots then differ only in their designs and starts.
fn share_a_task(domains: &[Domain]) -> bool {
    let first = &*domains[0].task;
    domains
        .iter()
        .all(|domain| std::ptr::eq(first, &*domain.task))
}

/// [Simulates](crate::simulator::Simulator::rollouts) robots with one controller, each in its own domain. `designs` has one
/// design for all domains, or one for each domain. The tasks of the domains must be [variations](Task::varied) of one task.
///
/// # Panics
/// If there are no domains.
pub fn rollouts<R: Real>(
    designs: &[impl Borrow<Design<Mixture<R>>>],
    controller: &Controller<R>,
    domains: &[Domain],
    span: &Span,
) -> Vec<Trajectory<R>> {
    let starts: Vec<_> = (domains.iter().map(|domain| domain.start.map(R::lit))).collect();
    let is_shared = share_a_task(domains);
    let bodies = if is_shared {
        designs.len()
    } else {
        domains.len()
    };
    let body = |k: usize| domains[k].task.body(designs[k % designs.len()].borrow());
    let bodies: Vec<_> = (0..bodies).map(body).collect();
    let surroundings = if is_shared { 1 } else { domains.len() };
    let surroundings = domains[..surroundings].iter();
    let surroundings = surroundings.map(|domain| domain.task.simulator.surroundings());
    let robots = Robots {
        surroundings: &surroundings.collect::<Vec<_>>(),
        bodies: &bodies,
        controllers: std::slice::from_ref(controller),
    };
    (domains[0].task.simulator).rollouts(&robots, &starts, span)
}

/// Draws a random variation of `task`. The robot starts at rest, near its initial positions. Every number is drawn even
/// if its range is zero, so that switching one range off does not change the other draws.
pub fn draw(task: &Task, scatter: &Scatter, stream: &mut ChaCha8Rng) -> Domain<'static> {
    let mut factor = |range: f64| 1.0 + symmetric(stream, range);
    let friction = factor(scatter.friction);
    let lattice = &task.lattice;
    let (edges, scale) = (lattice.edges.iter(), lattice.scale);
    let variation = Variation {
        stiffness: edges.map(|_| factor(scatter.stiffness)).collect(),
        mass: (0..lattice.nodes()).map(|_| factor(scatter.mass)).collect(),
    };
    let rest = lattice.state_at_rest();
    let mut moved = |x: f64| x + symmetric(stream, scatter.start * scale);
    Domain {
        task: Cow::Owned(task.varied(variation, friction)),
        start: State {
            x: (rest.x.iter())
                .map(|&x| rest.dimension.map(x, &mut moved))
                .collect(),
            ..rest
        },
    }
}

/// Draws a sequence of [`COUNT`](GoalsSettings::COUNT) goals for the rollouts of `task`. The first one is ahead of the
/// payload at the start or behind it, as `ahead` says, if the settings allow both.
pub fn draw_goals(
    task: &Task,
    settings: &GoalsSettings,
    ahead: bool,
    stream: &mut ChaCha8Rng,
) -> Goals {
    let places = draw_places(settings, GoalsSettings::COUNT, ahead, stream);
    let rest = task.lattice.state_at_rest();
    let goal = |place: Vector<f64>| from_payload(task, &rest, place);
    let changes = GoalsSettings::changes(task.physics.steps);
    let later = changes.zip(&places[1..]);
    later.fold(Goals::at(goal(places[0])), |goals, (steps, &place)| {
        goals.then(steps, goal(place))
    })
}

/// Draws a single goal for a robot in the state `start`, ahead of its payload or behind it, as `ahead` says. The goal is
/// as far from the payload, along and across, as a goal of a [sequence](draw_goals) is from the goal before it.
pub(crate) fn draw_goal(
    task: &Task,
    start: &State<f64>,
    settings: &GoalsSettings,
    ahead: bool,
    stream: &mut ChaCha8Rng,
) -> Goals {
    let places = draw_places(settings, 2, ahead, stream);
    let way = places[1] - places[0];
    let along = way.forward().abs();
    let way = way.with_forward(if ahead { along } else { -along });
    Goals::at(from_payload(task, start, way))
}

/// Draws the places of a sequence of goals along the ground and across, in metres from the payload at the start.
fn draw_places(
    settings: &GoalsSettings,
    count: usize,
    ahead: bool,
    stream: &mut ChaCha8Rng,
) -> Vec<Vector<f64>> {
    let (mut last, apart) = (0.0, settings.apart());
    let mut draw = |side: Option<bool>| {
        let [low, high] = settings.along;
        // The places behind the last goal and those ahead of it, each with its length.
        let behind = [low, high.min(last - apart)];
        let beyond = [low.max(last + apart), high];
        let length = |[from, to]: [f64; 2]| (to - from).max(0.0);
        let share = length(behind) / (length(behind) + length(beyond));
        let [which, place] = [(); 2].map(|()| 0.5 + symmetric(stream, 0.5));
        let is_beyond = match side {
            Some(ahead) if share > 0.0 && share < 1.0 => ahead,
            _ => which >= share,
        };
        let [from, to] = if is_beyond { beyond } else { behind };
        last = from + (to - from) * place;
        last
    };
    let along: Vec<f64> = (0..count)
        .map(|k| draw((k == 0).then_some(ahead)))
        .collect();
    let [low, high] = settings.across;
    let mut across = || match high > low {
        true => 0.5 * (low + high) + symmetric(stream, 0.5 * (high - low)),
        false => low,
    };
    let places = along.into_iter();
    places
        .map(|along| Vector::new([along, across(), 0.0]))
        .collect()
}

/// The point in the ground's frame that is `way` away from the payload in the state `start`, along the ground and across. It
/// is as high as the payload is at rest.
fn from_payload(task: &Task, start: &State<f64>, way: Vector<f64>) -> Vector<f64> {
    let payload = |state: &State<f64>| task.lattice.payload_point(state, &task.ground());
    let up = payload(&task.lattice.state_at_rest()).up();
    (payload(start) + way).with_up(up)
}

/// Draws several [variations](draw) of `task`, one after the other.
pub(crate) fn draw_many(
    task: &Task,
    scatter: &Scatter,
    count: usize,
    mut stream: ChaCha8Rng,
) -> Vec<Domain<'static>> {
    (0..count)
        .map(|_| draw(task, scatter, &mut stream))
        .collect()
}

/// Moves every coordinate of the positions in `start` up or down at random, by `distance` (m).
pub fn perturbed(start: &State<f64>, distance: f64, stream: &mut ChaCha8Rng) -> State<f64> {
    let mut moved = |x: f64| x + distance.copysign(symmetric(stream, 1.0));
    State {
        x: (start.x.iter())
            .map(|&x| start.dimension.map(x, &mut moved))
            .collect(),
        ..start.clone()
    }
}
