//! The loads of a run's bars on its page: a sentence about the strains of actuators, and a table.

use super::files::RunFiles;
use super::gait::Gait;
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
    let table = table.done().to_html();
    format!(
        "<details><summary>Strain, force, speed and power of every actuator</summary>\n<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Loads of actuators\">{table}</div></details>\n"
    )
}
