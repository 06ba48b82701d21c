//! The loads of a run's bars on its page: a sentence about the strains of actuators, and two tables.

use super::files::{RobotFiles, RunFiles};
use super::gait::Gait;
use crate::table::{Column, Table, decimals};
use cosmic::Result;
use cosmic::design::Material;
use cosmic::simulator::BarLoad;

/// Returns the loads of every edge: over all steps of the rollout if the run recorded them, otherwise over the states
/// in the trajectory file.
///
/// # Errors
/// If the design does not fit its scene.
pub(crate) fn loads(run: &RunFiles) -> Result<Vec<BarLoad>> {
    Ok(Gait::new(run)?.loads)
}

/// Returns a sentence that compares the largest strains of the actuators with the largest target strain.
pub(super) fn peaks(loads: &[BarLoad], actuators: &[usize], limit: f64) -> String {
    let percent = |strain: f64| decimals(100.0 * strain, 1) + " %";
    let peak = |edge: &&usize| loads[**edge].strain.peak;
    let Some(&most) = actuators.iter().max_by(|a, b| peak(a).total_cmp(&peak(b))) else {
        return "No edge is an actuator.".to_owned();
    };
    let largest = percent(loads[most].strain.peak);
    let (beyond, all) = (
        actuators.iter().filter(|edge| peak(edge) > limit).count(),
        actuators.len(),
    );
    let limit = percent(limit);
    if beyond == 0 {
        return format!(
            "No actuator is strained beyond \u{b1}{limit}, the largest target strain; the largest strain is {largest} (edge {most})."
        );
    }
    format!(
        "<b class=\"beyond\">{beyond} of {all} actuators are strained beyond \u{b1}{limit}</b>, the largest target strain; the largest strain is {largest} (edge {most})."
    )
}

/// Returns the table of all actuators, hidden until the reader opens it.
pub(super) fn table(loads: &[BarLoad], actuators: &[usize]) -> String {
    let number = |name, unit, decimals| Column::new(name, "").unit(unit).decimals(decimals, "-");
    if actuators.is_empty() {
        return String::new();
    }
    let table = Table::of("", "", actuators)
        .column("edge", "number in design.json", |edge| *edge)
        .add(number("shortest", "", 3), |edge| loads[*edge].strains.low)
        .add(number("longest", "", 3), |edge| loads[*edge].strains.high)
        .add(number("strain, 99 %", "", 3), |edge| {
            loads[*edge].strain.p99
        })
        .add(number("force", "N", 2), |edge| loads[*edge].force.peak)
        .add(number("force, 99 %", "N", 2), |edge| loads[*edge].force.p99)
        .add(number("speed", "m/s", 2), |edge| loads[*edge].speed.peak)
        .add(number("speed, 99 %", "m/s", 2), |edge| {
            loads[*edge].speed.p99
        })
        .add(number("power", "W", 3), |edge| loads[*edge].power.peak)
        .add(number("power, 99 %", "W", 3), |edge| loads[*edge].power.p99);
    folded(
        "Strain, force, speed and power of every actuator",
        "Loads of actuators",
        &table.done(),
    )
}

/// Returns the table of all bars, hidden until the reader opens it.
pub(super) fn bars(robot: &RobotFiles, loads: &[BarLoad]) -> String {
    let bars = robot.edges_of(Material::is_solid);
    if bars.is_empty() {
        return String::new();
    }
    let (materials, design) = (&robot.scene.materials, &robot.design.materials);
    let length = |edge: &usize| robot.lattice.rest_length[*edge];
    let mass = |edge: &usize| {
        let density = materials.of_length(length(edge)).density;
        design[*edge].of(&density) * length(edge)
    };
    let kind = |edge: &usize| match design[*edge] {
        Material::Actuator => "actuator",
        _ => "skeleton",
    };
    let safety = |edge: &usize| loads[*edge].euler_safety(materials, design[*edge], length(edge));
    let number = |name, unit, decimals| Column::new(name, "").unit(unit).decimals(decimals, "-");
    let says = "force under which the bar buckles (Euler), divided by the largest push";
    let table = Table::of("", "", &bars)
        .column("edge", "number in design.json", |edge| *edge)
        .column("material", "", kind)
        .add(number("length", "m", 3), length)
        .add(number("mass", "kg", 4), mass)
        .add(number("largest strain", "", 4), |edge| {
            loads[*edge].strain.peak
        })
        .add(number("largest pull", "N", 2), |edge| loads[*edge].tension)
        .add(number("largest push", "N", 2), |edge| {
            loads[*edge].compression
        })
        .add(
            Column::new("Euler safety", says).decimals(2, "not known"),
            safety,
        );
    folded(
        "Length, mass, strain, force and Euler safety of every bar",
        "Loads of bars",
        &table.done(),
    )
}

/// Returns a table that is hidden until the reader opens it by a click on `title`. Screen readers call it `label`.
fn folded(title: &str, label: &str, table: &Table) -> String {
    let table = table.to_html();
    format!(
        "<details><summary>{title}</summary>\n<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"{label}\">{table}</div></details>\n"
    )
}
