//! Designs in another simulator: how much of their distance they keep in MuJoCo.

use super::Study;
use super::document::{NONE, document, metres, trial_table};
use super::in_mujoco::OnFriction;
use super::results::StudyResults;
use super::rows::{RunRow, TrialRow};
use super::statistics::Statistics;
use crate::export::mujoco::MujocoSettings;
use crate::report::Bar;
use crate::table::{Table, decimals};
use std::collections::BTreeSet;

/// The whole document.
pub(super) fn document_of(study: &Study, results: &StudyResults) -> String {
    let table = format!(
        "{}\n![every seed](transfer/frictions.svg)\n",
        table(&results.rows)
    );
    let rows: Vec<&TrialRow> = results.rows.iter().collect();
    let designs = trial_table(&rows, |table| {
        table.column("scene", "", |row| row.trial.title)
    });
    let setting = setting(results);
    document(
        study,
        "Designs in another simulator",
        ABOUT,
        &[
            ["What designs keep in MuJoCo", &table],
            ["Designs", &designs],
            ["Settings", &setting],
        ],
    )
}

const ABOUT: &str = "\nEvery delivered design is exported to MuJoCo (`cosmic export RUN --mujoco`) and walks there on \
    grounds of several frictions, from as many perturbed starts; its number there is the median of these \
    walks. *Keeps* is that over *designed*, the displacement that it was delivered with in the scene's own \
    world; *at least 0.9* counts the seeds that keep as much; both leave out unreliable robots. \
    *Coulomb here* is the \
    same design with our own law of Coulomb friction at that friction, and *agrees* is MuJoCo over that: the difference of the simulators \
    alone. Each is the median over the seeds, in brackets the 10 % and the 90 % quantile. Flight is the same in \
    both to the rounding of numbers; contact is soft and frictional in MuJoCo, and by the time of impact here. \
    MuJoCo has no infinite friction: 5 stands for it.\n";

fn table(rows: &[TrialRow]) -> String {
    let pairs = rows
        .iter()
        .flat_map(|row| row.on_frictions.iter().map(move |on| (row, on)));
    let pairs: Vec<(&TrialRow, &OnFriction)> = pairs.collect();
    Table::of("", "", &pairs)
        .column("scene", "", |(row, _)| row.trial.title)
        .column("designed", "", |(row, _)| spread(&row.displacement))
        .column("friction", "", |(_, on)| decimals(on.friction, 1))
        .column("MuJoCo", "", |(_, on)| spread(&on.there))
        .column("**keeps**", "", |(_, on)| {
            format!("**{}**", spread(&on.keeps))
        })
        .column("at least 0.9", "", |(row, on)| {
            format!("{} of {}", on.kept, row.runs.len())
        })
        .column("Coulomb here", "", |(_, on)| spread(&on.own))
        .column("agrees", "", |(_, on)| spread(&on.agrees))
        .decimals(2, NONE)
        .done()
        .to_markdown()
}

/// A median with its quantiles.
fn spread(of: &Statistics) -> String {
    let [median, p10, p90] = [of.median, of.p10, of.p90].map(metres);
    format!("{median} [{p10}, {p90}]")
}

/// What the numbers in MuJoCo were made with.
fn setting(results: &StudyResults) -> String {
    let runs = results.rows.iter().flat_map(|row| &row.runs);
    let versions: BTreeSet<&str> = runs
        .filter_map(|run| Some(&run.transfer.as_ref()?.mujoco[..]))
        .collect();
    let versions: Vec<&str> = versions.into_iter().collect();
    let MujocoSettings {
        substeps,
        contact_time,
        impedance_ratio,
        ..
    } = MujocoSettings::default();
    format!(
        "MuJoCo {}: semi-implicit Euler, {substeps} mechanical steps for each of the controller, elliptic \
         cones, `impratio` {impedance_ratio}, `solref` {contact_time} 1, spheres of 2 mm at the nodes. \
         `docs/files.md` says how little the distance hangs on these.\n",
        versions.join(" and ")
    )
}

/// Bars of each scene: as designed, and in MuJoCo on each friction with our own law as the stroke.
pub(super) fn bars(results: &StudyResults) -> Vec<Bar> {
    let of = |row: &TrialRow| {
        let title = row.trial.title;
        let designed = Bar {
            name: format!("{title}, as designed"),
            value: row.displacement.median,
            points: row.runs.iter().filter_map(RunRow::displacement).collect(),
            mark: None,
        };
        let on = |(k, on): (usize, &OnFriction)| Bar {
            name: format!("{title}, friction {}", on.friction),
            value: on.there.median,
            points: row
                .runs
                .iter()
                .filter_map(|run| run.transfer.as_ref()?.there(k))
                .collect(),
            mark: on.own.median,
        };
        let on: Vec<Bar> = row.on_frictions.iter().enumerate().map(on).collect();
        [vec![designed], on].concat()
    };
    results.rows.iter().flat_map(of).collect()
}
