//! The numbers of runs for comparisons.

use crate::table::{Cell, Column, TableOf};
use cosmic::record::Summary;

/// Adds the numbers of every run's summary to a table of runs, with the loss if any run is ranked by its
/// loss: its task is not distance, or the caller supplied the loss.
pub(super) fn with_numbers<'r, S>(
    table: TableOf<'r, S>,
    of: impl Fn(&'r S) -> &'r Summary + Copy,
) -> TableOf<'r, S> {
    let share = |name, says| Column::new(name, says).decimals(3, "diverged");
    let metres = |name, says| share(name, says).unit("m");
    let p50 = metres("p50", "displacement: median over perturbed starts");
    let p10 = metres("p10", "displacement: 10 % quantile over perturbed starts");
    let p90 = metres("p90", "displacement: 90 % quantile over perturbed starts");
    let says = "displacement of the last iterate: median over perturbed starts";
    let last = metres("last p50", says);
    let says = "displacement in open loop, without feedback: median over perturbed starts";
    let clock = metres("clock alone", says);
    let says = "displacement with the goal behind, median over perturbed starts; negative: towards the goal";
    let behind = metres("behind", says);
    let single = metres("single", "displacement of one unperturbed rollout");
    let says = "whether the median describes the robot well";
    let verdict = Column::new("reliability", says).decimals(0, "–");
    let solid = share("V", "share of solid edges");
    let actuators = share("V_act", "share of actuators");
    let seed = Column::new("seed", "seed of the random generator");
    let seconds = Column::new("time", "duration of the optimisation").unit("s");
    let seconds = seconds.decimals(1, "-");
    let says = "loss: median over the same perturbed starts";
    let loss = Column::new("loss p50", says).decimals(4, "–");
    let count = |name, says| Column::new(name, says).decimals(0, "–");
    let pieces = count("pieces", "connected pieces of bars");
    let nodes = count("nodes", "nodes with a bar");
    let ends = count("free ends", "ends of bars without another bar");
    let crossings = count("crossings", "pairs of bars that cross");
    // An undecided design has no bars yet: its cells say so and do not look missing.
    let decided = |number: fn(&Summary) -> Option<f64>| {
        move |run| match of(run) {
            summary if summary.is_undecided() => Cell::from("undecided"),
            summary => number(summary).into(),
        }
    };
    let strain = Column::new("strain", "largest strain of an actuator").decimals(3, "–");
    let has = |number: fn(&Summary) -> Option<f64>| {
        let mut runs = table.subjects().iter();
        runs.any(|run| number(of(run)).is_some())
    };
    let has_loss = has(|s| s.loss_p50);
    let has_behind = has(|s| s.displacement_behind_p50);
    let mut table = table
        .add(p50, |run| of(run).displacement_p50)
        .add(verdict, |run| of(run).verdict())
        .add(p10, |run| of(run).displacement_p10)
        .add(p90, |run| of(run).displacement_p90)
        .add(last, |run| of(run).displacement_last_p50)
        .add(clock, |run| of(run).displacement_clock_p50)
        .add(single, |run| of(run).displacement_along)
        .add(solid, |run| of(run).volume)
        .add(actuators, |run| of(run).actuator_volume)
        .add(pieces, decided(|s| Some(s.structure?.pieces as f64)))
        .add(nodes, decided(|s| Some(s.structure?.nodes as f64)))
        .add(ends, decided(|s| Some(s.structure?.free_ends as f64)))
        .add(crossings, decided(|s| Some(s.structure?.crossings as f64)))
        .add(strain, decided(|s| Some(s.loads.as_ref()?.strain.peak)))
        .add(seed, |run| Cell::Count(of(run).seed))
        .add(seconds, |run| of(run).seconds);
    if has_behind {
        table = table.add(behind, |run| of(run).displacement_behind_p50);
    }
    if has_loss {
        table = table.add(loss, |run| of(run).loss_p50);
    }
    table
}

/// The names of the options by which a run departs from the paper, for people.
pub fn departures(summary: &Summary) -> String {
    let departures = summary.departures.iter();
    let names: Vec<&str> = departures.map(|d| &d.option[..]).collect();
    if names.is_empty() {
        return "none".to_owned();
    }
    names.join(", ")
}
