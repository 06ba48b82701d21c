//! The numbers of runs that comparisons show.

use crate::table::{Cell, Column, TableOf};
use cosmic::record::Summary;

/// A run whose numbers a table shows.
#[derive(Clone, Copy)]
pub(super) struct Shown<'r> {
    pub(super) summary: &'r Summary,
    /// The duration of its walk, s; `None` if it is not known.
    pub(super) seconds: Option<f64>,
}

/// Adds five columns to a table with the names of runs: the objective, the speed, the mass, the energy and the bars that
/// pass through each other. If one of the runs has a loss, the loss is the objective, and the displacement replaces the
/// energy.
pub(super) fn with_six<'r, S>(
    table: TableOf<'r, S>,
    of: impl Fn(&'r S) -> Shown<'r> + Copy,
) -> TableOf<'r, S> {
    let has_loss = |run| of(run).summary.loss_p50.is_some();
    let has_loss = table.subjects().iter().any(has_loss);
    let far = Column::new(
        "distance",
        "displacement: median of robots that vary a little",
    )
    .unit("m");
    let far = far.decimals(3, "diverged");
    let loss = Column::new("loss", "loss: median over perturbed starts").decimals(4, "–");
    let says = "the distance divided by the duration of the walk";
    let speed = Column::new("speed", says)
        .unit("m/s")
        .decimals(3, "not known");
    let mass = Column::new("mass", "of the robot with its payload");
    let mass = mass.unit("kg").decimals(3, "not known");
    let says = "energy per metre at this speed, without the losses of actuators";
    let energy = Column::new("energy", says)
        .unit("J/m")
        .decimals(1, "not known");
    let says = "the largest number of pairs of bars that pass through each other at a time";
    let pairs = Column::new("crossing pairs", says).decimals(0, "not known");
    let distance = move |run: &'r S| of(run).summary.displacement_robust_p50;
    let table = match has_loss {
        true => table
            .add(loss, move |run| of(run).summary.loss_p50)
            .add(far, distance),
        false => table.add(far, distance),
    };
    let table = table
        .add(speed, move |run| {
            let Shown { summary, seconds } = of(run);
            Some(summary.displacement_robust_p50? / seconds?)
        })
        .add(mass, move |run| Some(of(run).summary.quoted_energy()?.mass));
    let table = match has_loss {
        true => table,
        false => table.add(energy, move |run| {
            of(run).summary.quoted_energy()?.per_metre
        }),
    };
    table.add(pairs, move |run| crossing_pairs(of(run).summary))
}

/// The largest number of pairs of bars that pass through each other at a time.
fn crossing_pairs(summary: &Summary) -> Cell {
    decided(summary, |s| Some(s.loads.as_ref()?.most_tangles as f64))
}

/// A column of a table of runs, and the function that returns the cell of a run.
type Number = (Column, fn(&Summary) -> Cell);

/// Adds columns with the numbers of every run's summary to a table of runs.
pub(super) fn with_numbers<'r, S>(
    table: TableOf<'r, S>,
    of: impl Fn(&'r S) -> &'r Summary + Copy,
) -> TableOf<'r, S> {
    let runs = table.subjects();
    let is_there = |(_, cell): &Number| runs.iter().any(|run| cell(of(run)) != Cell::Missing);
    let rare = rare().into_iter().filter(is_there);
    let add =
        |table: TableOf<'r, S>, (column, cell): Number| table.add(column, |run| cell(of(run)));
    numbers().into_iter().chain(rare).fold(table, add)
}

