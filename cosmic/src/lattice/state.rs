//! The state of a robot: positions and velocities, which change in a rollout.

use autodiff::{Parameters, Real};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::geometry::{Dimension, Ground, Row, Vector};

/// Positions (m) and velocities (m/s) of the nodes. In files, each is a list of two or three numbers per node.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct State<R> {
    /// Whether the nodes are in the plane or in space.
    pub dimension: Dimension,
    /// The positions, one per node.
    pub x: Vec<Vector<R>>,
    /// The velocities, one per node.
    pub v: Vec<Vector<R>>,
}

impl<R: Real> State<R> {
    /// Converts this state from the world's frame to the ground's frame.
    #[must_use]
    pub fn to_ground(&self, ground: &Ground) -> Self {
        Self {
            dimension: self.dimension,
            x: self.x.iter().map(|&x| ground.vector_to_ground(x)).collect(),
            v: self.v.iter().map(|&v| ground.vector_to_ground(v)).collect(),
        }
    }

    /// Converts this state from the ground's frame to the world's frame.
    #[must_use]
    pub fn to_world(&self, ground: &Ground) -> Self {
        Self {
            dimension: self.dimension,
            x: self.x.iter().map(|&x| ground.vector_to_world(x)).collect(),
            v: self.v.iter().map(|&v| ground.vector_to_world(v)).collect(),
        }
    }

    /// The state of a planar robot whose nodes have the given positions (m) and velocities (m/s).
    pub fn new<P: Into<Vector<R>>, V: Into<Vector<R>>>(
        x: impl IntoIterator<Item = P>,
        v: impl IntoIterator<Item = V>,
    ) -> Self {
        Self {
            dimension: Dimension::Plane,
            x: x.into_iter().map(Into::into).collect(),
            v: v.into_iter().map(Into::into).collect(),
        }
    }

    /// Makes a state from numbers in the order of [`to_columns`](Self::to_columns). The numbers may belong to all nodes
    /// of a robot or only to its first nodes.
    pub fn from_columns(dimension: Dimension, numbers: &[R]) -> Self {
        let (x, v) = numbers.split_at(numbers.len() / 2);
        Self {
            dimension,
            x: dimension.from_columns(x),
            v: dimension.from_columns(v),
        }
    }

    /// Makes a state from lists of the positions and of the velocities, node by node.
    pub fn from_flat(dimension: Dimension, [x, v]: [&[R]; 2]) -> Self {
        Self {
            dimension,
            x: dimension.from_flat(x),
            v: dimension.from_flat(v),
        }
    }
}

impl<R: Copy> State<R> {
    /// The state as a flat list of numbers, in the order in which rollouts store it. First come the components of the
    /// positions as [columns](Dimension::columns), then the components of the velocities.
    pub fn to_columns(&self) -> Vec<R> {
        let Self { dimension, x, v } = self;
        [dimension.columns(x), dimension.columns(v)].concat()
    }

    /// The positions and the velocities, each as one list, node by node.
    pub fn to_flat(&self) -> [Vec<R>; 2] {
        [&self.x, &self.v].map(|points| self.dimension.flat(points))
    }
}

/// A state in a file.
#[derive(Serialize, Deserialize)]
struct Rows {
    x: Vec<Row>,
    v: Vec<Row>,
}

impl Serialize for State<f64> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let rows = |points: &[Vector<f64>]| self.dimension.rows(points);
        let (x, v) = (rows(&self.x), rows(&self.v));
        Rows { x, v }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for State<f64> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Rows { x, v } = Rows::deserialize(deserializer)?;
        let dimension = Dimension::of_rows(x.iter().chain(&v)).map_err(D::Error::custom)?;
        let points = |rows: Vec<Row>| rows.iter().map(|row| dimension.vector(row)).collect();
        Ok(Self {
            dimension,
            x: points(x),
            v: points(v),
        })
    }
}
