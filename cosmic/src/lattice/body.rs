//! The types [`Body`], stiffnesses, strains and masses of a robot, and [`Marker`], the point whose displacement counts.

use autodiff::{Parameters, Real};

use super::State;
use crate::geometry::{Vector, weighted_mean};

/// The numbers of a robot that stay constant during a rollout.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Body<R> {
    /// The stiffness of each edge, in N/m.
    pub stiffness: Vec<R>,
    /// For each edge, the relative change of its rest length at full activation (D8).
    pub strain: Vec<R>,
    /// The [largest strain](crate::scene::MaterialSettings::largest_strain) of the actuator material.
    pub largest_strain: f64,
    /// The rest length of each edge, in m. Empty if the edges have the rest lengths of the lattice.
    pub rest_length: Vec<R>,
    /// The mass of each node, in kg.
    pub mass: Vec<R>,
    /// The presence of each node, from 0 to 1: its weight in the mean position and in the observation. A node without a
    /// bar has presence 0. Empty if all nodes have presence 1.
    pub presence: Vec<R>,
    /// The marker whose displacement counts as the displacement of the robot.
    pub marker: Marker<R>,
}

/// The point of a robot whose displacement counts (`objective.body`): the payload, or a point that begins at the
/// payload and moves like a weighted mean of the nodes.
///
/// The weights may depend on the design. Because the point always begins at the payload, a design gains nothing if it
/// only moves weight to nodes that are farther ahead.
#[derive(Clone, Debug, Default, PartialEq, Parameters)]
pub struct Marker<R> {
    /// The node of the payload.
    pub payload: usize,
    /// The weight of each node, in kg for the centre of mass. Empty if the point is the payload.
    pub weights: Vec<R>,
}

/// The names of the numbers that [`Body::scale`] multiplies: those of all edges (`bars`) and of all nodes.
pub const SCALABLE: [&str; 4] = [
    "bars.stiffness",
    "bars.strain",
    "bars.rest_length",
    "nodes.mass",
];

impl<R: Real> Body<R> {
    /// Multiplies the numbers of this name by factors: one for each edge or node, or a single one for all. `rest_length` has
    /// the rest lengths of the lattice, m. Returns false, and does nothing, if the name is not one of [`SCALABLE`].
    pub fn scale(&mut self, name: &str, factors: &[R], rest_length: &[f64]) -> bool {
        let numbers = match name {
            "bars.stiffness" => &mut self.stiffness,
            "bars.strain" => &mut self.strain,
            "bars.rest_length" => {
                if self.rest_length.is_empty() {
                    self.rest_length = R::lits(rest_length);
                }
                &mut self.rest_length
            }
            "nodes.mass" => &mut self.mass,
            _ => return false,
        };
        for (number, &factor) in numbers.iter_mut().zip(factors.iter().cycle()) {
            *number *= factor;
        }
        true
    }
}

impl<R> Marker<R> {
    /// How many nodes a state must hold, beginning with node 0, so that the marker can be found in it.
    pub fn nodes(&self) -> usize {
        if self.weights.is_empty() {
            self.payload + 1
        } else {
            self.weights.len()
        }
    }
}

impl<R: Real> Marker<R> {
    /// The place of the marker (m) in a state of a rollout that began with the nodes at the places `start`. `start` is
    /// not read if the marker is the payload.
    ///
    /// # Panics
    /// If the state or `start` holds too few [`nodes`](Self::nodes).
    pub fn place(&self, start: &[Vector<R>], state: &State<R>) -> Vector<R> {
        if self.weights.is_empty() {
            return state.x[self.payload];
        }
        let moved: Vec<_> = (0..self.weights.len())
            .map(|node| state.x[node] - start[node])
            .collect();
        start[self.payload] + weighted_mean(&moved, &self.weights)
    }

    /// The velocity of the marker in a state, in m/s.
    ///
    /// # Panics
    /// If the state holds too few [`nodes`](Self::nodes).
    pub fn velocity(&self, state: &State<R>) -> Vector<R> {
        if self.weights.is_empty() {
            return state.v[self.payload];
        }
        weighted_mean(&state.v, &self.weights)
    }
}
