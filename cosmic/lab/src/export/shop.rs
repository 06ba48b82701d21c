//! What a workshop needs besides the table of bars: a list of parts, and set points for the actuators.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::member::{DECIMALS, Member, nodes_of};
use crate::report::RunFiles;
use crate::report::gait::Gait;
use crate::table::Table;
use cosmic::case::Case;
use cosmic::design::Material;
use cosmic::scene::GoalKind;
use cosmic::simulator::Trajectory;

/// The number of rows of the table of set points in a period.
const ROWS: usize = 100;
/// How much an activation at the end of a period may differ from that at its start: the clock's phase is rounded.
const ROUNDING: f64 = 1e-9;

/// Returns the table of parts: bars of equal length and material, joints, nodes and payload. Together they weigh what the
/// robot weighs.
pub(super) fn parts(run: &RunFiles, members: &[Member]) -> Table {
    let (scene, lattice) = (&run.robot.scene, &run.robot.lattice);
    let (parts, physics) = (&scene.materials.parts, &scene.physics);
    // Pieces of equal name, length (in whole nanometres) and mass (in whole micrograms), and the edges or nodes of each.
    let mut pieces: BTreeMap<(&str, Option<u64>, u64), Vec<usize>> = BTreeMap::new();
    let whole = |x: f64| (1e9 * x).round() as u64;
    let mut count = |name, length: Option<f64>, mass, place| {
        let all = pieces.entry((name, length.map(whole), whole(mass)));
        all.or_default().push(place);
    };
    for member in members {
        let (part, mut mass) = (member.part(parts), member.mass(&scene.materials));
        if part.is_some() {
            mass -= 2.0 * parts.end_mass;
            (0..2).for_each(|_| count("joint", None, parts.end_mass, member.edge));
        }
        let name = part.unwrap_or(member.made_of());
        count(name, Some(member.length), mass, member.edge);
    }
    for node in nodes_of(members) {
        count("node", None, physics.node_mass, node);
    }
    for payload in &lattice.payload {
        let mass = payload.mass.unwrap_or(physics.payload_mass);
        count("payload", None, mass, payload.node);
    }
    let rows: Vec<_> = pieces.into_iter().collect();
    let names = |places: &[usize]| {
        let mut names: Vec<String> = places.iter().map(usize::to_string).collect();
        names.dedup();
        names.join(" ")
    };
    let length_says = "from joint to joint, m: a tube is sawn shorter by what its two joints add";
    let places_says = "the numbers of their edges; of nodes and payload, of the nodes";
    Table::of("", "", &rows)
        .column("part", "what it is", |((name, ..), _)| *name)
        .column("number", "how many", |(_, places)| places.len())
        .column("length", length_says, |((_, length, _), _)| {
            length.map(|nanometres| nanometres as f64 * 1e-9)
        })
        .column("mass", "mass of one, kg", |((.., micrograms), _)| {
            *micrograms as f64 * 1e-9
        })
        .column("places", places_says, |(_, places)| names(places))
        .rounded(DECIMALS)
        .done()
}

/// Returns the table of set points: the length that each actuator shall have, over one period of the clock, while the
/// controller sees the robot as it is at the start (open loop). The last row is the first again. `None` if that does not
/// repeat, and for goals that are given.
pub(super) fn drive(run: &RunFiles, gait: &Gait, members: &[Member]) -> Option<Table> {
    let dt = TAU / run.robot.omega / ROWS as f64;
    if !dt.is_finite() || gait.case.scene.controller.goals == GoalKind::Given {
        return None;
    }
    let mut case: Case = gait.case.clone();
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
    for member in members.iter().filter(|m| m.material == Material::Actuator) {
        let (edge, rest) = (member.edge, member.length);
        table = table.column(&format!("length_{edge}"), "m", |row| {
            rest * (1.0 + moments[*row].activation[edge] * body.strain[edge])
        });
    }
    Some(table.rounded(DECIMALS).done())
}
