//! The projections from design vectors to mixtures of materials, and the body of a design.

use std::borrow::Cow;

use autodiff::Real;
use serde::{Deserialize, Serialize};

use crate::design::{Design, Material, Mixture, average_tied, filled, is_present};
use crate::geometry::{Vector, mean};
use crate::lattice::{Body, Lattice, Marker};
use crate::scene::{MaterialSettings, MovedBody, PhysicsSettings, ProjectionSettings, VoidEdges};

/// The projections of the paper from a design vector to a mixture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Projection {
    /// The softmax of each design vector, `softmax(beta z)`.
    Performance,
    /// Subtracts the mean of all design vectors from each design vector, and then applies a softmax. This softmax is so
    /// sharp that nearly every mixture is a single material, as in the final layout. Its derivative is replaced by that
    /// of a softer projection (straight-through).
    Stability,
}

/// Projects design vectors to mixtures of materials. It knows how sharp the projections of a scene are, and the
/// restrictions on the mixtures of a lattice's edges.
#[derive(Clone, Debug, PartialEq)]
pub struct Projector {
    settings: ProjectionSettings,
    /// For each edge, the amount that is subtracted from each entry of its design vector. The list is empty if all
    /// amounts are zero.
    amounts: Vec<[f64; 3]>,
    /// Groups of edges that share one design vector.
    ties: Vec<Vec<usize>>,
}

impl Projector {
    /// A projector without restrictions.
    pub fn free(settings: &ProjectionSettings) -> Self {
        Self {
            settings: settings.clone(),
            amounts: Vec::new(),
            ties: Vec::new(),
        }
    }

    /// A projector with the restrictions that a scene sets. With `hold_materials`, each edge keeps the solid material that
    /// it has in the filled layout: the value of that setting is subtracted from the entry of the other solid material. An
    /// edge has no share of a material that the rules of the lattice do not allow.
    pub fn new(settings: &ProjectionSettings, lattice: &Lattice) -> Self {
        let amount = settings.hold_materials;
        let rules = &lattice.rules;
        let free = Self {
            ties: rules.tie.clone(),
            ..Self::free(settings)
        };
        if amount == 0.0 && rules.allow_all() {
            return free;
        }
        let betas = [
            settings.beta,
            settings.beta_stability,
            settings.beta_straight_through,
        ];
        // The amount that makes a share vanish. After the mean is subtracted, entries differ by at most 2, and exp(-37)
        // is less than half of the last bit of 1.
        let never = 2.0 + 37.0 / betas.into_iter().fold(f64::INFINITY, f64::min);
        let hold = |(edge, own): (usize, Material)| {
            Material::ALL.map(|m| {
                let is_other = m.is_solid() && m != own;
                let held = if is_other { amount } else { 0.0 };
                if m.of(&rules.allowed(edge)) {
                    held
                } else {
                    never
                }
            })
        };
        let filled = filled(lattice).into_iter().enumerate();
        Self {
            amounts: filled.map(hold).collect(),
            ..free
        }
    }

    /// Projects the design vectors of a design. A layout (one material per edge) does not change (D7).
    pub fn projected(
        &self,
        projection: Projection,
        design: &Design<[f64; 3]>,
    ) -> Design<Mixture<f64>> {
        match design {
            Design::Undecided(z) => Design::Undecided(self.mixtures(projection, z)),
            Design::Layout(layout) => Design::Layout(layout.clone()),
        }
    }

