//! The frequencies that any design of a lattice may have.

use std::sync::Arc;

use crate::design::Material;
use crate::lattice::{Body, Lattice};
use crate::laws::{Force, Pose, Stiffness};
use crate::scene::{MaterialSettings, PhysicsSettings};

/// Parts of the shares that an actuator can have.
const PARTS: usize = 16;

/// A bound on the angular frequencies, 1/s, of every design of a lattice at rest, of layouts and
/// mixtures.
///
/// A node has half of its edges' mass: `mu_i` of [`Vibration::edge_bound`](super::Vibration::edge_bound) is at
/// most the largest `2 k / (density l)` of its edges, and at most their stiffness over the mass that is no edge's.
/// What is no bar's adds [its own bound](Force::any_design).
pub fn bound_of_any_design(
    lattice: &Lattice,
    materials: &MaterialSettings,
    physics: &PhysicsSettings,
) -> f64 {
    let forces = physics.forces_on(lattice);
    let mut edges_of = vec![(0.0_f64, 0.0); lattice.nodes()];
    for (ends, &length) in lattice.edges.iter().zip(&lattice.rest_length) {
        let [stiffness, ratio] = most_of_any_mixture(materials, &forces, length);
        for &node in ends {
            let (largest, sum) = edges_of[node];
            edges_of[node] = (largest.max(2.0 * ratio / length), sum + stiffness);
        }
    }
    let mu = |(ratio, sum): (f64, f64)| ratio.min(sum / physics.node_mass);
    let mu: Vec<f64> = edges_of.into_iter().map(mu).collect();
    let sums = lattice.edges.iter().map(|&[i, j]| mu[i] + mu[j]);
    let of_edges = sums.fold(0.0, f64::max);
    let shortest = lattice.rest_length.iter().copied().fold(f64::MAX, f64::min);
    let largest = mu.into_iter().fold(0.0, f64::max);
    let others = forces
        .iter()
        .map(|force| force.any_design(largest, shortest));
    (of_edges + others.sum::<f64>() + of_nodes(lattice, physics, &forces)).sqrt()
}

/// What forces on single nodes add where the lattice rests, 1/s^2: its bars have no part in that.
fn of_nodes(lattice: &Lattice, physics: &PhysicsSettings, forces: &[Arc<dyn Force>]) -> f64 {
    let edges = lattice.edges.len();
    let body = Body {
        stiffness: vec![0.0; edges],
        strain: vec![0.0; edges],
        mass: vec![physics.node_mass; lattice.nodes()],
        presence: Vec::new(),
    };
    let pose = Pose {
        lattice,
        body: &body,
        state: &lattice.state_at_rest(),
        activation: &[],
        time: 0.0,
    };
    let mut stiffness = Stiffness::none(lattice.nodes(), edges);
    forces
        .iter()
        .for_each(|force| force.stiffen(&pose, &mut stiffness));
    stiffness.of_nodes(physics.node_mass)
}

/// The most that an edge of some length can have of stiffness, N/m, and of that over its density.
fn most_of_any_mixture(
    materials: &MaterialSettings,
    forces: &[Arc<dyn Force>],
    length: f64,
) -> [f64; 2] {
    let stroke = Material::Actuator.of(&materials.max_strain) * length;
    let mut most = [0.0_f64; 2];
    for other in Material::ALL {
        // Between two shares of actuator the ratio of sums is between those at them, and a spring
        // is at most as stiff as with the larger one.
        for part in 1..=PARTS {
            let [less, more] = [part - 1, part].map(|part| part as f64 / PARTS as f64);
            for share in [less, more] {
                let mean = |property: &[f64; 3]| {
                    (1.0 - share) * other.of(property) + share * Material::Actuator.of(property)
                };
                let k = mean(&materials.stiffness);
                let of = |force: &Arc<dyn Force>| force.bar_stiffness(k, length, more * stroke);
                let stiffness: f64 = forces.iter().map(of).sum();
                let density = mean(&materials.density);
                let ratio = if stiffness > 0.0 {
                    stiffness / density
                } else {
                    0.0
                };
                most = [most[0].max(stiffness), most[1].max(ratio)];
            }
        }
    }
    most
}
