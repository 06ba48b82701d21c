//! Which motifs recur among the designs, against what chance would leave of the same materials.

use super::rows::Collected;
use cosmic::design::Material;
use cosmic::error::Result;
use cosmic::ground::Ground;
use cosmic::lattice::Lattice;
use cosmic::random::{Purpose, stream};
use cosmic::record::{DesignFile, run};
use cosmic::scene::Scene;
use rand::RngExt;
use serde::{Deserialize, Serialize};

/// How often each layout is shuffled.
const SHUFFLES: usize = 50;

/// Something to look for in a layout.
struct Motif {
    says: &'static str,
    /// A share, or 1 where it is there and 0 where not.
    of: fn(&Lattice, &[Material]) -> f64,
}

/// The motifs that the paper describes, as numbers.
const MOTIFS: [Motif; 4] = [
    Motif {
        says: "the lowest row is broken: one of its edges is void",
        of: |lattice, materials| {
            let lowest = |&[_, j]: &[usize; 2]| j < lattice.columns;
            let mut edges = lattice.edges.iter().zip(materials);
            let is_broken = edges.any(|(edge, m)| lowest(edge) && !m.is_solid());
            f64::from(u8::from(is_broken))
        },
    },
    Motif {
        says: "share of the solid edges in the lower half",
        of: |lattice, materials| {
            let middle = 0.5 * (lattice.rows - 1) as f64;
            let rows = lattice.midpoint_rows();
            share(lattice, materials, |e, m| {
                m.is_solid().then(|| rows[e] < middle)
            })
        },
    },
    Motif {
        says: "share of the actuators in the payload's half",
        of: |lattice, materials| {
            let column = |node: usize| (node % lattice.columns) as f64;
            let middle = (lattice.columns - 1) as f64;
            share(lattice, materials, |e, m| {
                let [i, j] = lattice.edges[e];
                (m == Material::Actuator).then(|| column(i) + column(j) < middle)
            })
        },
    },
    Motif {
        says: "a horizontal actuator is the side of a cell with both braces passive",
        of: |lattice, materials| {
            let found = (0..lattice.edges.len()).any(|e| is_between_braces(lattice, materials, e));
            f64::from(u8::from(found))
        },
    },
];

/// The share of the edges that count and are, among those that count.
fn share(
    lattice: &Lattice,
    materials: &[Material],
    is: impl Fn(usize, Material) -> Option<bool>,
) -> f64 {
    let counted: Vec<bool> = (0..lattice.edges.len())
        .filter_map(|e| is(e, materials[e]))
        .collect();
    let yes = counted.iter().filter(|&&is| is).count();
    yes as f64 / counted.len().max(1) as f64
}

/// Whether an edge is a horizontal actuator above or below crossed skeleton braces.
fn is_between_braces(lattice: &Lattice, materials: &[Material], edge: usize) -> bool {
    let [i, j] = lattice.edges[edge];
    if j != i + 1 || materials[edge] != Material::Actuator {
        return false;
    }
    let columns = lattice.columns;
    let is_skeleton = |a: usize, b: usize| {
        let edge = lattice.edges.iter().position(|&edge| edge == [a, b]);
        edge.is_some_and(|edge| materials[edge] == Material::Skeleton)
    };
    // The cell whose lower left node this is.
    let braced =
        |low: usize| is_skeleton(low, low + columns + 1) && is_skeleton(low + 1, low + columns);
    braced(i) || i >= columns && braced(i - columns)
}

/// How often a motif is among the designs of a trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MotifRow {
    /// What is looked for.
    pub says: String,
    /// For each trial: its mean over the designs, and over layouts shuffled from them.
    pub found: Vec<[f64; 2]>,
}

/// Counts the motifs of every trial's designs.
///
/// # Errors
/// Those of reading the designs.
pub(super) fn count(collected: &[Collected]) -> Result<Vec<MotifRow>> {
    let mut rows: Vec<MotifRow> = MOTIFS
        .iter()
        .map(|motif| MotifRow {
            says: motif.says.to_owned(),
            found: Vec::new(),
        })
        .collect();
    for trial in collected {
        for (row, found) in rows.iter_mut().zip(found(trial)?) {
            row.found.push(found);
        }
    }
    Ok(rows)
}

