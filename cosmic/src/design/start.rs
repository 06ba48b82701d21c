//! Where an optimisation starts.

use super::tilt::tilted;
use super::{Material, one_hot, vectors_of_mixture};
use crate::error::{Error, Result};
use crate::lattice::Lattice;
use crate::scene::{LAYOUT_SIDE, Layout, StartKind, StartSettings};

/// The design vectors to start from, for a performance projection of sharpness `beta`. The seed
/// matters to a tilted start alone.
///
/// # Errors
/// [`Error::Usage`] where a layout is asked for that is drawn for another lattice.
pub fn start_vectors(
    settings: &StartSettings,
    lattice: &Lattice,
    beta: f64,
    seed: u64,
) -> Result<Vec<[f64; 3]>> {
    let void = match settings.kind {
        StartKind::Layout => return Ok(one_hot(&layout_materials(settings.layout, lattice)?)),
        StartKind::Uniform => vec![1.0 / 3.0; lattice.edges.len()],
        StartKind::Filled => vec![settings.void; lattice.edges.len()],
        StartKind::Stability => stability_voids(lattice, settings.void_shift),
        StartKind::ThreeLegged => {
            let materials = layout_materials(settings.layout, lattice)?;
            let in_layout = |material: Material| match material {
                Material::Void => settings.void,
                Material::Skeleton | Material::Actuator => 1.0 / 3.0,
            };
            materials.into_iter().map(in_layout).collect()
        }
    };
    let void = if settings.tilt > 0.0 {
        tilted(&void, lattice, settings.tilt, seed)
    } else {
        void
    };
    let rest = |void: f64| 0.5 * (1.0 - void);
    let mixture: Vec<[f64; 3]> = void.iter().map(|&m| [m, rest(m), rest(m)]).collect();
    Ok(vectors_of_mixture(&mixture, beta))
}

/// The material that a layout gives every edge of the lattice.
///
/// # Errors
/// [`Error::Usage`] where the layout is drawn for another lattice.
pub fn layout_materials(layout: Layout, lattice: &Lattice) -> Result<Vec<Material>> {
    let Some(numbers) = layout.materials() else {
        return Ok(filled(lattice));
    };
    if (lattice.columns, lattice.rows) != (LAYOUT_SIDE, LAYOUT_SIDE) {
        return Err(Error::Usage(format!(
            "the three-legged layouts are drawn for {LAYOUT_SIDE}x{LAYOUT_SIDE} nodes, and this \
             lattice has {}x{}",
            lattice.columns, lattice.rows
        )));
    }
    Ok(numbers
        .into_iter()
        .map(|number| Material::ALL[usize::from(number)])
        .collect())
}

/// Share of a filled lattice's edges that are actuators: the most of the paper's table 2.
const FILLED_ACTUATORS: f64 = 0.22;

/// Skeleton everywhere but on vertical edges: of those, as many as the volume budget allows are
/// actuators, spread evenly over rows and columns (the paper's "uniform distribution of vertical
/// actuators", of which it lists no edges).
pub fn filled(lattice: &Lattice) -> Vec<Material> {
    let vertical = |&[i, j]: &[usize; 2]| i.abs_diff(j) == lattice.columns;
    let verticals = lattice.edges.iter().filter(|edge| vertical(edge)).count();
    let most = (FILLED_ACTUATORS * lattice.edges.len() as f64) as usize;
    let actuators = most.min(verticals);
    let mut seen = 0;
    let mut material = |edge: &[usize; 2]| {
        if !vertical(edge) {
            return Material::Skeleton;
        }
        // An even slope rounded up grows where the next one is due: the payload's edge has the
        // first, without which it could not be lifted.
        let due = |n: usize| (n * actuators).div_ceil(verticals);
        seen += 1;
        if due(seen) > due(seen - 1) {
            Material::Actuator
        } else {
            Material::Skeleton
        }
    };
    lattice.edges.iter().map(&mut material).collect()
}

/// A third, plus `top` times the edge's height relative to the highest edge's.
fn stability_voids(lattice: &Lattice, top: f64) -> Vec<f64> {
    let heights = lattice.midpoint_rows();
    // A lattice of one row has no height to tell its edges apart by.
    let highest = heights.iter().copied().fold(0.5, f64::max);
    let void = |height: &f64| 1.0 / 3.0 + top * height / highest;
    heights.iter().map(void).collect()
}

#[cfg(test)]
mod tests {
    use super::{filled, layout_materials, start_vectors};
    use crate::design::{Material, dominant};
    use crate::error::Result;
    use crate::lattice::Lattice;
    use crate::scene::{Layout, StartKind, StartSettings};

    fn start(kind: StartKind) -> StartSettings {
        StartSettings {
            kind,
            ..StartSettings::default()
        }
    }

