//! The numbers of runs for comparisons.

use crate::table::{Cell, Column, TableOf};
use cosmic::record::Summary;

/// Adds the numbers of every run's summary to a table of runs. The loss is among them if a run is ranked
/// by it, because of another task than distance or of a loss of its own.
pub(super) fn with_numbers<'r, S>(
    table: TableOf<'r, S>,
    summary: impl Fn(&'r S) -> &'r Summary + Copy,
) -> TableOf<'r, S> {
    let share = |name: &str, says: &str| Column::new(name, says).decimals(3, "diverged");
    let metres = |name: &str, says: &str| share(name, &format!("displacement{says}")).unit("m");
    let seconds = Column::new("time", "duration of the optimisation").unit("s");
    let has_loss = table
        .subjects()
        .iter()
        .any(|run| summary(run).loss_p50.is_some());
    let table = table
        .add(metres("p50", ": median over perturbed starts"), |run| {
            summary(run).displacement_p50
        })
        .add(
            metres("p10", ": 10 % quantile over perturbed starts"),
            |run| summary(run).displacement_p10,
        )
        .add(
            metres("p90", ": 90 % quantile over perturbed starts"),
            |run| summary(run).displacement_p90,
        )
        .add(
            metres(
                "last p50",
                " of the last iterate: median over perturbed starts",
            ),
            |run| summary(run).displacement_last_p50,
        )
        .add(metres("single", " of one unperturbed rollout"), |run| {
            summary(run).displacement_along
        })
        .add(share("V", "share of solid edges"), |run| {
            summary(run).volume
        })
        .add(share("V_act", "share of actuators"), |run| {
            summary(run).actuator_volume
        })
        .column("seed", "seed of the random generator", |run| {
            Cell::Count(summary(run).seed)
        })
        .add(seconds.decimals(1, "-"), |run| summary(run).seconds);
    if !has_loss {
        return table;
    }
    let says = "loss: median over the same perturbed starts";
    let loss = Column::new("loss p50", says).decimals(4, "–");
    table.add(loss, |run| summary(run).loss_p50)
}
