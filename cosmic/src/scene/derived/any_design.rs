//! A bound on the frequencies of every design of a lattice.

use std::collections::HashMap;
use std::sync::Arc;

use super::stable_step::{stable_step, stable_step_off_bars};
use crate::lattice::{Body, Lattice, Marker, Material};
use crate::laws::{Force, Pose, RestingBar, Stiffness};
use crate::scene::sections::PhysicsSettings;
use crate::scene::sections::{BarNumbers, MaterialSettings};

/// The number of intervals into which the range of a share is divided: the share of the actuator material in a mixture,
/// from 0 to 1.
const PARTS: usize = 64;

/// The largest number of iterations for the stable step; five are almost always enough.
const ITERATIONS: usize = 50;

/// The relative accuracy of the stable step.
const TOLERANCE: f64 = 1e-4;

/// Bounds that hold for every design of a lattice at rest, whether a layout or mixtures.
pub struct AnyDesign<'a> {
    lattice: &'a Lattice,
    materials: &'a MaterialSettings,
    physics: &'a PhysicsSettings,
    forces: Vec<Arc<dyn Force>>,
    on_nodes: NodeBounds,
}

impl<'a> AnyDesign<'a> {
    /// Prepares the bounds. `physics.dt` is ignored.
    pub fn new(
        lattice: &'a Lattice,
        materials: &'a MaterialSettings,
        physics: &'a PhysicsSettings,
    ) -> Self {
        let forces = physics.forces_on(lattice);
        Self {
            on_nodes: NodeBounds::of(lattice, physics, &forces),
            lattice,
            materials,
            physics,
            forces,
        }
    }

    /// A bound on the angular frequencies with which the lattice vibrates, 1/s.
    ///
    /// A node carries half of the mass of each of its edges. So `mu_i` of [`Vibration::edge_bound`] is at most the
    /// largest `2 k / (density l)` of the edges at node `i`, and at most the sum of their stiffnesses divided by
    /// `physics.node_mass`. Other forces add [their own bound](Force::any_design).
    ///
    /// [`Vibration::edge_bound`]: crate::world::stability::Vibration::edge_bound
    pub fn frequency(&self) -> f64 {
        self.frequencies_in_steps(f64::INFINITY)[0]
    }

    /// Below this time step, s, no vibration of any design grows, nor of a robot that vibrates `faster` times as fast
    /// as a design. Infinite if nothing vibrates.
    pub fn stable_step(&self, faster: f64) -> f64 {
        let substeps = self.physics.substeps as f64;
        let stable = |dt: f64| {
            let [all, off_bars] = self.frequencies_in_steps(dt / substeps);
            let limit = stable_step(self.physics, faster * all, 0.0);
            limit.min(stable_step_off_bars(self.physics, faster * off_bars, 0.0))
        };
        // A longer step makes damping add less to the frequency, so the iteration approaches the limit from above.
        let mut dt = stable(f64::INFINITY);
        for _ in 0..ITERATIONS {
            let shorter = stable(dt);
            if shorter >= (1.0 - TOLERANCE) * dt {
                return shorter * (1.0 - TOLERANCE);
            }
            dt = shorter;
        }
        dt
    }

