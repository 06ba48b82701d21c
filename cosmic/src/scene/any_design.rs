//! A bound on the frequencies of every design of a lattice.

use std::collections::HashMap;
use std::sync::Arc;

use super::robot::{MaterialSettings, PhysicsSettings};
use super::stable_step::stable_step;
use crate::lattice::{Body, Lattice, Marker};
use crate::laws::{Force, Pose, Stiffness};

/// The number of intervals into which the range of a share is divided: the share of the actuator material in a mixture,
/// from 0 to 1.
const PARTS: usize = 16;

/// The place of the actuator material in [`MaterialSettings`].
const ACTUATOR: usize = 2;

/// Bounds that hold for every design of a lattice at rest, whether a layout or mixtures.
#[derive(Clone, Copy, Debug)]
pub struct AnyDesign {
    /// A bound on the angular frequencies with which the lattice vibrates, 1/s.
    pub frequency: f64,
    /// A bound on the rate at which forces that depend on velocities dampen a vibration, 1/s. The damping by
    /// `physics.damping` is not included.
    pub damping: f64,
}

impl AnyDesign {
    /// Computes the bounds.
    ///
    /// A node carries half of the mass of each of its edges. So `mu_i` of [`Vibration::edge_bound`] is at most the
    /// largest `2 k / (density l)` of the edges at node `i`, and at most the sum of their stiffnesses divided by
    /// `physics.node_mass`. Other forces add [their own bound](Force::any_design). The bound on the damping follows in
    /// the same way from [`Vibration::damping`].
    ///
    /// [`Vibration::edge_bound`]: crate::simulator::stability::Vibration::edge_bound
    /// [`Vibration::damping`]: crate::simulator::stability::Vibration::damping
    pub fn of(lattice: &Lattice, materials: &MaterialSettings, physics: &PhysicsSettings) -> Self {
        let forces = physics.forces_on(lattice);
        let on_nodes = OnNodes::of(lattice, physics, &forces);
        let stiffness = |k, length, off| sum(&forces, |force| force.bar_stiffness(k, length, off));
        let damping = |k, length, off| sum(&forces, |force| force.bar_damping(k, length, off));
        let mu = per_mass_of_nodes(lattice, materials, physics, &stiffness);
        let rates = per_mass_of_nodes(lattice, materials, physics, &damping);
        let sums = lattice.edges.iter().map(|&[i, j]| mu[i] + mu[j]);
        let of_edges = sums.fold(0.0, f64::max);
        let shortest = lattice.rest_length.iter().copied().fold(f64::MAX, f64::min);
        let largest = mu.into_iter().fold(0.0, f64::max);
        let others = sum(&forces, |force| force.any_design(largest, shortest));
        Self {
            frequency: (of_edges + others + on_nodes.stiffness).sqrt(),
            damping: 2.0 * rates.into_iter().fold(0.0, f64::max) + on_nodes.damping,
        }
    }

    /// Below this time step, s, no vibration of any design grows, nor of a robot that vibrates `faster` times as fast
    /// as a design. Infinite if nothing vibrates. `physics.dt` is ignored.
    pub fn stable_step(&self, physics: &PhysicsSettings, faster: f64) -> f64 {
        // A node that vibrates faster by a factor is lighter by the square of the factor, so its damping is larger by
        // that square.
        stable_step(physics, faster * self.frequency, faster * faster * self.damping)
    }
}

fn sum(forces: &[Arc<dyn Force>], of: impl Fn(&dyn Force) -> f64) -> f64 {
    forces.iter().map(|force| of(&**force)).sum()
}

/// A number of a bar: its stiffness (N/m) or its damping (N s/m), as a function of the stiffness of its material (N/m),
/// its rest length (m), and its length minus its target length (m).
type OfBar<'a> = dyn Fn(f64, f64, f64) -> f64 + 'a;

/// For each node, a bound on the sum of a number of its bars, divided by the mass of the node. It holds for every
/// design.
fn per_mass_of_nodes(
    lattice: &Lattice,
    materials: &MaterialSettings,
    physics: &PhysicsSettings,
    of_bar: &OfBar,
) -> Vec<f64> {
    let mut edges_of = vec![(0.0_f64, 0.0); lattice.nodes()];
    // The edges of a generated lattice have only a few lengths.
    let mut of_length = HashMap::new();
    for (ends, &length) in lattice.edges.iter().zip(&lattice.rest_length) {
        let Most { number, ratio } = *of_length
            .entry(length.to_bits())
            .or_insert_with(|| most_of_any_mixture(materials, of_bar, length));
        for &node in ends {
            let (largest, sum) = edges_of[node];
            edges_of[node] = (largest.max(2.0 * ratio / length), sum + number);
        }
    }
    let per_mass = |(ratio, sum): (f64, f64)| ratio.min(sum / physics.node_mass);
    edges_of.into_iter().map(per_mass).collect()
}

/// Bounds on what the forces on single nodes add. They are the same for all designs, because they do not depend on the
/// bars.
struct OnNodes {
    /// The part of the square of a frequency at rest, 1/s^2.
    stiffness: f64,
    /// The part of the rate of damping, 1/s.
    damping: f64,
}

impl OnNodes {
    fn of(lattice: &Lattice, physics: &PhysicsSettings, forces: &[Arc<dyn Force>]) -> Self {
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
        let damping = stiffness.node_damping.iter().copied().fold(0.0, f64::max);
        Self {
            stiffness: stiffness.of_nodes(physics.node_mass),
            damping: damping / physics.node_mass,
        }
    }
}

/// Bounds on a number of an edge that hold for every mixture of materials.
#[derive(Clone, Copy, Default)]
struct Most {
    /// The number.
    number: f64,
    /// The number divided by the density.
    ratio: f64,
}

/// Computes bounds on a number of an edge of this length, and on the number divided by the edge's density. The bounds
/// hold for every mixture.
fn most_of_any_mixture(materials: &MaterialSettings, of_bar: &OfBar, length: f64) -> Most {
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
                let number = of_bar(mean(&materials.stiffness), length, more * stroke);
                let density = mean(&materials.density);
                let ratio = if number > 0.0 { number / density } else { 0.0 };
                most.number = most.number.max(number);
                most.ratio = most.ratio.max(ratio);
            }
        }
    }
    most
}