    /// The default start of a kind on a lattice of so many nodes.
    fn vectors(kind: StartKind, columns: usize, rows: usize) -> Result<Vec<[f64; 3]>> {
        let lattice = Lattice::sample(columns, rows, 0.0);
        start_vectors(&start(kind), &lattice, 20.0, 0)
    }

    /// The void entry of the softmax of a design vector.
    fn void(z: &[f64; 3]) -> f64 {
        let e = z.map(|z| (20.0 * z).exp());
        e[0] / (e[0] + e[1] + e[2])
    }

    #[test]
    fn the_uniform_start_is_a_third_of_everything() {
        let z = vectors(StartKind::Uniform, 6, 6).unwrap();
        assert_eq!(z, vec![[1.0 / 3.0; 3]; 110]);
    }

    #[test]
    fn the_stability_start_thins_out_upwards() {
        let z = vectors(StartKind::Stability, 6, 6).unwrap();
        // exp multiplies the roundings of z by 20.
        assert!((void(&z[0]) - 1.0 / 3.0).abs() < 1e-14);
        assert!((void(&z[109]) - (1.0 / 3.0 + 0.12)).abs() < 1e-14);
        assert!(z.iter().all(|z| z[1] == z[2]));
    }

    #[test]
    fn one_row_has_a_stability_start_too() {
        let z = vectors(StartKind::Stability, 4, 1).unwrap();
        assert_eq!(z, vec![[1.0 / 3.0; 3]; 3]);
    }

    #[test]
    fn a_filled_lattice_does_not_hang_on_the_direction_of_its_edges() {
        let mut lattice = Lattice::sample(6, 6, 0.0);
        let materials = filled(&lattice);
        for edge in &mut lattice.edges {
            edge.reverse();
        }
        assert_eq!(filled(&lattice), materials);
        assert!(materials.contains(&Material::Actuator));
    }

    #[test]
    fn the_three_legged_start_thins_out_beside_its_layout() {
        let lattice = Lattice::sample(6, 6, 0.0);
        let layout = layout_materials(Layout::Short, &lattice).unwrap();
        let z = vectors(StartKind::ThreeLegged, 6, 6).unwrap();
        for (material, z) in layout.iter().zip(&z) {
            let share = if material.is_solid() { 1.0 / 3.0 } else { 0.6 };
            // exp multiplies the roundings of z by 20.
            assert!((void(z) - share).abs() < 1e-14);
        }
    }

    #[test]
    fn the_layouts_keep_the_volume_budget() {
        let lattice = Lattice::sample(6, 6, 0.0);
        for layout in [Layout::Tall, Layout::Short] {
            let materials = layout_materials(layout, &lattice).unwrap();
            let solid = materials.iter().filter(|m| m.is_solid()).count();
            let actuators = materials
                .iter()
                .filter(|&&m| m == Material::Actuator)
                .count();
            assert_eq!((solid, actuators), (55, 22));
            let settings = StartSettings {
                layout,
                ..start(StartKind::Layout)
            };
            let z = start_vectors(&settings, &lattice, 20.0, 0).unwrap();
            assert_eq!(z.iter().map(dominant).collect::<Vec<_>>(), materials);
        }
    }

    #[test]
    fn the_filled_layout_spreads_its_actuators_over_the_vertical_edges() {
        let lattice = Lattice::sample(6, 6, 0.0);
        let materials = layout_materials(Layout::Filled, &lattice).unwrap();
        assert!(materials.iter().all(|material| material.is_solid()));
        let made_of = lattice.edges.iter().zip(&materials);
        let actuators = made_of.filter(|(_, m)| **m == Material::Actuator);
        let edges: Vec<[usize; 2]> = actuators.map(|(&edge, _)| edge).collect();
        assert_eq!(edges.len(), 24);
        assert!(edges.iter().all(|[i, j]| j - i == 6) && edges.contains(&[0, 6]));
        let in_column = |c: usize| edges.iter().filter(|[i, _]| i % 6 == c).count();
        assert_eq!([0, 1, 2, 3, 4, 5].map(in_column), [4; 6]);
    }

    #[test]
    fn the_filled_start_has_little_void() {
        let settings = StartSettings {
            void: 0.05,
            ..start(StartKind::Filled)
        };
        let z = start_vectors(&settings, &Lattice::sample(3, 2, 0.0), 20.0, 0).unwrap();
        // exp multiplies the roundings of z by 20.
        assert!(z.iter().all(|z| (void(z) - 0.05).abs() < 1e-14));
    }

    #[test]
    fn a_layout_for_another_lattice_is_refused() {
        let error = vectors(StartKind::Layout, 5, 5).unwrap_err();
        assert!(error.to_string().contains("has 5x5"));
    }
}