/// Returns the columns that every table has.
fn numbers() -> [Number; 24] {
    let share = |name, says| Column::new(name, says).decimals(3, "diverged");
    let metres = |name, says| share(name, says).unit("m");
    let says = "displacement: median of robots that vary a little";
    let robust = metres("robust p50", says);
    let says = "displacement: 10 % quantile of robots that vary a little";
    let low = metres("robust p10", says);
    let says = "displacement with half the time step: median over perturbed starts";
    let half = metres("half step", says);
    let says = "displacement with another integrator: median over perturbed starts";
    let other = Column::new("integrator", says).unit("m").decimals(3, "–");
    let p50 = metres("p50", "displacement: median over perturbed starts");
    let p10 = metres("p10", "displacement: 10 % quantile over perturbed starts");
    let p90 = metres("p90", "displacement: 90 % quantile over perturbed starts");
    let says = "displacement of the last iterate: median over perturbed starts";
    let last = metres("last p50", says);
    let says = "displacement in open loop, without feedback: median over perturbed starts";
    let clock = metres("clock alone", says);
    let single = metres("single", "displacement of one unperturbed rollout");
    let says = "whether the median describes the robot well";
    let verdict = Column::new("reliability", says).decimals(0, "–");
    let solid = share("V", "share of solid edges");
    let actuators = share("V_act", "share of actuators");
    let seed = Column::new("seed", "seed of the random generator");
    let seconds = Column::new("time", "duration of the optimisation").unit("s");
    let seconds = seconds.decimals(1, "-");
    let count = |name, says| Column::new(name, says).decimals(0, "–");
    let strain = Column::new("strain", "largest strain of an actuator").decimals(3, "–");
    let pieces = count("pieces", "connected pieces of bars");
    let nodes = count("nodes", "nodes with a bar");
    let ends = count("free ends", "ends of bars without another bar");
    let crossings = count("crossings", "pairs of bars that cross at rest");
    let says = "the largest number of pairs of bars that pass through each other in motion";
    let tangles = Column::new("tangles", says).decimals(0, "not known");
    let energy = |name, says| Column::new(name, says).decimals(3, "not known");
    let mass = energy("mass", "mass of the robot with its payload").unit("kg");
    let says = "mean power of all actuators, without their losses";
    let power = energy("power", says).unit("W");
    let says = "cost of transport: energy per distance and weight, without losses";
    let cost = energy("cost", says).decimals(2, "not known");
    [
        (robust, |s| s.displacement_robust_p50.into()),
        (verdict, |s| s.reliability.word().into()),
        (low, |s| s.displacement_robust_p10.into()),
        (half, |s| s.displacement_half_step_p50.into()),
        (other, |s| s.displacement_integrator_p50.into()),
        (p50, |s| s.displacement_p50.into()),
        (p10, |s| s.displacement_p10.into()),
        (p90, |s| s.displacement_p90.into()),
        (last, |s| s.displacement_last_p50.into()),
        (clock, |s| s.displacement_clock_p50.into()),
        (single, |s| s.displacement_along.into()),
        (solid, |s| s.volume.into()),
        (actuators, |s| s.actuator_volume.into()),
        (pieces, |s| decided(s, |s| Some(s.structure?.pieces as f64))),
        (nodes, |s| decided(s, |s| Some(s.structure?.nodes as f64))),
        (ends, |s| {
            decided(s, |s| Some(s.structure?.free_ends as f64))
        }),
        (crossings, |s| {
            decided(s, |s| Some(s.structure?.crossings as f64))
        }),
        (strain, |s| {
            decided(s, |s| Some(s.loads.as_ref()?.strain.peak))
        }),
        (tangles, crossing_pairs),
        (mass, |s| decided(s, |s| Some(s.quoted_energy()?.mass))),
        (power, |s| decided(s, |s| Some(s.quoted_energy()?.power))),
        (cost, |s| {
            decided(s, |s| s.quoted_energy()?.cost_of_transport)
        }),
        (seed, |s| Cell::Count(s.seed)),
        (seconds, |s| s.seconds.into()),
    ]
}

/// Returns the columns that only some tables have: those in which one of the runs has the number. The first column is
/// the loss, by which runs are ranked whose task is not
/// distance or whose loss the caller supplied. The second column is the Euler safety, which scenes with parts have.
fn rare() -> [Number; 2] {
    let says = "loss: median over the same perturbed starts";
    let loss = Column::new("loss p50", says).decimals(4, "–");
    let says = "smallest Euler safety of a skeleton bar: the force under which the bar buckles over the largest force that \
                pushes on it";
    let safety = Column::new("Euler safety", says).decimals(2, "not known");
    [
        (loss, |s| s.loss_p50.into()),
        (safety, |s| match s.loads.as_ref() {
            Some(loads) => loads.euler_safety.into(),
            None => Cell::Missing,
        }),
    ]
}

/// Returns the cell of a number that describes the bars. An undecided design has no bars yet; its cell says "undecided"
/// instead of looking missing.
fn decided(summary: &Summary, number: fn(&Summary) -> Option<f64>) -> Cell {
    match summary.undecided {
        true => "undecided".into(),
        false => number(summary).into(),
    }
}
