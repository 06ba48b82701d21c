//! The tables of a study: its trials, its walks in MuJoCo, its questions, its runs.

use super::file::{Keys, Question};
use super::rows::{DISPLACEMENT, TrialRow};
use crate::statistics::{Statistics, mean, standard_error};
use crate::table::{Cell, Column, Table};
use cosmic::record::summary::ratio;
use cosmic::scene::Departure;

/// The sign for a missing number.
const NONE: &str = "–";

/// The part of its distance that a robot keeps in MuJoCo to be counted.
const MOST: f64 = 0.9;

type Statistic = fn(Statistics) -> Option<f64>;

const MEDIAN: Statistic = |s| s.median;

/// The statistics that are columns of a trial: heading, column of the runs, statistic, decimals.
const STATISTICS: [(&str, &str, Statistic, usize); 15] = [
    ("best", DISPLACEMENT, |s| s.best, 2),
    ("p10", DISPLACEMENT, |s| s.p10, 2),
    ("median", DISPLACEMENT, MEDIAN, 2),
    ("p90", DISPLACEMENT, |s| s.p90, 2),
    ("spread", "spread", MEDIAN, 2),
    ("dt/2", "half_step_p50", MEDIAN, 2),
    ("last", "displacement_last_p50", MEDIAN, 2),
    ("goal behind", "goal_behind_p50", MEDIAN, 2),
    ("clock alone", "clock_keeps", MEDIAN, 2),
    ("x", "displacement_x", MEDIAN, 2),
    ("y", "displacement_y", MEDIAN, 2),
    ("peak strain", "strain_peak", MEDIAN, 2),
    ("largest strain", "strain_peak", |s| s.best, 2),
    ("V", "V", MEDIAN, 3),
    ("V_act", "V_act", MEDIAN, 3),
];

/// The departures of some trials from the paper, each once.
pub(super) fn departures(rows: &[&TrialRow]) -> Vec<Departure> {
    let mut known: Vec<Departure> = Vec::new();
    for departure in rows.iter().flat_map(|row| row.trial.scene.departures()) {
        if !known.contains(&departure) {
            known.push(departure);
        }
    }
    known
}

/// A row for each trial; letters stand for its departures from the paper.
pub(super) fn trials(rows: &[&TrialRow]) -> Table {
    let known = departures(rows);
    let column = |name: &str, decimals: usize| Column::new(name, "").decimals(decimals, NONE);
    let mut table = Table::of("", "", rows).column("trial", "", |row| &row.trial.title[..]);
    if rows.iter().any(|row| row.trial.paper.is_some()) {
        table =
            table
                .column("paper", "", |row| row.trial.paper)
                .column("median / paper", "", |row| {
                    Some(row.of(DISPLACEMENT).median? / row.trial.paper?)
                });
    }
    let mut table = table
        .column("±", "", |row| standard_error(&row.sample(DISPLACEMENT)))
        .column("spread of the best", "", |row| {
            row.best().and_then(|run| run.number("spread"))
        })
        .decimals(2, NONE);
    for (name, of, statistic, decimals) in STATISTICS {
        table = table.add(column(name, decimals), |row| statistic(row.of(of)));
    }
    let is_one_piece = |row: &&TrialRow| row.sample("pieces").iter().filter(|x| **x == 1.0).count();
    table
        .column("runs", "", |row| row.runs.len())
        .column("diverged", "", |row| {
            row.runs.iter().filter(|run| run.diverged).count()
        })
        .column("one-hot", "", |row| row.sum("one_hot"))
        .column("in bounds", "", |row| row.sum("within_bounds"))
        .column("in one piece", "", is_one_piece)
        .column("steered", "", |row| row.sum("steered"))
        .column("gradients skipped", "", |row| row.sum("skipped_gradients"))
        .add(column("s", 1), |row| row.of("seconds").median)
        .column("departures", "", |row| {
            let own = row.trial.scene.departures();
            let letters = ('A'..).zip(&known).filter(|(_, known)| own.contains(known));
            let letters: String = letters.map(|(letter, _)| letter).collect();
            if letters.is_empty() {
                "none".to_owned()
            } else {
                letters
            }
        })
        .done()
}

/// A row for each trial and friction, with quantiles over the seeds.
pub(super) fn in_mujoco(keys: &Keys, rows: &[TrialRow]) -> Table {
    let pairs = rows
        .iter()
        .flat_map(|row| keys.mujoco.iter().map(move |friction| (row, friction)));
    let pairs: Vec<(&TrialRow, &f64)> = pairs.collect();
    let mut table = Table::of("", "", &pairs)
        .column("trial", "", |(row, _)| &row.trial.title[..])
        .column("friction", "", |(_, friction)| **friction)
        .column("at least 0.9", "", |(row, friction)| {
            let keeps = row.sample(&format!("keeps_{friction}"));
            keeps.iter().filter(|keeps| **keeps >= MOST).count()
        });
    for (name, of) in [
        ("designed", DISPLACEMENT),
        ("MuJoCo", "mujoco_{}"),
        ("keeps", "keeps_{}"),
        ("Coulomb here", "coulomb_{}"),
        ("agrees", "agrees_{}"),
    ] {
        let names = ["", ", p10", ", p90"].map(|which| format!("{name}{which}"));
        table = table.columns(names, "", |(row, friction), k| {
            let statistics = row.of(&of.replace("{}", &friction.to_string()));
            [statistics.median, statistics.p10, statistics.p90][k]
        });
    }
    table.decimals(2, NONE).done()
}

/// The change from some trials to others. Runs of one seed begin alike, so the verdict is on the mean change from seed
/// to seed. A mean within twice its error decides nothing.
pub(super) fn questions(keys: &Keys, rows: &[TrialRow]) -> Table {
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
    let verdict = |asked: &Question| match changes(asked) {
        None => "no number: runs diverged",
        Some(changes) => match mean(&changes) {
            None => "undecided: one seed's change has no error",
            Some([change, error]) if change.abs() <= 2.0 * error => {
                "undecided: within twice its error"
            }
            Some([change, _]) if change < 0.0 => "less",
            Some(_) => "more",
        },
    };
    Table::of("", "", &keys.questions)
        .column("question", "", |asked| &asked.ask[..])
        .columns(["from", "to"], "", |asked, k| medians(asked)[k])
        .column("to / from", "", |asked| {
            let [from, to] = medians(asked);
            ratio(to, from)
        })
        .columns(["change", "±"], "", |asked, k| {
            Some(mean(&changes(asked)?)?[k])
        })
        .column("verdict", "", verdict)
        .column("the paper", "", |asked| &asked.paper[..])
        .decimals(2, NONE)
        .done()
}

/// A row for each run, with every number. Numbers that a run lacks are left empty.
pub(super) fn runs(rows: &[TrialRow]) -> Table {
    let runs = rows
        .iter()
        .flat_map(|row| row.runs.iter().map(|run| (&row.trial, run)));
    let runs: Vec<_> = runs.collect();
    let names = runs
        .iter()
        .take(1)
        .flat_map(|(_, run)| run.numbers.iter().map(|(name, _)| name));
    let names: Vec<_> = names.collect();
    Table::of("", "", &runs)
        .column("table", "", |(trial, _)| &trial.table[..])
        .column("trial", "", |(trial, _)| &trial.name[..])
        .column("seed", "", |(_, run)| Cell::Count(run.seed))
        .columns(&names, "", |(_, run), k| run.number(names[k]))
        .done()
}
