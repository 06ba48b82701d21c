//! The motions of intermediate designs, sampled coarsely for an animation.

use crate::geometry::{Dimension, Vector};
use crate::lattice::State;
use crate::world::Trajectory;
use serde::{Deserialize, Serialize};

/// The number of moments per second at which the motion of a robot is sampled.
const FRAMES: f64 = 12.0;
/// Only this many seconds from the beginning of a rollout are kept.
const SECONDS: f64 = 8.0;
/// Positions are rounded to multiples of the lattice's spacing divided by this number.
const PARTS: f64 = 200.0;

/// The rounded positions of all nodes at some moments of a rollout.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frames {
    /// Time from one moment to the next, in seconds. The first moment is the start of the rollout.
    pub every: f64,
    /// The unit of `counts`, in metres.
    pub unit: f64,
    /// The number of coordinates of a node.
    #[serde(rename = "axes", default, skip_serializing_if = "is_plane")]
    pub dimension: Dimension,
    /// For every moment, the coordinates of every node, in multiples of `unit`. At the first moment they are the position of
    /// the node; later they are the change of its position since the moment before.
    pub counts: Vec<Vec<i64>>,
}

fn is_plane(dimension: &Dimension) -> bool {
    *dimension == Dimension::Plane
}

impl Frames {
    /// The moments at which a rollout of `steps` steps of `dt` seconds is sampled. A moment is given as the number of
    /// steps before it. There are twelve moments per second, or one after every step if a second has fewer than twelve
    /// steps.
    pub fn moments(steps: usize, dt: f64) -> Vec<usize> {
        let every = ((1.0 / (FRAMES * dt)).round() as usize).max(1);
        let last = steps.min((SECONDS / dt).round() as usize);
        (0..=last).step_by(every).collect()
    }

    /// The frames of the given states. `every` is the time between states in seconds. Positions are rounded to
    /// multiples of `unit` (metres). `None` if a position is not finite or too large.
    pub fn of<'s>(
        states: impl Iterator<Item = &'s State<f64>>,
        every: f64,
        unit: f64,
    ) -> Option<Self> {
        let mut states = states.peekable();
        let dimension = states
            .peek()
            .map_or(Dimension::Plane, |state| state.dimension);
        let count = |x: f64| {
            let count = (x / unit).round();
            // Numbers of this size and their differences are exact in f64.
            (count.abs() < 1e15).then_some(count as i64)
        };
        let places = |state: &State<f64>| dimension.flat(&state.x).into_iter().map(count).collect();
        let mut counts = states.map(places).collect::<Option<Vec<Vec<i64>>>>()?;
        for k in (1..counts.len()).rev() {
            let (before, from_here) = counts.split_at_mut(k);
            let pairs = from_here[0].iter_mut().zip(&before[k - 1]);
            pairs.for_each(|(now, before)| *now -= before);
        }
        Some(Self {
            every,
            unit,
            dimension,
            counts,
        })
    }

    /// The frames of a trajectory that was observed at its [moments](Self::moments). `dt` is the time step in seconds,
    /// `spacing` the spacing of the lattice in metres.
    pub(in crate::record) fn of_moments(
        seen: &Trajectory<f64>,
        dt: f64,
        spacing: f64,
    ) -> Option<Self> {
        let steps = seen.steps.get(1).copied().unwrap_or(1);
        Self::of(seen.states.iter(), steps as f64 * dt, spacing / PARTS)
    }

    /// The positions of all nodes at every moment, in metres.
    pub fn places(&self) -> Vec<Vec<Vector<f64>>> {
        let mut at = vec![0; self.counts.first().map_or(0, Vec::len)];
        let place = |moved: &Vec<i64>| {
            at.iter_mut()
                .zip(moved)
                .for_each(|(at, moved)| *at += moved);
            let places: Vec<f64> = at.iter().map(|&count| count as f64 * self.unit).collect();
            self.dimension.from_flat(&places)
        };
        self.counts.iter().map(place).collect()
    }
}
