//! What a workshop needs besides the bars: the list of parts to buy and to saw, and what drives the actuators.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::member::{DECIMALS, Member, nodes_of};
use crate::report::RunFiles;
use crate::report::gait::Gait;
use crate::table::Table;
use cosmic::case::Case;
use cosmic::scene::{ActuatorPart, GoalKind, Named, SkeletonPart};
use cosmic::simulator::Trajectory;

/// The number of rows of the table of set points in a period.
const ROWS: usize = 100;
/// How much an activation at the end of a period may differ from that at its start: the clock's phase is rounded.
const ROUNDING: f64 = 1e-9;

/// Equal pieces of a robot.
#[derive(Debug, Default)]
struct Pieces {
    number: usize,
    /// The mass of one, kg.
    mass: f64,
    /// The numbers of their edges or nodes.
    places: Vec<usize>,
}

/// Returns the table of parts: bars of equal length and material, joints, nodes and payload. Together they weigh what the
/// robot weighs.
pub(super) fn parts(run: &RunFiles, members: &[Member]) -> Table {
    let (scene, lattice) = (&run.robot.scene, &run.robot.lattice);
    let (parts, physics) = (&scene.materials.parts, &scene.physics);
    // Keys sort by name and then by length, which is a whole number of nanometres.
    let mut pieces: BTreeMap<(&str, Option<u64>), Pieces> = BTreeMap::new();
    let mut count = |name, length: Option<f64>, mass, place| {
        let nanometres = length.map(|length| (1e9 * length).round() as u64);
        let all = pieces.entry((name, nanometres)).or_default();
        all.number += 1;
        all.mass = mass;
        all.places.push(place);
    };
    for member in members {
        let name = match member.made_of() {
            "actuator" if parts.actuator != ActuatorPart::Numbers => parts.actuator.name(),
            "skeleton" if parts.skeleton != SkeletonPart::Numbers => parts.skeleton.name(),
            plain => plain,
        };
        let joints = if member.made_of() == name { 0 } else { 2 };
        let numbers = scene.materials.of_length(member.length);
        let mass = member.material.of(&numbers.density) * member.length;
        let mass = mass - joints as f64 * parts.end_mass;
        count(name, Some(member.length), mass, member.edge);
        (0..joints).for_each(|_| count("joint", None, parts.end_mass, member.edge));
    }
    for node in nodes_of(members) {
        count("node", None, physics.node_mass, node);
    }
    for payload in &lattice.payload {
        let mass = payload.mass.unwrap_or(physics.payload_mass);
        count("payload", None, mass, payload.node);
    }
    let rows: Vec<_> = pieces.into_iter().collect();
    let places = |places: &[usize]| {
        let mut places: Vec<String> = places.iter().map(usize::to_string).collect();
        places.dedup();
        places.join(" ")
    };
    let length_says = "from joint to joint, m: a tube is sawn shorter by what its two joints add";
    let places_says = "the numbers of their edges; of nodes and payload, of the nodes";
    Table::of("", "", &rows)
        .column("part", "what it is", |((name, _), _)| *name)
        .column("number", "how many", |(_, all)| all.number)
        .column("length", length_says, |((_, nanometres), _)| {
            nanometres.map(|length| length as f64 * 1e-9)
        })
        .column("mass", "mass of one, kg", |(_, all)| all.mass)
        .column("places", places_says, |(_, all)| places(&all.places))
        .rounded(DECIMALS)
        .done()
}

/// Returns the table of set points: the length that each actuator shall have, over one period of the clock, while the
/// controller sees the robot as it is at the start (open loop). The last row is the first again. `None` if that does not
/// repeat, and for goals that are given.
pub(super) fn drive(run: &RunFiles, gait: &Gait, members: &[Member]) -> Option<Table> {
    let mut case: Case = gait.case.clone();
    let period = TAU / run.robot.omega;
    if !period.is_finite() || case.scene.controller.goals == GoalKind::Given {
        return None;
    }
    let dt = period / ROWS as f64;
    case.scene.physics.dt = dt;
    let (rows, body): (Vec<usize>, _) = ((0..=ROWS).collect(), case.body());
    let still = Trajectory::new(rows.clone(), vec![case.start.clone(); rows.len()]);
    let simulator = case.task().without_feedback(&case.start).simulator;
    let moments = simulator.moments(&body, &case.controller, &still);
    let (first, last) = (&moments[0].activation, &moments[ROWS].activation);
    if first
        .iter()
        .zip(last)
        .any(|(a, b)| (a - b).abs() > ROUNDING)
    {
        return None;
    }
    let mut table = Table::of("", "", &rows).column("time", "s", |row| *row as f64 * dt);
    for member in members.iter().filter(|m| m.made_of() == "actuator") {
        let (edge, rest) = (member.edge, member.length);
        table = table.column(&format!("length_{edge}"), "m", |row| {
            rest * (1.0 + moments[*row].activation[edge] * body.strain[edge])
        });
    }
    Some(table.rounded(DECIMALS).done())
}
