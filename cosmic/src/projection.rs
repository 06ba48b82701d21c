//! From design vectors to a mixture of materials, and from the mixture to a body.

use autodiff::Real;
use serde::{Deserialize, Serialize};

use crate::design::{self, Material};
use crate::lattice::Lattice;

/// How sharply design vectors become mixtures.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sharpness {
    /// Of the performance projection.
    pub beta: f64,
    /// Of the stability projection's value.
    pub beta_stability: f64,
    /// Of the softer projection whose derivative stands in for that of the stability projection.
    pub beta_straight_through: f64,
}

/// The two projections of the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Projection {
    /// `softmax(beta z)`.
    Performance,
    /// Centred by the mean over the edges and sharp, so that it shows what a snap would leave;
    /// with the derivative of a softer one (straight-through).
    Stability,
}

/// The mixture of every edge: positive shares of void, skeleton and actuator that sum to one.
pub fn mixture<R: Real>(
    projection: Projection,
    z: &[[R; 3]],
    sharpness: &Sharpness,
) -> Vec<[R; 3]> {
    match projection {
        Projection::Performance => z.iter().map(|&z| softmax(z, sharpness.beta)).collect(),
        Projection::Stability => {
            let mean = column_means(z);
            let project = |z: &[R; 3]| {
                let centred = [z[0] - mean[0], z[1] - mean[1], z[2] - mean[2]];
                let sharp = softmax(centred.map(R::detach), sharpness.beta_stability);
                let soft = softmax(centred, sharpness.beta_straight_through);
                [0, 1, 2].map(|k| sharp[k].straight_through(soft[k]))
            };
            z.iter().map(project).collect()
        }
    }
}

/// The mixture of a layout: exactly one material per edge (D7).
pub fn one_hot<R: Real>(materials: &[Material]) -> Vec<[R; 3]> {
    let vectors = design::one_hot(materials);
    vectors.into_iter().map(|m| m.map(R::lit)).collect()
}

/// `softmax(beta z)`.
///
/// The largest entry is taken off first and the rest multiplied after: no exponential can
/// overflow, and the difference of nearly equal entries is exact. The shift is a constant to the
/// derivative, because the softmax does not depend on it.
pub fn softmax<R: Real>(z: [R; 3], beta: f64) -> [R; 3] {
    let [a, b, c] = z.map(R::detach);
    let largest = a.max(b).max(c);
    let e = z.map(|z| ((z - largest) * R::lit(beta)).exp());
    let sum = e[0] + e[1] + e[2];
    e.map(|e| e / sum)
}

/// The mean over the edges of each of the three entries.
fn column_means<R: Real>(rows: &[[R; 3]]) -> [R; 3] {
    let share = R::lit(1.0 / rows.len() as f64);
    [0, 1, 2].map(|k| {
        let column: Vec<R> = rows.iter().map(|row| row[k]).collect();
        R::sum(&column) * share
    })
}

/// What the materials are like (void, skeleton, actuator), and what the nodes weigh.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Library {
    /// Stiffness of an edge, N/m.
    pub stiffness: [f64; 3],
    /// Mass per length, kg/m.
    pub density: [f64; 3],
    /// Largest relative change of length on command.
    pub max_strain: [f64; 3],
    /// Mass of a node without any edge, kg (D2).
    pub node_mass: f64,
    /// Mass added to node 0, kg.
    pub payload_mass: f64,
}

/// What a rollout does not change: the robot as the simulator sees it.
#[derive(Clone, Debug, PartialEq)]
pub struct Body<R> {
    /// Stiffness per edge, N/m.
    pub stiffness: Vec<R>,
    /// Relative change of length per edge at full activation (D8).
    pub strain: Vec<R>,
    /// Mass per node, kg.
    pub mass: Vec<R>,
}

impl<R: Real> Body<R> {
    /// The body of a mixture: every property of an edge is the mixture's mean of its materials'.
    pub fn new(mixture: &[[R; 3]], lattice: &Lattice, library: &Library) -> Self {
        let strain = R::lit(library.max_strain[Material::Actuator as usize]);
        Self {
            stiffness: mixture
                .iter()
                .map(|m| mean_property(m, &library.stiffness))
                .collect(),
            strain: mixture
                .iter()
                .map(|m| m[Material::Actuator as usize] * strain)
                .collect(),
            mass: node_masses(mixture, lattice, library),
        }
    }
}

/// Half of every edge's mass goes to each of its nodes.
fn node_masses<R: Real>(mixture: &[[R; 3]], lattice: &Lattice, library: &Library) -> Vec<R> {
    let mut shares = vec![vec![R::lit(library.node_mass)]; lattice.nodes()];
    shares[0].push(R::lit(library.payload_mass));
    for (e, &[i, j]) in lattice.edges.iter().enumerate() {
        let half_length = R::lit(0.5 * lattice.rest_length[e]);
        let half = half_length * mean_property(&mixture[e], &library.density);
        shares[i].push(half);
        shares[j].push(half);
    }
    shares.iter().map(|shares| R::sum(shares)).collect()
}

fn mean_property<R: Real>(mixture: &[R; 3], property: &[f64; 3]) -> R {
    R::dot(mixture, &property.map(R::lit))
}

#[cfg(test)]
mod tests {
    use super::{Body, Library, Projection, Sharpness, mixture, one_hot};
    use crate::design::Material::{Actuator, Skeleton, Void};
    use crate::lattice::{Grid, Ground, Lattice};

    const LIBRARY: Library = Library {
        stiffness: [1e-7, 4e2, 3e1],
        density: [1e-8, 0.030, 0.100],
        max_strain: [0.0, 0.0, 0.35],
        node_mass: 1e-4,
        payload_mass: 0.03,
    };

    #[test]
    fn a_void_edge_of_a_layout_has_exactly_the_void_stiffness() {
        let grid = Grid {
            columns: 2,
            rows: 2,
            spacing: 0.1,
            origin_x: 0.1,
            drop: 0.0,
            ground: Ground {
                height: 0.1,
                incline_deg: 0.0,
            },
        };
        let layout = [Void, Skeleton, Actuator, Void, Void, Void];
        let body = Body::new(&one_hot::<f64>(&layout), &Lattice::new(&grid), &LIBRARY);
        assert_eq!(body.stiffness[..3], [1e-7, 4e2, 3e1]);
        assert_eq!(body.strain[..3], [0.0, 0.0, 0.35]);
        let weight: f64 = body.mass.iter().sum();
        let diagonal = 0.02f64.sqrt();
        let edges = 0.1 * 0.030 + diagonal * 0.1 + 1e-8 * (0.3 + diagonal);
        // A dozen roundings of numbers below 0.1.
        assert!((weight - (4e-4 + 0.03 + edges)).abs() < 1e-16);
    }

    #[test]
    fn the_stability_projection_leaves_equal_edges_undecided() {
        let sharpness = Sharpness {
            beta: 20.0,
            beta_stability: 500.0,
            beta_straight_through: 20.0,
        };
        let z = vec![[0.9, 0.1, 0.4]; 3];
        for row in mixture(Projection::Stability, &z, &sharpness) {
            // The mean of three equal numbers is off by a rounding, which 500 multiplies.
            assert!(row.iter().all(|m: &f64| (m - 1.0 / 3.0).abs() < 1e-13));
        }
    }
}
