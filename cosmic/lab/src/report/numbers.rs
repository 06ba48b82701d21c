//! The numbers of runs that are worth comparing.

use crate::table::{Cell, Column};
use cosmic::record::Summary;

/// A column of runs, and the cell that a run has in it.
pub(super) struct SummaryColumn {
    pub(super) column: Column,
    pub(super) of: fn(&Summary) -> Cell,
}

/// The columns for some runs, the loss among them where one is ranked by it: by another task than
/// to get far, or by a loss of its own.
pub(super) fn summary_columns(runs: &[&Summary]) -> Vec<SummaryColumn> {
    let column = |name: &str, says: &str, of| SummaryColumn {
        column: Column::new(name, says).decimals(3, "diverged"),
        of,
    };
    let metres = |name: &str, says: &str, of| {
        let column = column(name, &format!("displacement{says}"), of);
        SummaryColumn {
            column: column.column.unit("m"),
            of,
        }
    };
    let mut columns = vec![
        metres("p50", ": median over perturbed starts", |s| {
            s.displacement_p50.into()
        }),
        metres("p10", ": 10 % quantile over perturbed starts", |s| {
            s.displacement_p10.into()
        }),
        metres("p90", ": 90 % quantile over perturbed starts", |s| {
            s.displacement_p90.into()
        }),
        metres(
            "last p50",
            " of the last iterate: median over perturbed starts",
            |s| s.displacement_last_p50.into(),
        ),
        metres("single", " of one unperturbed rollout", |s| {
            Cell::Number(s.displacement_along)
        }),
        column("V", "share of solid edges", |s| Cell::Number(s.volume)),
        column("V_act", "share of actuators", |s| {
            Cell::Number(s.actuator_volume)
        }),
        column("seed", "seed of the random generator", |s| {
            Cell::Count(s.seed)
        }),
        SummaryColumn {
            column: Column::new("time", "duration of the optimisation")
                .unit("s")
                .decimals(1, "-"),
            of: |s| Cell::Number(s.seconds),
        },
    ];
    if runs.iter().any(|run| run.loss_p50.is_some()) {
        let says = "loss: median over the same perturbed starts";
        columns.push(SummaryColumn {
            column: Column::new("loss p50", says).decimals(4, "–"),
            of: |s| s.loss_p50.into(),
        });
    }
    columns
}