    /// Bounds on the frequencies that all forces cause, and on those that the forces off the bars cause. They include the
    /// damping in mechanical steps of `dt` (s). In such a step, damping at
    /// a rate `d` makes a vibration of frequency `omega` grow if an undamped vibration of the frequency
    /// `sqrt(omega^2 + 2 d / dt)` would grow ([`stable_step`]). So a bar with the damping `c` counts as if its stiffness
    /// were larger by `2 c / dt`.
    fn frequencies_in_steps(&self, dt: f64) -> [f64; 2] {
        let forces = &self.forces;
        let along = forces.iter().filter_map(|force| force.along_bars());
        let of_bar = |bar| {
            let stiffness: f64 = along.clone().map(|force| force.stiffness(bar)).sum();
            let damping: f64 = along.clone().map(|force| force.damping(bar)).sum();
            stiffness + 2.0 / dt * damping
        };
        let mu = per_mass_of_nodes(self.lattice, self.materials, self.physics, &of_bar);
        let sums = self.lattice.edges.iter().map(|&[i, j]| mu[i] + mu[j]);
        let of_edges = sums.fold(0.0, f64::max);
        let lengths = self.lattice.rest_length.iter().copied();
        let shortest = lengths.fold(f64::MAX, f64::min);
        let largest = mu.into_iter().fold(0.0, f64::max);
        let lightest = self.physics.node_mass;
        let others = forces
            .iter()
            .map(|force| force.any_design(largest, shortest, lightest));
        let others: f64 = others.sum();
        let on_nodes = self.on_nodes.stiffness + 2.0 / dt * self.on_nodes.damping;
        [of_edges + others + on_nodes, others + on_nodes].map(f64::sqrt)
    }
}

/// The stiffness of a bar, N/m.
type OfBar<'a> = dyn Fn(RestingBar) -> f64 + 'a;

/// For each node, a bound on the sum of the stiffnesses of its bars, divided by the mass of the node. It holds for every
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
    let edges = lattice.edges.iter().zip(&lattice.rest_length);
    for (edge, (ends, &length)) in edges.enumerate() {
        let bar = materials.of_edge(lattice, edge);
        let key = (length.to_bits(), bar.stiffness.map(f64::to_bits));
        let most = || most_of_any_mixture(materials, &bar, of_bar, length);
        let EdgeBounds { stiffness, ratio } = *of_length.entry(key).or_insert_with(most);
        for &node in ends {
            let (largest, sum) = edges_of[node];
            edges_of[node] = (largest.max(2.0 * ratio / length), sum + stiffness);
        }
    }
    let per_mass = |(ratio, sum): (f64, f64)| ratio.min(sum / physics.node_mass);
    edges_of.into_iter().map(per_mass).collect()
}

/// Bounds on what the forces on single nodes add. They are the same for all designs, because they do not depend on the
/// bars.
struct NodeBounds {
    /// The part of the square of a frequency at rest, 1/s^2.
    stiffness: f64,
    /// The part of the rate of damping, 1/s.
    damping: f64,
}

impl NodeBounds {
    fn of(lattice: &Lattice, physics: &PhysicsSettings, forces: &[Arc<dyn Force>]) -> Self {
        let edges = lattice.edges.len();
        let body = Body {
            stiffness: vec![0.0; edges],
            strain: vec![0.0; edges],
            largest_strain: 1.0,
            rest_length: Vec::new(),
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

/// Bounds on the numbers of an edge that hold for every mixture of materials.
#[derive(Clone, Copy, Default)]
struct EdgeBounds {
    /// Stiffness, N/m.
    stiffness: f64,
    /// Stiffness divided by density.
    ratio: f64,
}

/// Computes bounds on the stiffness of an edge with this `bar` and this length, and on its stiffness divided by its density. The bounds
/// hold for every mixture.
fn most_of_any_mixture(
    materials: &MaterialSettings,
    bar: &BarNumbers,
    of_bar: &OfBar,
    length: f64,
) -> EdgeBounds {
    let stroke = materials.actuator_strain() * length;
    let mut most = EdgeBounds::default();
    for other in Material::ALL {
        // If the share of actuator is between two values, the ratio of stiffness and density is between the ratios at
        // these values, and a spring is at most as stiff as at the larger value.
        for part in 1..=PARTS {
            let [less, more] = [part - 1, part].map(|part| part as f64 / PARTS as f64);
            for share in [less, more] {
                let mean = |property: &[f64; 3]| {
                    (1.0 - share) * other.of(property) + share * Material::Actuator.of(property)
                };
                let stiffness = of_bar(RestingBar {
                    stiffness: mean(&bar.stiffness),
                    rest_length: length,
                    off: more * stroke,
                    largest_strain: materials.largest_strain(),
                });
                let density = mean(&bar.density);
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
