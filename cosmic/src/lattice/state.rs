//! The state that evolves in a rollout.

use autodiff::Real;
use serde::{Deserialize, Serialize};

use crate::ground::Ground;

/// Positions (m) and velocities (m/s) of the nodes, and nothing else.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State<R> {
    /// Positions, one per node.
    pub x: Vec<[R; 2]>,
    /// Velocities, one per node.
    pub v: Vec<[R; 2]>,
}

/// The unweighted mean of vectors.
pub(crate) fn mean<R: Real, const N: usize>(rows: &[[R; N]]) -> [R; N] {
    let share = R::lit(1.0 / rows.len() as f64);
    std::array::from_fn(|k| {
        let column: Vec<R> = rows.iter().map(|row| row[k]).collect();
        R::sum_of(&column) * share
    })
}

impl<R: Real> State<R> {
    /// A state of the world's frame in the ground's.
    pub fn to_ground(&self, ground: &Ground) -> Self {
        Self {
            x: self.x.iter().map(|&x| ground.point_to_ground(x)).collect(),
            v: self.v.iter().map(|&v| ground.vector_to_ground(v)).collect(),
        }
    }

    /// A state of the ground's frame in the world's.
    pub fn to_world(&self, ground: &Ground) -> Self {
        Self {
            x: self.x.iter().map(|&x| ground.point_to_world(x)).collect(),
            v: self.v.iter().map(|&v| ground.vector_to_world(v)).collect(),
        }
    }
}

impl<R: Copy> State<R> {
    /// Every number replaced by a function of it.
    pub fn map<S>(&self, f: impl Fn(R) -> S) -> State<S> {
        State {
            x: self.x.iter().map(|x| x.map(&f)).collect(),
            v: self.v.iter().map(|v| v.map(&f)).collect(),
        }
    }
}
