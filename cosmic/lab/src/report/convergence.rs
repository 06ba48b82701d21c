//! The data of the charts of an optimisation's history over the iterations, which the page draws.

use super::files::RunFiles;
use super::gait::four_digits;
use crate::table::Cell;
use cosmic::search::Record;
use serde::Serialize;

/// A chart of numbers over the iterations.
#[derive(Serialize)]
pub(super) struct Chart {
    /// The id of the HTML canvas on which a page draws the chart.
    id: &'static str,
    title: &'static str,
    series: Vec<Series>,
    /// The numbers at which dashed lines are drawn.
    levels: Vec<f64>,
    /// True for a logarithmic axis.
    log: bool,
}

/// A line of a chart.
#[derive(Serialize)]
struct Series {
    name: &'static str,
    /// The index of the line's colour.
    colour: usize,
    /// A cell for each iteration. The line continues over a missing number; a text interrupts the line.
    numbers: Vec<Cell>,
}

/// Creates a line of a chart. `number` returns the number of an iteration, if there is one.
fn series(
    run: &RunFiles,
    name: &'static str,
    colour: usize,
    number: impl Fn(&Record) -> Option<f64>,
) -> Series {
    let cell = |record: &Record| match number(record) {
        Some(x) if !x.is_finite() => Cell::from("diverged"),
        number => number.map(four_digits).into(),
    };
    Series {
        name,
        colour,
        numbers: run.history.iter().map(cell).collect(),
    }
}

/// Creates two lines of the displacement over the iterations: in full rollouts, and in the rollouts from which
/// gradients were computed.
fn displacements(run: &RunFiles) -> Vec<Series> {
    let full = |r: &Record| match r.diverged {
        true => Some(f64::NAN),
        false => r.displacement,
    };
    // If the robot diverged in the rollout of the gradient, the history has no displacement.
    let horizon = |r: &Record| match r.pass {
        Some(_) => Some(r.displacement_horizon.unwrap_or(f64::NAN)),
        None => r.displacement_horizon,
    };
    vec![
        series(run, "full rollout", 0, full),
        series(run, "gradient's horizon", 1, horizon),
    ]
}

/// Creates the charts of a run, from top to bottom.
pub(super) fn charts(run: &RunFiles) -> Vec<Chart> {
    let bounds = &run.robot.scene.volume;
    let mut bounds = [bounds.solid, bounds.actuator].concat();
    bounds.dedup();
    let pairs = [
        "norm",
        "void\u{2013}skeleton",
        "void\u{2013}actuator",
        "skeleton\u{2013}actuator",
    ];
    let measures = [0, 1, 2, 3].map(|k| series(run, pairs[k], k, |r| Some(r.measures[k])));
    let objective = objective(run);
    let title = match &objective {
        Some(_) => "Displacement along the ground, m",
        None => "Objective: displacement along the ground, m",
    };
    let others = [
        Chart {
            id: "displacement",
            title,
            series: displacements(run),
            levels: run.summary.displacement_robust_p50.into_iter().collect(),
            log: false,
        },
        Chart {
            id: "volumes",
            title: "Share of edges",
            series: vec![
                series(run, "solid", 0, |r| Some(r.volume)),
                series(run, "actuators", 1, |r| Some(r.actuator_volume)),
            ],
            levels: bounds,
            log: false,
        },
        Chart {
            id: "measures",
            title: "Binarisation measures, overlaps by pair",
            series: measures.into(),
            levels: Vec::new(),
            log: false,
        },
        Chart {
            id: "gradients",
            title: "Norm of the gradient before any bound",
            series: vec![
                series(run, "design", 0, |r| r.design_gradient[0]),
                series(run, "design, stability", 2, |r| r.design_gradient[1]),
                series(run, "controller", 1, |r| r.controller_gradient),
            ],
            levels: Vec::new(),
            log: true,
        },
    ];
    objective.into_iter().chain(others).collect()
}

/// Creates the chart of the loss; `None` if the objective is the displacement.
fn objective(run: &RunFiles) -> Option<Chart> {
    let loss_p50 = run.summary.loss_p50?;
    let loss = |r: &Record| r.pass.map(|_| r.loss_horizon.unwrap_or(f64::NAN));
    Some(Chart {
        id: "objective",
        title: "Objective: loss, less is better",
        series: vec![series(run, "gradient's horizon", 1, loss)],
        levels: loss_p50.into_iter().collect(),
        log: false,
    })
}
