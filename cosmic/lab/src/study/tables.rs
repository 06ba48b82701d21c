//! The tables of a study: its trials, the robots in MuJoCo, its questions and its runs.

use super::file::{Question, Trial, Variant};
use crate::measure::{Disturbed, Errands, Measured, quantile_of};
use crate::statistics::{Statistics, mean};
use crate::table::{Cell, Column, Table};
use cosmic::record::summary::ratio;
use std::path::PathBuf;

/// The column with the median displacement of robots that vary a little, in metres. This is the number to quote for a run.
pub(super) const DISPLACEMENT: &str = "displacement_robust_p50";

/// A finished run and its numbers.
#[derive(Clone, Debug)]
pub(super) struct Run {
    pub(super) seed: u64,
    pub(super) folder: PathBuf,
    /// The name and the number of each column. A number is NaN if a rollout diverged, and `None` if it is a ratio that
    /// is meaningless because the robot is unreliable.
    pub(super) numbers: Vec<(String, Option<f64>)>,
    /// The walks to unseen goals; `None` if the goal is fixed.
    pub(super) errands: Option<Errands>,
}

impl Run {
    /// The number in a column; `None` if a rollout diverged or the number is meaningless for this run.
    pub(super) fn number(&self, column: &str) -> Option<f64> {
        let found = self.numbers.iter().find(|(name, _)| name == column)?;
        found.1.filter(|x| x.is_finite())
    }
}

/// A trial and its runs with all seeds.
#[derive(Clone, Debug)]
pub(super) struct TrialRow {
    pub(super) trial: Trial,
    pub(super) runs: Vec<Run>,
}

impl TrialRow {
    /// The numbers of all runs in a column, without those that are meaningless.
    pub(super) fn sample(&self, column: &str) -> Vec<f64> {
        let number = |run: &Run| run.numbers.iter().find(|(name, _)| name == column)?.1;
        self.runs.iter().filter_map(number).collect()
    }

    /// Returns the statistics over the seeds for the numbers in a column.
    pub(super) fn of(&self, column: &str) -> Statistics {
        Statistics::of(&self.sample(column))
    }

    /// The run with the largest displacement. If several runs share it, the first of them; `None` if all runs diverged.
    pub(super) fn best(&self) -> Option<&Run> {
        let runs = self.runs.iter().rev();
        let runs = runs.filter_map(|run| Some((run, run.number(DISPLACEMENT)?)));
        let farthest = runs.max_by(|(_, a), (_, b)| a.total_cmp(b));
        farthest.map(|(run, _)| run)
    }
}

/// The text that tables show for a missing number.
const NONE: &str = "–";

/// To be counted in the column `at least 0.9`, a robot must keep this fraction of its displacement in MuJoCo.
const MOST: f64 = 0.9;

/// The type of a function that computes one number from the numbers of all seeds, in which NaN stands for a diverged
/// run.
type OfSample = fn(&[f64]) -> Option<f64>;

const BEST: OfSample = |s| Statistics::of(s).best;
const MEDIAN: OfSample = |s| Statistics::of(s).median;
const COUNT: OfSample = |s| Some(s.len() as f64);
const DIVERGED: OfSample = |s| Some(s.iter().filter(|x| x.is_nan()).count() as f64);
const ONES: OfSample = |s| Some(s.iter().filter(|x| **x == 1.0).count() as f64);
const SUM: OfSample = |s| Some(s.iter().filter(|x| !x.is_nan()).sum());

