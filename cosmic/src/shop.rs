//! Lists for a workshop that builds a robot: its pieces, and the lengths of its actuators over time.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

use crate::case::Case;
use crate::design::Material;
use crate::lattice::Lattice;
use crate::policy::frequency;
use crate::scene::{
    ActuatorPart, GoalKind, MaterialSettings, Named, PartsSettings, Scene, SkeletonPart,
};
use crate::walk;
use crate::world::Trajectory;

/// The number of rows of a [`SetPoints`] in a period, without the last, which repeats the first.
const ROWS: usize = 100;
/// How much an activation at the end of a period may differ from that at its start: the clock's phase is rounded.
const ROUNDING: f64 = 1e-9;

/// Returns the name of the part that is used for bars of a material; `None` for bars of plain numbers.
pub fn part(parts: &PartsSettings, material: Material) -> Option<&'static str> {
    match material {
        Material::Actuator if parts.actuator == ActuatorPart::Numbers => None,
        Material::Actuator => Some(parts.actuator.name()),
        _ if parts.skeleton == SkeletonPart::Numbers => None,
        _ => Some(parts.skeleton.name()),
    }
}

/// Returns the name of a solid material in tables.
pub fn made_of(material: Material) -> &'static str {
    match material {
        Material::Actuator => "actuator",
        Material::Void | Material::Skeleton => "skeleton",
    }
}

/// Returns the mass of a bar with its fittings, kg. `length` is its rest length, m.
pub fn mass(materials: &MaterialSettings, material: Material, length: f64) -> f64 {
    material.of(&materials.of_length(length).density) * length
}

/// Pieces of a robot that are equal.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// The name of the part, or `skeleton`, `actuator`, `joint`, `node` or `payload`.
    pub name: &'static str,
    /// The length from joint to joint, m; `None` for pieces that are no bars.
    pub length: Option<f64>,
    /// The mass of one, kg.
    pub mass: f64,
    /// The number of the edge of each; of nodes and payload, the number of the node.
    pub places: Vec<usize>,
}

/// Returns the pieces of a robot: bars of equal length and material, joints, nodes and payload. Together they weigh what the
/// robot weighs. `materials` has a material for each edge.
pub fn pieces(scene: &Scene, lattice: &Lattice, materials: &[Material]) -> Vec<Piece> {
    let (parts, physics) = (&scene.materials.parts, &scene.physics);
    // Pieces of equal name, length (in whole nanometres) and mass (in whole micrograms), and the place of each.
    let mut pieces: BTreeMap<(&str, Option<u64>, u64), Vec<usize>> = BTreeMap::new();
    let whole = |x: f64| (1e9 * x).round() as u64;
    let mut count = |name, length: Option<f64>, mass, place| {
        let all = pieces.entry((name, length.map(whole), whole(mass)));
        all.or_default().push(place);
    };
    let mut nodes = BTreeSet::new();
    for (edge, &material) in materials.iter().enumerate().filter(|(_, m)| m.is_solid()) {
        let length = lattice.rest_length[edge];
        let (part, mut mass) = (
            part(parts, material),
            mass(&scene.materials, material, length),
        );
        if part.is_some() {
            mass -= 2.0 * parts.end_mass;
            (0..2).for_each(|_| count("joint", None, parts.end_mass, edge));
        }
        count(part.unwrap_or(made_of(material)), Some(length), mass, edge);
        nodes.extend(lattice.edges[edge]);
    }
    for node in nodes {
        count("node", None, physics.node_mass, node);
    }
    for payload in &lattice.payload {
        count("payload", None, physics.mass_of(payload), payload.node);
    }
    let exact = |whole: u64| whole as f64 * 1e-9;
    let pieces = pieces.into_iter();
    pieces
        .map(|((name, length, mass), places)| Piece {
            name,
            length: length.map(exact),
            mass: exact(mass),
            places,
        })
        .collect()
}

/// The set points of a robot's actuators over one period of its clock.
#[derive(Clone, Debug, PartialEq)]
pub struct SetPoints {
    /// The time between two rows, s. The last row is the first again.
    pub every: f64,
    /// The actuators: the edge, and the length that it shall have in each row, m.
    pub lengths: Vec<(usize, Vec<f64>)>,
}

/// Returns the set points of a robot whose controller sees it as it is at the start (open loop). `None` if they do not repeat,
/// for goals that are given, and without actuators. `materials` has a material for each edge.
pub fn set_points(case: &Case, materials: &[Material]) -> Option<SetPoints> {
    let every = TAU / frequency(&case.scene.controller, &case.controller) / ROWS as f64;
    if !every.is_finite() || case.scene.controller.goals == GoalKind::Given {
        return None;
    }
    let mut case = case.clone();
    case.scene.physics.dt = every;
    let (rows, body): (Vec<usize>, _) = ((0..=ROWS).collect(), case.body());
    let still = Trajectory::new(rows.clone(), vec![case.start.clone(); rows.len()]);
    let moments = walk::moments(&case.world(), &case.robot(), &still);
    let (first, last) = (&moments[0].activation, &moments[ROWS].activation);
    let mut changes = first.iter().zip(last).map(|(a, b)| (a - b).abs());
    if changes.any(|change| change > ROUNDING) {
        return None;
    }
    let length = |edge: usize, row: usize| {
        case.lattice.rest_length[edge] * (1.0 + moments[row].activation[edge] * body.strain[edge])
    };
    let edges = 0..materials.len();
    let actuators = edges.filter(|&edge| materials[edge] == Material::Actuator);
    let lengths = |edge| (edge, rows.iter().map(|&row| length(edge, row)).collect());
    let lengths: Vec<_> = actuators.map(lengths).collect();
    (!lengths.is_empty()).then_some(SetPoints { every, lengths })
}