fn found(trial: &Collected) -> Result<[[f64; 2]; MOTIFS.len()]> {
    let mut sums = [[0.0; 2]; MOTIFS.len()];
    let mut designs = 0.0_f64;
    let mut stream = stream(0, Purpose::Shuffle);
    let runs = trial.row.runs.iter().zip(&trial.folders);
    for (_, folder) in runs.filter(|(run, _)| !run.diverged) {
        let scene = Scene::read(&folder.join(run::SCENE))?;
        let lattice = Lattice::new(&scene.lattice, &Ground::from(&scene.physics));
        let mut materials = DesignFile::read(&folder.join(run::DESIGN))?.materials;
        designs += 1.0;
        add(&mut sums, 0, (&lattice, &materials), 1.0);
        for _ in 0..SHUFFLES {
            for last in (1..materials.len()).rev() {
                materials.swap(last, stream.random_range(0..=last));
            }
            add(&mut sums, 1, (&lattice, &materials), 1.0 / SHUFFLES as f64);
        }
    }
    Ok(sums.map(|pair| pair.map(|sum| sum / designs.max(1.0))))
}

fn add(
    sums: &mut [[f64; 2]; MOTIFS.len()],
    column: usize,
    (lattice, materials): (&Lattice, &[Material]),
    weight: f64,
) {
    for (sum, motif) in sums.iter_mut().zip(&MOTIFS) {
        sum[column] += weight * (motif.of)(lattice, materials);
    }
}

#[cfg(test)]
mod tests {
    use super::{MOTIFS, is_between_braces};
    use cosmic::design::Material::{self, Actuator, Skeleton, Void};
    use cosmic::ground::Ground;
    use cosmic::lattice::Lattice;
    use cosmic::scene::{LatticeSettings, PhysicsSettings};

    fn lattice() -> Lattice {
        let settings = LatticeSettings {
            columns: 2,
            rows: 3,
            ..LatticeSettings::default()
        };
        Lattice::new(&settings, &Ground::from(&PhysicsSettings::default()))
    }

    /// A layout by what each edge is made of.
    fn layout(lattice: &Lattice, material: impl Fn([usize; 2]) -> Material) -> Vec<Material> {
        lattice.edges.iter().map(|&edge| material(edge)).collect()
    }

    #[test]
    fn braces_are_found_above_and_below() {
        let lattice = lattice();
        let horizontal = |[i, j]: [usize; 2]| j == i + 1 && i % 2 == 0;
        for row in 0..3 {
            let materials = layout(&lattice, |edge| match horizontal(edge) {
                true if edge[0] == 2 * row => Actuator,
                true => Void,
                false => Skeleton,
            });
            let found =
                (0..materials.len()).filter(|&e| is_between_braces(&lattice, &materials, e));
            assert_eq!(found.count(), 1, "row {row}");
        }
        let broken = layout(&lattice, |edge| match edge {
            [0, 3] | [2, 5] => Void,
            edge if horizontal(edge) => Actuator,
            _ => Skeleton,
        });
        assert!(!(0..broken.len()).any(|e| is_between_braces(&lattice, &broken, e)));
    }

    #[test]
    fn shares_count_what_they_say() {
        let lattice = lattice();
        // Below the middle row, whose edges are at its height, are five of the eleven.
        let all = layout(&lattice, |_| Skeleton);
        assert_eq!((MOTIFS[1].of)(&lattice, &all), 5.0 / 11.0);
        assert_eq!((MOTIFS[0].of)(&lattice, &all), 0.0);
        let left = layout(&lattice, |[i, j]| match j == i + 2 && i % 2 == 0 {
            true => Actuator,
            false => Void,
        });
        assert_eq!((MOTIFS[2].of)(&lattice, &left), 1.0);
        assert_eq!((MOTIFS[0].of)(&lattice, &left), 1.0);
    }
}
