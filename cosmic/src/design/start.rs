//! The initial design of an optimisation.

use super::tilt::tilted;
use super::vectors::{average_tied, vectors_of_mixture};
use super::{Design, Material, Mixture};
use crate::error::{Error, Result};
use crate::geometry::Vector;
use crate::lattice::{EdgeRules, Lattice};
use crate::scene::edges;
use crate::scene::{LAYOUT_SIDE, Layout, StartKind, StartSettings};

/// The initial design that the settings describe. `beta` is the sharpness of the performance projection. The seed has
/// an effect only if `tilt` is above 0.
///
/// # Errors
/// [`Error::Usage`] for a layout that was drawn for another lattice.
pub fn start(
    settings: &StartSettings,
    lattice: &Lattice,
    beta: f64,
    seed: u64,
) -> Result<Design<[f64; 3]>> {
    let void = match settings.kind {
        StartKind::Layout => {
            return Ok(Design::Layout(layout_materials(settings.layout, lattice)?));
        }
        StartKind::Uniform => vec![1.0 / 3.0; lattice.edges.len()],
        StartKind::Filled => vec![settings.void; lattice.edges.len()],
        StartKind::Stability => stability_voids(lattice),
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
    let mixture = |&void: &f64| Mixture([void, rest(void), rest(void)]);
    let mixtures: Vec<_> = void.iter().map(mixture).collect();
    let mut z = vectors_of_mixture(&mixtures, beta);
    average_tied(&mut z, &lattice.rules.tie);
    Ok(Design::Undecided(z))
}

/// The material of every edge of the lattice in one of the built-in layouts.
///
/// # Errors
/// [`Error::Usage`] if the layout was drawn for another lattice.
pub fn layout_materials(layout: Layout, lattice: &Lattice) -> Result<Vec<Material>> {
    let Some(numbers) = layout.materials() else {
        return Ok(filled(lattice));
    };
    if lattice.edges != edges(LAYOUT_SIDE, LAYOUT_SIDE) {
        return Err(Error::Usage(format!(
            "the three-legged layouts need a rectangular lattice of {LAYOUT_SIDE}x{LAYOUT_SIDE} nodes, but this \
             lattice has {} nodes and {} edges; set another `start.kind` or `start.layout`",
            lattice.nodes(),
            lattice.edges.len()
        )));
    }
    let material = |number| Material::ALL[usize::from(number)];
    let materials = numbers.into_iter().map(material).collect();
    Ok(allowed(materials, &lattice.rules))
}

/// The share of actuators in the filled layout. It is the largest share of actuators in the paper's table 2.
const FILLED_ACTUATORS: f64 = 0.22;

/// Changes a layout so that it obeys the rules of the lattice. Tied edges get the material of the first of them. An edge
/// whose material is not allowed becomes skeleton, if that is allowed; otherwise it gets its only allowed material.
fn allowed(mut materials: Vec<Material>, rules: &EdgeRules) -> Vec<Material> {
    for tie in &rules.tie {
        tie.iter()
            .for_each(|&edge| materials[edge] = materials[tie[0]]);
    }
    for (edge, material) in materials.iter_mut().enumerate() {
        let allowed = rules.allowed(edge);
        if !material.of(&allowed) {
            let others = [Material::Skeleton, Material::Actuator, Material::Void];
            let other = others.into_iter().find(|other| other.of(&allowed));
            *material = other.unwrap_or(*material);
        }
    }
    materials
}

/// The filled layout, in which every edge is solid. Of the edges steeper than 45 degrees (the vertical edges of a
/// rectangular lattice), as many as the volume budget allows are actuators, spread evenly over rows and columns. All
/// other edges are skeleton. The paper calls this the "uniform distribution of vertical actuators", but does not list
/// its edges.
pub fn filled(lattice: &Lattice) -> Vec<Material> {
    let vertical = |edge: &[usize; 2]| {
        let direction = lattice.direction(*edge);
        let (along, above) = (direction.along().norm(), direction.up());
        // Rounding must not make an edge at 45 degrees steep.
        along < (1.0 - 1e-9) * above.abs()
    };
    let verticals = lattice.edges.iter().filter(|edge| vertical(edge)).count();
    let most = (FILLED_ACTUATORS * lattice.edges.len() as f64) as usize;
    let actuators = most.min(verticals);
    let mut seen = 0;
    let mut material = |edge: &[usize; 2]| {
        if !vertical(edge) {
            return Material::Skeleton;
        }
        // Rounding up makes the first vertical edge an actuator. It is at the payload, which could not be lifted
        // without it.
        let due = |n: usize| (n * actuators).div_ceil(verticals);
        seen += 1;
        if due(seen) > due(seen - 1) {
            Material::Actuator
        } else {
            Material::Skeleton
        }
    };
    let materials = lattice.edges.iter().map(&mut material).collect();
    allowed(materials, &lattice.rules)
}

/// For the start "stability": the surplus of void at the topmost edge (paper: 0.12).
const VOID_SHIFT: f64 = 0.12;

/// The share of void in every edge, `1/3 + VOID_SHIFT * h`. Here `h` is the height of the edge's midpoint relative to the
/// highest midpoint.
fn stability_voids(lattice: &Lattice) -> Vec<f64> {
    let highest = lattice.midpoints().map(Vector::up).fold(0.0, f64::max);
    // All edges of a lattice with one row have the height 0.
    let highest = if highest > 0.0 { highest } else { 1.0 };
    let void = |middle: Vector<f64>| 1.0 / 3.0 + VOID_SHIFT * middle.up() / highest;
    lattice.midpoints().map(void).collect()
}
