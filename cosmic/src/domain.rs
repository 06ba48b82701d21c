//! Domain randomisation: draws random variations of a robot and its surroundings.

use std::borrow::Cow;

use rand::rngs::ChaCha8Rng;

use crate::lattice::State;
use crate::projection::Variation;
use crate::random::symmetric;
use crate::scene::RobustSettings;
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

/// Draws a random variation of `task`. The robot starts at rest, near its initial positions. Every number is drawn even
/// if its range is zero, so that switching one range off does not change the other draws.
pub fn draw(task: &Task, settings: &RobustSettings, stream: &mut ChaCha8Rng) -> Domain<'static> {
    let mut factor = |range: f64| 1.0 + symmetric(stream, range);
    let friction = factor(settings.friction);
    let lattice = &task.lattice;
    let edges = lattice.edges.iter();
    let variation = Variation {
        stiffness: edges.map(|_| factor(settings.stiffness)).collect(),
        mass: (0..lattice.nodes())
            .map(|_| factor(settings.mass))
            .collect(),
    };
    let rest = lattice.state_at_rest();
    let mut moved = |x: f64| x + symmetric(stream, settings.start);
    Domain {
        task: Cow::Owned(task.varied(variation, friction)),
        start: State {
            x: rest.x.iter().map(|x| x.map(&mut moved)).collect(),
            v: rest.v,
        },
    }
}

/// Moves every coordinate of the positions in `start` up or down at random, by `distance` (m).
pub fn perturbed(start: &State<f64>, distance: f64, stream: &mut ChaCha8Rng) -> State<f64> {
    let mut moved = |x: f64| x + distance.copysign(symmetric(stream, 1.0));
    State {
        x: start.x.iter().map(|x| x.map(&mut moved)).collect(),
        v: start.v.clone(),
    }
}
