//! Motifs that recur among the designs, compared with shuffles of their materials.

use super::rows::{RunRow, TrialRow};
use cosmic::design::Material;
use cosmic::error::Result;
use cosmic::geometry::Vector;
use cosmic::lattice::Lattice;
use cosmic::random::{Purpose, stream};
use cosmic::record::{DesignFile, run};
use rand::RngExt;
use serde::Serialize;

/// Shuffles of each layout.
const SHUFFLES: usize = 50;

/// A number of a layout: a share, or 1 if the layout has a feature and 0 if not.
type OfLayout = fn(&Lattice, &[Material]) -> f64;

/// The motifs that the paper describes, each as a number.
const MOTIFS: [(&str, OfLayout); 4] = [
    (
        "the lowest row is broken: one of its edges is void",
        |lattice, materials| {
            let mut heights = lattice.midpoints().zip(materials);
            f64::from(heights.any(|(middle, m)| middle.up() == 0.0 && !m.is_solid()))
        },
    ),
    (
        "share of the solid edges in the lower half",
        |lattice, materials| {
            let top = lattice.extent().up();
            let heights: Vec<f64> = lattice.midpoints().map(Vector::up).collect();
            share(materials, |e, m| {
                m.is_solid().then(|| heights[e] < 0.5 * top)
            })
        },
    ),
    (
        "share of the actuators in the payload's half",
        |lattice, materials| {
            let width = lattice.extent().forward();
            let along: Vec<f64> = lattice.midpoints().map(Vector::forward).collect();
            share(materials, |e, m| {
                (m == Material::Actuator).then(|| along[e] < 0.5 * width)
            })
        },
    ),
    (
        "a horizontal actuator is the side of a cell with both braces passive",
        |lattice, materials| {
            let mut edges = 0..lattice.edges.len();
            f64::from(edges.any(|e| is_between_braces(lattice, materials, e)))
        },
    ),
];

/// The share of edges for which `is` is true, among those for which it gives an answer.
fn share(materials: &[Material], is: impl Fn(usize, Material) -> Option<bool>) -> f64 {
    let edges = materials.iter().enumerate();
    let counted: Vec<bool> = edges.filter_map(|(e, &m)| is(e, m)).collect();
    let yes = counted.iter().filter(|&&is| is).count();
    yes as f64 / counted.len().max(1) as f64
}

/// True for a horizontal actuator above or below crossed skeleton braces.
fn is_between_braces(lattice: &Lattice, materials: &[Material], edge: usize) -> bool {
    let [i, j] = lattice.edges[edge];
    if lattice.direction([i, j]) != [1.0, 0.0] || materials[edge] != Material::Actuator {
        return false;
    }
    let is_skeleton = |ends: [usize; 2]| {
        let edge = lattice
            .edges
            .iter()
            .position(|&[a, b]| [a, b] == ends || [b, a] == ends);
        edge.is_some_and(|edge| materials[edge] == Material::Skeleton)
    };
    let at = |place: Vector<f64>, up: f64| {
        let above = place.with_up(place.up() + up);
        lattice.places.iter().position(|&place| place == above)
    };
    let braced = |up: f64| {
        let ends = [i, j].map(|node| at(lattice.places[node], up));
        matches!(ends, [Some(k), Some(l)] if is_skeleton([i, l]) && is_skeleton([j, k]))
    };
    braced(1.0) || braced(-1.0)
}

/// How often a motif occurs among the designs of each trial.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct MotifRow {
    /// The motif in words.
    pub(super) says: String,
    /// For each trial: the mean over its designs, and over layouts shuffled from them.
    pub(super) found: Vec<[f64; 2]>,
}

/// Counts the motifs of every trial's designs.
///
/// # Errors
/// The errors of reading the designs.
pub(super) fn count(trials: &[TrialRow]) -> Result<Vec<MotifRow>> {
    let found: Vec<_> = trials.iter().map(found).collect::<Result<_>>()?;
    let row = |(k, (says, _)): (usize, &(&str, OfLayout))| MotifRow {
        says: (*says).to_owned(),
        found: found.iter().map(|found| found[k]).collect(),
    };
    Ok(MOTIFS.iter().enumerate().map(row).collect())
}

/// For each motif: the mean over a trial's designs, and over layouts shuffled from them.
fn found(trial: &TrialRow) -> Result<[[f64; 2]; MOTIFS.len()]> {
    let mut sums = [[0.0; 2]; MOTIFS.len()];
    let mut designs = 0.0_f64;
    let mut stream = stream(0, Purpose::Shuffle);
    for RunRow { folder, .. } in trial.runs.iter().filter(|run| !run.diverged) {
        let scene = run::read_scene(folder)?;
        let lattice = Lattice::new(&scene.lattice, &scene.physics);
        let mut materials = DesignFile::read(&folder.join(run::DESIGN))?.materials;
        designs += 1.0;
        let mut add = |materials: &[Material], column: usize, weight: f64| {
            for (sum, (_, of)) in sums.iter_mut().zip(&MOTIFS) {
                sum[column] += weight * of(&lattice, materials);
            }
        };
        add(&materials, 0, 1.0);
        for _ in 0..SHUFFLES {
            for last in (1..materials.len()).rev() {
                materials.swap(last, stream.random_range(0..=last));
            }
            add(&materials, 1, 1.0 / SHUFFLES as f64);
        }
    }
    Ok(sums.map(|pair| pair.map(|sum| sum / designs.max(1.0))))
}

#[cfg(test)]
mod tests {
    use super::{MOTIFS, is_between_braces};
    use cosmic::design::Material::{self, Actuator, Skeleton, Void};
    use cosmic::lattice::Lattice;
    use cosmic::scene::{LatticeSettings, PhysicsSettings};

    fn lattice() -> Lattice {
        let settings = LatticeSettings {
            columns: 2,
            rows: 3,
            ..LatticeSettings::default()
        };
        Lattice::new(&settings, &PhysicsSettings::default())
    }

    /// A layout by the material of each edge.
    fn layout(lattice: &Lattice, material: impl Fn([usize; 2]) -> Material) -> Vec<Material> {
        lattice.edges.iter().map(|&edge| material(edge)).collect()
    }

    #[test]
    fn braces_are_found_above_and_below() {
        let lattice = lattice();
        let horizontal = |[i, j]: [usize; 2]| j == i + 1 && i % 2 == 0;
        for row in 0..3 {
            let materials = layout(&lattice, |edge| match edge {
                [i, _] if i == 2 * row && horizontal(edge) => Actuator,
                _ if horizontal(edge) => Void,
                _ => Skeleton,
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
        assert_eq!((MOTIFS[1].1)(&lattice, &all), 5.0 / 11.0);
        assert_eq!((MOTIFS[0].1)(&lattice, &all), 0.0);
        let is_left = |[i, j]: [usize; 2]| j == i + 2 && i % 2 == 0;
        let left = layout(&lattice, |edge| if is_left(edge) { Actuator } else { Void });
        assert_eq!((MOTIFS[2].1)(&lattice, &left), 1.0);
        assert_eq!((MOTIFS[0].1)(&lattice, &left), 1.0);
    }
}
