//! The state of a robot: positions and velocities, which change in a rollout.

use autodiff::Real;
use serde::{Deserialize, Serialize};

use crate::geometry::{Ground, Vector, columns, from_columns};

/// Positions (m) and velocities (m/s) of the nodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(
    serialize = "Vector<R, D>: Serialize",
    deserialize = "Vector<R, D>: Deserialize<'de>"
))]
pub struct State<R, const D: usize = 2> {
    /// The positions, one per node.
    pub x: Vec<Vector<R, D>>,
    /// The velocities, one per node.
    pub v: Vec<Vector<R, D>>,
}

impl<R: Real, const D: usize> State<R, D> {
    /// Converts this state from the world's frame to the ground's frame.
    #[must_use]
    pub fn to_ground(&self, ground: &Ground) -> Self {
        Self {
            x: self.x.iter().map(|&x| ground.point_to_ground(x)).collect(),
            v: self.v.iter().map(|&v| ground.vector_to_ground(v)).collect(),
        }
    }

    /// Converts this state from the ground's frame to the world's frame.
    #[must_use]
    pub fn to_world(&self, ground: &Ground) -> Self {
        Self {
            x: self.x.iter().map(|&x| ground.point_to_world(x)).collect(),
            v: self.v.iter().map(|&v| ground.vector_to_world(v)).collect(),
        }
    }
}

impl<R, const D: usize> State<R, D> {
    /// The state of nodes with the given positions (m) and velocities (m/s).
    pub fn new<P: Into<Vector<R, D>>, V: Into<Vector<R, D>>>(
        x: impl IntoIterator<Item = P>,
        v: impl IntoIterator<Item = V>,
    ) -> Self {
        Self {
            x: x.into_iter().map(Into::into).collect(),
            v: v.into_iter().map(Into::into).collect(),
        }
    }
}

impl<R: Copy, const D: usize> State<R, D> {
    /// The state as a flat list of numbers, in the order in which rollouts store it. First come the components of the
    /// positions as columns (see [`columns`]), then the components of the velocities.
    pub fn to_columns(&self) -> Vec<R> {
        [columns(&self.x), columns(&self.v)].concat()
    }

    /// Makes a state from numbers in the order of [`to_columns`](Self::to_columns). The numbers may belong to all nodes
    /// of a robot or only to its first nodes.
    pub fn from_columns(numbers: &[R]) -> Self {
        let (x, v) = numbers.split_at(numbers.len() / 2);
        Self {
            x: from_columns(x),
            v: from_columns(v),
        }
    }

    /// A copy of the state with `f` applied to every number.
    pub fn map<S>(&self, f: impl Fn(R) -> S) -> State<S, D> {
        State {
            x: self.x.iter().map(|x| x.map(&f)).collect(),
            v: self.v.iter().map(|v| v.map(&f)).collect(),
        }
    }
}