    /// The mixture of every edge: positive shares of void, skeleton and actuator that sum to 1.
    ///
    /// The design vectors of edges that are tied together are replaced by their mean. Before every softmax, the amounts of
    /// the restrictions are subtracted from the design vectors. The stability projection first subtracts the mean of all
    /// design vectors: in the other order, the mean would cancel a part of the amounts.
    pub fn mixtures<R: Real>(&self, projection: Projection, z: &[[R; 3]]) -> Vec<Mixture<R>> {
        let (settings, z) = (&self.settings, &*self.tied(z));
        let lower = |edge: usize, z: [R; 3]| match self.amounts.get(edge) {
            Some(hold) => [0, 1, 2].map(|k| z[k] - R::lit(hold[k])),
            None => z,
        };
        let rows = z.iter().enumerate();
        match projection {
            Projection::Performance => rows
                .map(|(edge, &z)| Mixture(softmax(lower(edge, z), settings.beta)))
                .collect(),
            Projection::Stability => {
                let mean = mean(z);
                let project = |(edge, z): (usize, &[R; 3])| {
                    let centred = (Vector::new(*z) - mean).array();
                    let centred = lower(edge, centred);
                    let sharp = softmax(centred.map(R::detach), settings.beta_stability);
                    let soft = softmax(centred, settings.beta_straight_through);
                    Mixture([0, 1, 2].map(|k| sharp[k].straight_through(soft[k])))
                };
                rows.map(project).collect()
            }
        }
    }

    /// True if an amount is subtracted from the entry for `material` in the design vector of `edge`.
    pub fn is_held(&self, edge: usize, material: Material) -> bool {
        (self.amounts.get(edge)).is_some_and(|hold| material.of(hold) > 0.0)
    }

    /// The design vectors `z`. The vectors of edges that are tied together are replaced by their mean.
    fn tied<'z, R: Real>(&self, z: &'z [[R; 3]]) -> Cow<'z, [[R; 3]]> {
        let mut z = Cow::Borrowed(z);
        if !self.ties.is_empty() {
            average_tied(z.to_mut(), &self.ties);
        }
        z
    }
}

/// Computes `softmax(beta z)`.
///
/// The largest entry is subtracted before the multiplication by `beta`. So no exponential overflows, and the difference
/// of nearly equal entries is exact. The softmax does not depend on this shift, so the shift has no derivative.
pub fn softmax<R: Real>(z: [R; 3], beta: f64) -> [R; 3] {
    let [a, b, c] = z.map(R::detach);
    let largest = a.max(b).max(c);
    let e = z.map(|z| ((z - largest) * R::lit(beta)).exp());
    let sum = e[0] + e[1] + e[2];
    e.map(|e| e / sum)
}

impl<R: Real> Body<R> {
    /// The body of a design. In a layout, an edge has the properties of its material. Otherwise, it has the means of
    /// the properties over the materials in its mixture. If `physics.void_edges` is "drop", the void edges of a layout
    /// have no stiffness.
    pub fn new(
        design: &Design<Mixture<R>>,
        lattice: &Lattice,
        materials: &MaterialSettings,
        physics: &PhysicsSettings,
    ) -> Self {
        let edges = 0..lattice.edges.len();
        let bars: Vec<_> = edges.map(|edge| materials.of_edge(lattice, edge)).collect();
        let density = design.each(
            |edge, m| m.mean_of(&bars[edge].density),
            |edge, m| m.of(&bars[edge].density),
        );
        let edge_mass = |(&density, &length): (&R, &f64)| density * R::lit(length);
        let edge_masses: Vec<R> = (density.iter().zip(&lattice.rest_length))
            .map(edge_mass)
            .collect();
        let strain = materials.actuator_strain();
        let drops = physics.void_edges == VoidEdges::Drop;
        Self {
            stiffness: design.each(
                |edge, m| penalised(m, materials).mean_of(&bars[edge].stiffness),
                |edge, m| match m {
                    Material::Void if drops => 0.0,
                    m => m.of(&bars[edge].stiffness),
                },
            ),
            strain: design.each(
                |_, m| m[Material::Actuator] * R::lit(strain),
                |_, m| match m {
                    Material::Actuator => strain,
                    Material::Void | Material::Skeleton => 0.0,
                },
            ),
            largest_strain: materials.largest_strain(),
            rest_length: Vec::new(),
            mass: node_masses(&edge_masses, lattice, physics),
            presence: Vec::new(),
            marker: Marker {
                payload: lattice.payload[0].node,
                weights: Vec::new(),
            },
        }
    }