/// The columns of the table of trials. Each entry has four parts: the heading; the name of a number that every run has;
/// the function that computes one number from the numbers of all runs; and the number of decimals to show.
const COLUMNS: [(&str, &str, OfSample, usize); 26] = [
    ("best", DISPLACEMENT, BEST, 2),
    ("p10", DISPLACEMENT, |s| Statistics::of(s).p10, 2),
    ("median", DISPLACEMENT, MEDIAN, 2),
    ("±", DISPLACEMENT, |s| Statistics::of(s).standard_error, 2),
    ("p90", DISPLACEMENT, |s| Statistics::of(s).p90, 2),
    ("lengths", "lengths", MEDIAN, 1),
    ("spread", "spread", MEDIAN, 2),
    ("dt/2", "half_step_p50", MEDIAN, 2),
    ("last", "displacement_last_p50", MEDIAN, 2),
    ("goal behind", "goal_behind_p50", MEDIAN, 2),
    ("clock alone", "clock_keeps", MEDIAN, 2),
    ("x", "displacement_x", MEDIAN, 2),
    ("y", "displacement_y", MEDIAN, 2),
    ("peak strain", "strain_peak", MEDIAN, 2),
    ("largest strain", "strain_peak", BEST, 2),
    ("V", "V", MEDIAN, 3),
    ("V_act", "V_act", MEDIAN, 3),
    ("runs", "seconds", COUNT, 0),
    ("diverged", "seconds", DIVERGED, 0),
    ("reliable", "reliable", ONES, 0),
    ("one-hot", "one_hot", ONES, 0),
    ("in bounds", "within_bounds", ONES, 0),
    ("in one piece", "pieces", ONES, 0),
    ("steered", "steered", ONES, 0),
    ("gradients skipped", "skipped_gradients", SUM, 0),
    ("seconds", "seconds", MEDIAN, 1),
];

/// The table with a row for each trial.
pub(super) fn trials(variant: &Variant, rows: &[&TrialRow]) -> Table {
    let title = variant.title.as_deref().unwrap_or("Trials");
    let over_paper = |row: &&TrialRow| Some(row.of(DISPLACEMENT).median? / row.trial.paper?);
    let mut table = Table::of(&variant.name, title, rows)
        .column("trial", "", |row| &row.trial.title[..])
        .column("paper", "", |row| row.trial.paper)
        .column("median / paper", "", over_paper)
        .column("spread of the best", "", |row| row.best()?.number("spread"))
        .decimals(2, NONE);
    for (name, column, number, decimals) in COLUMNS {
        let head = Column::new(name, "").decimals(decimals, NONE);
        table = table.add(head, |row| number(&row.sample(column)));
    }
    table.done()
}

/// The table with a row for each trial and friction. It shows quantiles over the seeds.
pub(super) fn in_mujoco(frictions: &[f64], rows: &[TrialRow]) -> Table {
    let of_row = |row| frictions.iter().map(move |friction| (row, friction));
    let pairs: Vec<(&TrialRow, &f64)> = rows.iter().flat_map(of_row).collect();
    let mut table = Table::of("mujoco", "In MuJoCo", &pairs)
        .column("trial", "", |(row, _)| &row.trial.title[..])
        .column("friction", "", |(_, friction)| **friction)
        .column("at least 0.9", "", |(row, friction)| {
            let keeps = row.sample(&format!("keeps_{friction}")).into_iter();
            keeps.filter(|keeps| *keeps >= MOST).count()
        });
    for (name, column) in [
        ("designed", DISPLACEMENT),
        ("MuJoCo", "mujoco_{}"),
        ("keeps", "keeps_{}"),
        ("Coulomb here", "coulomb_{}"),
        ("agrees", "agrees_{}"),
    ] {
        let names = ["", ", p10", ", p90"].map(|which| format!("{name}{which}"));
        table = table.columns(names, "", |(row, friction), k| {
            let statistics = row.of(&column.replace("{}", &friction.to_string()));
            [statistics.median, statistics.p10, statistics.p90][k]
        });
    }
    table.decimals(2, NONE).done()
}

