//! A bound on the frequencies of every design of a lattice.

use std::collections::HashMap;
use std::sync::Arc;

use super::robot::{MaterialSettings, PhysicsSettings};
use crate::lattice::{Body, Lattice, Marker};
use crate::laws::{Force, Pose, Stiffness};

/// The number of intervals into which the range of a share is divided: the share of the actuator material in a mixture,
/// from 0 to 1.
const PARTS: usize = 16;

/// The place of the actuator material in [`MaterialSettings`].
const ACTUATOR: usize = 2;

/// A bound on the angular frequencies, 1/s, with which a lattice at rest vibrates. It holds for every design of the
/// lattice, whether a layout or mixtures.
///
/// A node carries half of the mass of each of its edges. So `mu_i` of [`Vibration::edge_bound`] is at most the largest
/// `2 k / (density l)` of the edges at node `i`, and at most the sum of their stiffnesses divided by
/// `physics.node_mass`. Other forces add [their own bound](Force::any_design).
///
/// [`Vibration::edge_bound`]: crate::simulator::stability::Vibration::edge_bound
pub fn bound_of_any_design(
    lattice: &Lattice,
    materials: &MaterialSettings,
    physics: &PhysicsSettings,
) -> f64 {
    let forces = physics.forces_on(lattice);
    let mut edges_of = vec![(0.0_f64, 0.0); lattice.nodes()];
    // The edges of a generated lattice have only a few lengths.
    let mut of_length = HashMap::new();
    for (ends, &length) in lattice.edges.iter().zip(&lattice.rest_length) {
        let Most { stiffness, ratio } = *of_length
            .entry(length.to_bits())
            .or_insert_with(|| most_of_any_mixture(materials, &forces, length));
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

/// A bound on what the forces on single nodes add to the square of a frequency at rest, 1/s^2. It is the same for all
/// designs, because it does not depend on the bars.
fn of_nodes(lattice: &Lattice, physics: &PhysicsSettings, forces: &[Arc<dyn Force>]) -> f64 {
    let edges = lattice.edges.len();
    let body = Body {
        stiffness: vec![0.0; edges],
        strain: vec![0.0; edges],
        mass: vec![physics.node_mass; lattice.nodes()],
        presence: Vec::new(),
        marker: Marker::default(),
    };
    let at_rest = lattice.state_at_rest();
    let pose = Pose::idle(lattice, &body, &at_rest, &physics.into());
    let mut stiffness = Stiffness::none(lattice.nodes(), edges);
    forces
        .iter()
        .for_each(|force| force.stiffen(&pose, &mut stiffness));
    stiffness.of_nodes(physics.node_mass)
}

/// Bounds on the numbers of an edge that hold for every mixture of materials.
#[derive(Clone, Copy, Default)]
struct Most {
    /// Stiffness, N/m.
    stiffness: f64,
    /// Stiffness divided by density.
    ratio: f64,
}

/// Computes bounds on the stiffness of an edge of this length, and on its stiffness divided by its density. The bounds
/// hold for every mixture.
fn most_of_any_mixture(
    materials: &MaterialSettings,
    forces: &[Arc<dyn Force>],
    length: f64,
) -> Most {
    let stroke = materials.max_strain[ACTUATOR] * length;
    let mut most = Most::default();
    for other in 0..materials.stiffness.len() {
        // If the share of actuator is between two values, the ratio of stiffness and density is between the ratios at
        // these values, and a spring is at most as stiff as at the larger value.
        for part in 1..=PARTS {
            let [less, more] = [part - 1, part].map(|part| part as f64 / PARTS as f64);
            for share in [less, more] {
                let mean = |property: &[f64; 3]| {
                    (1.0 - share) * property[other] + share * property[ACTUATOR]
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
                most.stiffness = most.stiffness.max(stiffness);
                most.ratio = most.ratio.max(ratio);
            }
        }
    }
    most
}