    /// Adds the presence of the nodes to this body. The presence of a node with payload is 1. The presence of any other
    /// node is 1 minus the product of the shares of void of its edges. If the layout is known, a node without a bar has
    /// presence 0, and no spring pulls it.
    #[must_use]
    pub fn with_presence(
        mut self,
        design: &Design<Mixture<R>>,
        layout: Option<&[Material]>,
        lattice: &Lattice,
    ) -> Self {
        self.presence = presence(design, layout, lattice);
        let Some(layout) = layout else { return self };
        let is_present = is_present(lattice, layout);
        for (edge, ends) in lattice.edges.iter().enumerate() {
            if ends.iter().any(|&node| !is_present[node]) {
                // Laws such as end stops act by the strain alone, which tells the share of actuator.
                (self.stiffness[edge], self.strain[edge]) = (R::zero(), R::zero());
            }
        }
        self
    }

    /// Chooses the point of this body whose displacement counts. The weights of the centre of mass are the masses of
    /// this body; a node that is not [present](Body::presence) has no weight. The weights of the mean of the nodes
    /// are their presences in `design`, even if this body has none.
    #[must_use]
    pub fn with_marker(
        mut self,
        moved: MovedBody,
        design: &Design<Mixture<R>>,
        layout: Option<&[Material]>,
        lattice: &Lattice,
    ) -> Self {
        self.marker.weights = match moved {
            MovedBody::Payload => Vec::new(),
            MovedBody::Mass if self.presence.is_empty() => self.mass.clone(),
            MovedBody::Mass => (self.mass.iter().zip(&self.presence))
                .map(|(&mass, &presence)| mass * presence)
                .collect(),
            MovedBody::Nodes => presence(design, layout, lattice),
        };
        self
    }
}

/// The presence of each node of a design, from 0 to 1. A node with payload has 1. Any other node has 1 minus the
/// product of the shares of void of its edges, or 0 if the layout is known and has no bar there.
fn presence<R: Real>(
    design: &Design<Mixture<R>>,
    layout: Option<&[Material]>,
    lattice: &Lattice,
) -> Vec<R> {
    let mut absence = vec![R::zero(); lattice.nodes()];
    if let Design::Undecided(mixtures) = design {
        absence.fill(R::one());
        for (ends, mixture) in lattice.edges.iter().zip(mixtures) {
            (ends.iter()).for_each(|&node| absence[node] *= mixture[Material::Void]);
        }
        for payload in &lattice.payload {
            absence[payload.node] = R::zero();
        }
    }
    let mut presence: Vec<R> = absence.into_iter().map(|a| R::one() - a).collect();
    if let Some(layout) = layout {
        for (presence, is_present) in presence.iter_mut().zip(is_present(lattice, layout)) {
            if !is_present {
                *presence = R::zero();
            }
        }
    }
    presence
}

/// The mass of each node: the sum of `physics.node_mass` (D2), half the mass of each of its edges, and its payload.
fn node_masses<R: Real>(edge_masses: &[R], lattice: &Lattice, physics: &PhysicsSettings) -> Vec<R> {
    let mut shares = vec![vec![R::lit(physics.node_mass)]; lattice.nodes()];
    for payload in &lattice.payload {
        shares[payload.node].push(R::lit(physics.mass_of(payload)));
    }
    for (&[i, j], &mass) in lattice.edges.iter().zip(edge_masses) {
        let half = R::lit(0.5) * mass;
        shares[i].push(half);
        shares[j].push(half);
    }
    shares.iter().map(|shares| R::sum_of(shares)).collect()
}

/// The weights with which the stiffnesses of the materials are added up: the shares of the mixture to the power of
/// `penalisation` (SIMP). With a power above 1, a small share counts less than in proportion. A share of 1 counts
/// fully.
fn penalised<R: Real>(mixture: &Mixture<R>, materials: &MaterialSettings) -> Mixture<R> {
    match materials.penalisation {
        1 => *mixture,
        exponent => Mixture(mixture.0.map(|share| share.powi(exponent as i32))),
    }
}