/// The table of the walks to unseen goals, with a row for each trial and disturbance; `None` if no trial has given goals.
/// Quantiles are over the goals of all seeds.
pub(super) fn errands(rows: &[TrialRow]) -> Option<Table> {
    let with_errands = |row: &&TrialRow| row.runs.iter().all(|run| run.errands.is_some());
    let of_row = |row| Errands::DISTURBED.map(|disturbed| (row, disturbed));
    let pairs: Vec<_> = (rows.iter().filter(with_errands))
        .flat_map(of_row)
        .collect();
    let measure = |&(row, (.., of)): &(&TrialRow, Disturbed), measured: Measured| {
        let robots = row.runs.iter().filter_map(|run| run.errands.as_ref());
        quantile_of(robots.map(of), measured)
    };
    // The part of the way that a robot walks, in the worse direction over that in the better one.
    let evenness = |pair: &(&TrialRow, Disturbed)| {
        let [_, _, ahead, behind, ..] = Errands::MEASURED.map(|measured| measure(pair, measured));
        let (ahead, behind) = (1.0 - ahead?, 1.0 - behind?);
        let better = ahead.max(behind);
        (better > 0.0).then(|| ahead.min(behind) / better)
    };
    let mut table = Table::of("errands", "Errands", &pairs)
        .column("trial", "", |(row, _)| &row.trial.title[..])
        .column("disturbance", "", |(_, (_, title, _))| *title);
    for measured in Errands::MEASURED {
        table = table.column(measured.1, "", |pair| measure(pair, measured));
    }
    let table = table.column("worse / better", "", evenness);
    (!pairs.is_empty()).then(|| table.decimals(2, NONE).done())
}

/// The table with a row for each question. A question asks for the change from one group of trials to another. Runs
/// with equal seeds have equal starts. So the change is computed for each seed, and then its mean over the seeds. If
/// the mean is at most twice its standard error, the question is undecided.
pub(super) fn questions(questions: &[Question], rows: &[TrialRow]) -> Table {
    let mean_of = |names: &[String], number: &dyn Fn(&TrialRow) -> Option<f64>| -> Option<f64> {
        let named = |name: &String| rows.iter().find(|row| row.trial.name == *name);
        let numbers = names.iter().map(|name| number(named(name)?));
        Some(numbers.sum::<Option<f64>>()? / names.len() as f64)
    };
    let medians = |asked: &Question| {
        [&asked.from, &asked.to].map(|names| mean_of(names, &|row| row.of(DISPLACEMENT).median))
    };
    let changes = |asked: &Question| -> Option<Vec<f64>> {
        let at = |seed: usize, names| mean_of(names, &|row| row.runs[seed].number(DISPLACEMENT));
        let change = |seed| Some(at(seed, &asked.to)? - at(seed, &asked.from)?);
        (0..rows.first()?.runs.len()).map(change).collect()
    };
    let verdict = |asked: &Question| match changes(asked).map(|changes| mean(&changes)) {
        None => "unknown: runs diverged",
        Some(None) => "undecided: one seed gives no standard error",
        Some(Some([change, error])) if change.abs() <= 2.0 * error => "undecided",
        Some(Some([change, _])) if change < 0.0 => "less",
        Some(Some(_)) => "more",
    };
    let gain = |asked: &Question| ratio(medians(asked)[1], medians(asked)[0]);
    let change = |asked: &Question, k: usize| Some(mean(&changes(asked)?)?[k]);
    Table::of("questions", "Questions", questions)
        .column("question", "", |asked| &asked.ask[..])
        .columns(["from", "to"], "", |asked, k| medians(asked)[k])
        .column("to / from", "", gain)
        .columns(["change", "±"], "", change)
        .column("verdict", "", verdict)
        .column("the paper", "", |asked| &asked.paper[..])
        .decimals(2, NONE)
        .done()
}

/// The table with a row for each run and a column for every number. A cell without a number is empty.
pub(super) fn runs<'r>(rows: &'r [TrialRow]) -> Table {
    let of_row = |row: &'r TrialRow| row.runs.iter().map(move |run| (&row.trial, run));
    let runs: Vec<(&Trial, &Run)> = rows.iter().flat_map(of_row).collect();
    let first = runs.first().map_or(&[][..], |(_, run)| &run.numbers);
    let names = first.iter().map(|(name, _)| &name[..]);
    let number = |(_, run): &(&Trial, &Run), k: usize| run.number(&first[k].0);
    Table::of("", "", &runs)
        .column("table", "", |(trial, _)| &trial.table[..])
        .column("trial", "", |(trial, _)| &trial.name[..])
        .column("seed", "", |(_, run)| Cell::Count(run.seed))
        .columns(names, "", number)
        .done()
}
