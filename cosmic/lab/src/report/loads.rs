//! The loads of a run's bars on its page: a sentence about the strains of actuators, and two tables.

use super::files::{RobotFiles, RunFiles};
use super::gait::Gait;
use super::member::{self, members};
use crate::table::Table;
use cosmic::Result;
use cosmic::numbers::decimals;
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
    if actuators.is_empty() {
        return String::new();
    }
    let table = Table::of("", "", actuators)
        .column("edge", "number in design.json", |edge| *edge)
        .keyed(|edge| Some(&loads[*edge]));
    folded(
        "Strain, force, speed and power of every actuator",
        "Loads of actuators",
        &table.done(),
    )
}

/// Returns the table of all bars, hidden until the reader opens it.
pub(super) fn bars(robot: &RobotFiles, loads: &[BarLoad]) -> String {
    let members = members(robot);
    if members.is_empty() {
        return String::new();
    }
    let shown = [
        "edge",
        "material",
        "rest_length",
        "mass",
        "peak_strain",
        "peak_tension",
        "peak_compression",
        "euler_safety",
    ];
    folded(
        "Length, mass, strain, force and Euler safety of every bar",
        "Loads of bars",
        &member::bars(robot, &members, loads).with(&shown),
    )
}

/// Returns a table that is hidden until the reader opens it by a click on `title`. Screen readers call it `label`.
fn folded(title: &str, label: &str, table: &Table) -> String {
    let table = table.to_html();
    format!(
        "<details><summary>{title}</summary>\n<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"{label}\">{table}</div></details>\n"
    )
}
