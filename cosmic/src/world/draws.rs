//! Domain randomisation: draws random variations of a robot and its surroundings.

use std::sync::Arc;

use rand::rngs::ChaCha8Rng;

use super::base::World;
use super::robot::Variation;
use crate::geometry::Vector;
use crate::lattice::State;
use crate::laws::FRICTION;
use crate::policy::Goals;
use crate::random::symmetric;
use crate::scene::{GoalsSettings, Scatter};

/// Draws a random variation. The robot starts at rest, near its initial positions. Every number is drawn even if its range
/// is zero, so that switching one range off does not change the other draws.
pub fn draw(world: &World, scatter: &Scatter, stream: &mut ChaCha8Rng) -> Variation {
    let mut factor = |range: f64| 1.0 + symmetric(stream, range);
    let friction = factor(scatter.friction);
    let lattice = &world.lattice;
    let (edges, scale) = (lattice.edges.iter(), lattice.scale);
    let stiffness = edges.map(|_| factor(scatter.stiffness)).collect();
    let mass = (0..lattice.nodes()).map(|_| factor(scatter.mass)).collect();
    let rest = lattice.state_at_rest();
    let mut moved = |x: f64| x + symmetric(stream, scatter.start * scale);
    Variation {
        stiffness,
        mass,
        surroundings: Arc::new(world.surroundings().scaled(FRICTION, friction)),
        start: State {
            x: (rest.x.iter())
                .map(|&x| rest.dimension.map(x, &mut moved))
                .collect(),
            ..rest
        },
    }
}

/// Draws several [variations](draw), one after the other.
pub(crate) fn draw_many(
    world: &World,
    scatter: &Scatter,
    count: usize,
    mut stream: ChaCha8Rng,
) -> Vec<Variation> {
    (0..count)
        .map(|_| draw(world, scatter, &mut stream))
        .collect()
}

/// Draws a sequence of [`COUNT`](GoalsSettings::COUNT) goals for the rollouts of `world`. The first one is ahead of the
/// payload at the start or behind it, as `ahead` says, if the settings allow both.
pub fn draw_goals(
    world: &World,
    settings: &GoalsSettings,
    ahead: bool,
    stream: &mut ChaCha8Rng,
) -> Goals {
    let places = draw_places(settings, GoalsSettings::COUNT, ahead, stream);
    let rest = world.lattice.state_at_rest();
    let goal = |place: Vector<f64>| from_payload(world, &rest, place);
    let changes = GoalsSettings::changes(world.physics.steps);
    let later = changes.zip(&places[1..]);
    later.fold(Goals::at(goal(places[0])), |goals, (steps, &place)| {
        goals.then(steps, goal(place))
    })
}

/// Draws a single goal for a robot in the state `start`, ahead of its payload or behind it, as `ahead` says. The goal is
/// as far from the payload, along and across, as a goal of a [sequence](draw_goals) is from the goal before it.
pub(crate) fn draw_goal(
    world: &World,
    start: &State<f64>,
    settings: &GoalsSettings,
    ahead: bool,
    stream: &mut ChaCha8Rng,
) -> Goals {
    let places = draw_places(settings, 2, ahead, stream);
    let way = places[1] - places[0];
    let along = way.forward().abs();
    let way = way.with_forward(if ahead { along } else { -along });
    Goals::at(from_payload(world, start, way))
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
pub(crate) fn from_payload(world: &World, start: &State<f64>, way: Vector<f64>) -> Vector<f64> {
    let payload = |state: &State<f64>| world.lattice.payload_point(state, &world.ground());
    let up = payload(&world.lattice.state_at_rest()).up();
    (payload(start) + way).with_up(up)
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
