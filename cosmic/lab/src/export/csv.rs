//! The tables of bars and of nodes, in SI units.

use super::layers::joints;
use super::member::{MM, Member, place};
use super::pattern::Pattern;
use super::sizes::Sizes;
use crate::report::{RobotFiles, RunFiles};
use crate::table::{Cell, Column, Table};
use cosmic::controller::observation;
use cosmic::design::Material;
use cosmic::error::Result;
use cosmic::ground::Ground;
use cosmic::lattice::length;
use cosmic::laws::{Bar, BarForce, Stiffening};
use cosmic::record::run::DESIGN;
use std::f64::consts::PI;

/// The largest forces of a bar's spring over the states that a trajectory holds, N.
#[derive(Clone, Copy, Debug, Default)]
struct Peaks {
    tension: f64,
    compression: f64,
}

/// A row for each bar.
pub(super) fn bars(
    run: &RunFiles,
    members: &[Member],
    pattern: Option<&Pattern>,
    sizes: &Sizes,
) -> Result<Table> {
    let materials = &run.robot.scene.materials;
    let peaks = peaks(run)?;
    let of = |m: &Member, library: &[f64; 3]| library[m.material as usize];
    let layer = |k: usize| Cell::from(pattern.map(|p| p.stack.of_member[k] as f64 + 1.0));
    let numbered: Vec<(usize, &Member)> = members.iter().enumerate().collect();
    let strip = |m: &Member| sizes.width * m.span() + 0.25 * PI * sizes.width.powi(2);
    let volume = |m: &Member| (strip(m) - 0.5 * PI * sizes.hole.powi(2)) * sizes.thickness;
    let mass = |m: &Member| of(m, &materials.density) * m.length;
    let table = Table::of("", "", &numbered)
        .column("edge", "number of the edge in design.json", |(_, m)| m.edge)
        .column("from", "node at one end", |(_, m)| m.nodes[0])
        .column("to", "node at the other end", |(_, m)| m.nodes[1])
        .columns(
            ["from_x", "from_y"],
            "place of the first, m",
            |(_, m), k| m.ends[0][k] / MM,
        )
        .columns(["to_x", "to_y"], "place of the second, m", |(_, m), k| {
            m.ends[1][k] / MM
        })
        .column("rest_length", "between the nodes, m", |(_, m)| m.length)
        .column("material", "skeleton or actuator", |(_, m)| m.made_of())
        .column("stroke", "either way from the rest length, m", |(_, m)| {
            stroke(m, &materials.max_strain)
        })
        .column("stiffness", "N/m", |(_, m)| of(m, &materials.stiffness))
        .column("mass", "kg", |(_, m)| mass(m))
        .column("peak_tension", "N", |(_, m)| peaks[m.edge].tension)
        .column("peak_compression", "N", |(_, m)| peaks[m.edge].compression)
        .column("peak_force", "the larger of the two, N", |(_, m)| {
            peaks[m.edge].tension.max(peaks[m.edge].compression)
        })
        .add(whole("layer", "in the flat pattern, from 1"), |(k, _)| {
            layer(*k)
        })
        .column(
            "plate_density",
            "of a plate whose strip weighs as much as the bar, kg/m3",
            |(_, m)| mass(m) / (volume(m) / MM.powi(3)),
        );
    Ok(table.done())
}

/// A row for each node at which a bar ends.
pub(super) fn nodes(
    robot: &RobotFiles,
    members: &[Member],
    pattern: Option<&Pattern>,
    sizes: &Sizes,
) -> Table {
    let nodes: Vec<usize> = joints(members).into_keys().collect();
    let bars = |node: usize| members.iter().filter(|m| m.nodes.contains(&node)).count();
    let physics = &robot.scene.physics;
    let payload = |node: usize| -> f64 {
        let here = robot.lattice.payload.iter().filter(|p| p.node == node);
        here.fold(0.0, |sum, p| sum + p.mass.unwrap_or(physics.payload_mass))
    };
    let span = |node: usize| pattern.map(|pattern| &pattern.stack.at_node[&node]);
    let number = |layer: Option<usize>| Cell::from(layer.map(|layer| layer as f64 + 1.0));
    Table::of("", "", &nodes)
        .column("node", "number of the node", |node| *node)
        .columns(["x", "y"], "m along and above the ground", |node, k| {
            place(robot, *node)[k] / MM
        })
        .column("bars", "how many end here", |node| bars(*node))
        .column("node_mass", "of the node itself, kg", |_| physics.node_mass)
        .column("payload", "extra mass, kg", |node| payload(*node))
        .add(whole("lowest_layer", "of its bars"), |node| {
            number(span(*node).map(|span| *span.start()))
        })
        .add(whole("highest_layer", "of its bars"), |node| {
            number(span(*node).map(|span| *span.end()))
        })
        .column(
            "pin",
            "through all layers from one to the other, m",
            |node| span(*node).map(|s| (s.end() - s.start() + 1) as f64 * sizes.thickness / MM),
        )
        .done()
}

/// A column of whole numbers, some of which may be missing.
fn whole(name: &str, says: &str) -> Column {
    Column::new(name, says).decimals(0, "-")
}

fn stroke(member: &Member, max_strain: &[f64; 3]) -> f64 {
    if member.material == Material::Actuator {
        max_strain[member.material as usize] * member.length
    } else {
        0.0
    }
}

/// The peaks of every edge: its spring's force in the states of the trajectory, with the activation that
/// the controller has there. Nothing is simulated again.
fn peaks(run: &RunFiles) -> Result<Vec<Peaks>> {
    let scene = &run.robot.scene;
    let file = run.folder.join(DESIGN).display().to_string();
    let case = run.robot.design.case(scene, &file)?;
    let (body, lattice) = (case.body(), &case.lattice);
    let ground = Ground::from(&scene.physics);
    // With the coefficient 0 this is Hooke's law.
    let law = Stiffening {
        cubic: scene.physics.stiffening,
    };
    let mut peaks = vec![Peaks::default(); lattice.edges.len()];
    for (&step, state) in run.trajectory.steps.iter().zip(&run.trajectory.states) {
        let time = step as f64 * run.trajectory.dt;
        let seen = observation(&case.observation, time, state, &body.presence, &ground);
        let activation = case.controller.activation(&seen);
        for (edge, peak) in peaks.iter_mut().enumerate() {
            let rest_length = lattice.rest_length[edge];
            let tension = law.tension(Bar {
                length: length(&state.x, lattice.edges[edge]),
                rate: 0.0,
                target: rest_length * (1.0 + body.strain[edge] * activation[edge]),
                rest_length,
                stiffness: body.stiffness[edge],
                strain: body.strain[edge],
            });
            peak.tension = peak.tension.max(tension);
            peak.compression = peak.compression.max(-tension);
        }
    }
    Ok(peaks)
}
