//! The energy that springs and masses hold, for those who watch that it is kept.

use super::bending::{AngularSpring, Bending};
use super::kernels::SOFTENING;
use crate::lattice::{Lattice, State};
use crate::projection::Body;
use crate::scene::PhysicsSettings;

/// A store of energy in a robot whose actuators are at rest.
pub struct Store<'a> {
    lattice: &'a Lattice,
    body: &'a Body<f64>,
    /// The cubic coefficient of the springs, 1/m^2.
    stiffening: f64,
    /// The bars that resist bending.
    bars: Vec<AngularSpring>,
}

impl<'a> Store<'a> {
    /// The springs and masses of a body on a lattice.
    pub fn new(lattice: &'a Lattice, physics: &PhysicsSettings, body: &'a Body<f64>) -> Self {
        let bending = Bending::new(lattice, physics.bending_radius);
        Self {
            lattice,
            body,
            stiffening: physics.stiffening,
            bars: bending.map_or(Vec::new(), |bending| bending.springs(&body.stiffness)),
        }
    }

    /// Kinetic energy and that of springs and bars, J: of what the simulator's forces are the slope.
    pub fn energy(&self, state: &State<f64>) -> f64 {
        let speeds = state.v.iter().zip(&self.body.mass);
        let kinetic: f64 = speeds
            .map(|([vx, vy], m)| 0.5 * m * (vx * vx + vy * vy))
            .sum();
        let edges = self.lattice.edges.iter().zip(&self.body.stiffness);
        let springs = (edges.zip(&self.lattice.rest_length)).map(|((&edge, k), rest)| {
            let change = length(&state.x, edge) - rest;
            let square = change * change;
            // The integral of k (e + c e^3).
            0.5 * k * square * (1.0 + 0.5 * self.stiffening * square)
        });
        let bars = self.bars.iter().map(|&AngularSpring { nodes, stiffness }| {
            let [before, middle, after] = nodes;
            let [ax, ay] = direction(&state.x, [before, middle]);
            let [bx, by] = direction(&state.x, [middle, after]);
            // 1 - cos(a), without taking numbers near 1 from each other.
            0.5 * stiffness * ((ax - bx) * (ax - bx) + (ay - by) * (ay - by))
        });
        kinetic + springs.sum::<f64>() + bars.sum::<f64>()
    }
}

/// The unit vector along an edge.
fn direction(x: &[[f64; 2]], edge: [usize; 2]) -> [f64; 2] {
    let length = length(x, edge);
    span(x, edge).map(|d| d / length)
}

/// The length of an edge, m, as the springs have it (D4).
pub fn length(x: &[[f64; 2]], edge: [usize; 2]) -> f64 {
    let [dx, dy] = span(x, edge);
    (dx * dx + dy * dy + SOFTENING).sqrt()
}

fn span(x: &[[f64; 2]], [i, j]: [usize; 2]) -> [f64; 2] {
    [0, 1].map(|k| x[j][k] - x[i][k])
}
