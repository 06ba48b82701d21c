//! Where an optimisation starts.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{Material, one_hot, vectors_of_mixture};
use crate::lattice::Lattice;

/// The design at the first iteration.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Start {
    /// Which of the starts below.
    pub kind: StartKind,
    /// `stability`: how much more void the topmost edges are than the lowest.
    pub top_void: f64,
    /// `three_legged`: the void entry of the edges that are void in `layout`.
    pub leg_void: f64,
    /// `three_legged` and `layout`: the layout meant.
    pub layout: Baseline,
}

/// The ways to start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StartKind {
    /// The same mixture everywhere (the paper's d).
    Uniform,
    /// More void the higher an edge is (b).
    Stability,
    /// More void where a three-legged layout has none of its edges (c).
    ThreeLegged,
    /// A layout that is given and stays (a).
    Layout,
}

/// The three-legged layouts on 6x6 nodes; both are within the volume budget.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Baseline {
    /// Legs three cells high, every actuator vertical.
    Tall,
    /// Legs two cells high.
    Short,
}

/// Why a start does not exist.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum StartError {
    /// The layouts are drawn for one lattice.
    #[error(
        "the three-legged layouts are drawn for 6x6 nodes, and this lattice has {columns}x{rows}"
    )]
    OtherLattice {
        /// Nodes in a row.
        columns: usize,
        /// How many rows.
        rows: usize,
    },
}

#[derive(Deserialize)]
struct Drawings {
    edges: Vec<[usize; 2]>,
    tall: Vec<Material>,
    short: Vec<Material>,
}

impl Baseline {
    /// The material of every edge of `lattice`.
    ///
    /// # Errors
    /// Where the lattice is not the one that the layouts are drawn for.
    pub fn materials(self, lattice: &Lattice) -> Result<Vec<Material>, StartError> {
        let drawings: Drawings = serde_json::from_str(include_str!("../../data/baselines.json"))
            .expect("the layouts shipped with the program parse");
        if drawings.edges != lattice.edges {
            return Err(StartError::OtherLattice {
                columns: lattice.columns,
                rows: lattice.rows,
            });
        }
        Ok(match self {
            Self::Tall => drawings.tall,
            Self::Short => drawings.short,
        })
    }
}

impl Start {
    /// The design vectors to start from, for a performance projection of sharpness `beta`.
    ///
    /// # Errors
    /// Where a layout is asked for that does not fit the lattice.
    pub fn vectors(&self, lattice: &Lattice, beta: f64) -> Result<Vec<[f64; 3]>, StartError> {
        let void: Vec<f64> = match self.kind {
            StartKind::Layout => return Ok(one_hot(&self.layout.materials(lattice)?)),
            StartKind::Uniform => vec![1.0 / 3.0; lattice.edges.len()],
            StartKind::Stability => stability_voids(lattice, self.top_void),
            StartKind::ThreeLegged => {
                let in_layout = |material: Material| match material {
                    Material::Void => self.leg_void,
                    Material::Skeleton | Material::Actuator => 1.0 / 3.0,
                };
                let materials = self.layout.materials(lattice)?;
                materials.into_iter().map(in_layout).collect()
            }
        };
        let mixture: Vec<[f64; 3]> = void.iter().map(|&m| [m, rest(m), rest(m)]).collect();
        Ok(vectors_of_mixture(&mixture, beta))
    }
}

/// What skeleton and actuator each get of an edge that is `void` void.
fn rest(void: f64) -> f64 {
    0.5 * (1.0 - void)
}

/// A third, plus `top_void` times the edge's height relative to the highest edge's.
fn stability_voids(lattice: &Lattice, top_void: f64) -> Vec<f64> {
    let heights = lattice.midpoint_rows();
    // A lattice of one row has no height to tell its edges apart by.
    let highest = heights.iter().copied().fold(0.0, f64::max).max(0.5);
    heights
        .iter()
        .map(|y| 1.0 / 3.0 + top_void * y / highest)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{Baseline, Start, StartError, StartKind};
    use crate::design::{Material, dominant};
    use crate::lattice::{Grid, Ground, Lattice};

    fn lattice(columns: usize, rows: usize) -> Lattice {
        Lattice::new(&Grid {
            columns,
            rows,
            spacing: 0.1,
            origin_x: 0.1,
            drop: 0.0,
            ground: Ground {
                height: 0.1,
                incline_deg: 0.0,
            },
        })
    }

    fn start(kind: StartKind) -> Start {
        Start {
            kind,
            top_void: 0.12,
            leg_void: 0.6,
            layout: Baseline::Short,
        }
    }

    /// The void entry of the softmax of a design vector.
    fn void(z: &[f64; 3]) -> f64 {
        let e = z.map(|z| (20.0 * z).exp());
        e[0] / (e[0] + e[1] + e[2])
    }

    #[test]
    fn the_uniform_start_is_a_third_of_everything() {
        let z = start(StartKind::Uniform).vectors(&lattice(6, 6), 20.0);
        assert_eq!(z, Ok(vec![[1.0 / 3.0; 3]; 110]));
    }

    #[test]
    fn the_stability_start_thins_out_upwards() {
        let lattice = lattice(6, 6);
        let z = start(StartKind::Stability).vectors(&lattice, 20.0).unwrap();
        // exp multiplies the roundings of z by 20.
        assert!((void(&z[0]) - 1.0 / 3.0).abs() < 1e-14);
        assert!((void(z.last().unwrap()) - (1.0 / 3.0 + 0.12)).abs() < 1e-14);
        assert!(z.iter().all(|z| z[1] == z[2]));
    }

    #[test]
    fn one_row_has_a_stability_start_too() {
        let z = start(StartKind::Stability).vectors(&lattice(4, 1), 20.0);
        assert_eq!(z, Ok(vec![[1.0 / 3.0; 3]; 3]));
    }

    #[test]
    fn the_three_legged_start_thins_out_beside_its_layout() {
        let lattice = lattice(6, 6);
        let layout = Baseline::Short.materials(&lattice).unwrap();
        let z = start(StartKind::ThreeLegged)
            .vectors(&lattice, 20.0)
            .unwrap();
        for (material, z) in layout.iter().zip(&z) {
            let expected = if *material == Material::Void {
                0.6
            } else {
                1.0 / 3.0
            };
            assert!((void(z) - expected).abs() < 1e-14);
        }
    }

    #[test]
    fn the_layouts_keep_the_volume_budget() {
        let lattice = lattice(6, 6);
        for layout in [Baseline::Tall, Baseline::Short] {
            let materials = layout.materials(&lattice).unwrap();
            let solid = materials.iter().filter(|m| m.is_solid()).count();
            let actuators = materials
                .iter()
                .filter(|&&m| m == Material::Actuator)
                .count();
            assert_eq!((solid, actuators), (55, 22));
            let start = Start {
                layout,
                ..start(StartKind::Layout)
            };
            let z = start.vectors(&lattice, 20.0).unwrap();
            assert_eq!(z.iter().map(dominant).collect::<Vec<_>>(), materials);
        }
    }

    #[test]
    fn a_layout_for_another_lattice_is_refused() {
        let error = start(StartKind::Layout).vectors(&lattice(5, 5), 20.0);
        assert_eq!(
            error,
            Err(StartError::OtherLattice {
                columns: 5,
                rows: 5
            })
        );
    }
}
