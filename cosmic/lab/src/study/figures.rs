//! The figures of a study, in a folder beside its document.

use super::results::StudyResults;
use super::rows::{RunRow, TrialRow};
use super::trials::{DEFAULT, STRICT};
use super::{Study, StudyKind};
use super::{ablation, transfer};
use crate::files::write_texts;
use crate::report::{Bar, PICTURES, Picture, RunFiles, bars};
use cosmic::error::Result;
use cosmic::record::files::make_folder;
use std::path::PathBuf;

/// The unit of all bars.
const UNIT: &str =
    "displacement along the ground, m (bar: median; dots: seeds; stroke: the paper's)";

/// The unit of bars of walks in MuJoCo.
const UNIT_THERE: &str =
    "displacement along the ground, m (bar: median; dots: seeds; stroke: Coulomb here)";

/// Draws a study's figures and returns the paths of their files.
///
/// # Errors
/// The errors of reading the runs that are drawn; [`Error::Write`](cosmic::Error::Write).
pub(super) fn write(study: &Study, results: &StudyResults) -> Result<Vec<PathBuf>> {
    let folder = study.out.join(study.kind.name());
    make_folder(&folder)?;
    let named = |(name, text)| (format!("{name}.svg"), text);
    let charts = charts(study.kind, results).into_iter();
    let mut drawn: Vec<_> = charts.map(named).collect();
    for row in &results.rows {
        let pictures = pictures(study.kind, row);
        let Some(best) = row.best().filter(|_| !pictures.is_empty()) else {
            continue;
        };
        let run = RunFiles::read(&best.folder)?;
        for (name, draw) in pictures {
            drawn.push((format!("{}-{name}.svg", row.trial.name), draw(&run)));
        }
    }
    write_texts(&folder, drawn)
}

/// The pictures of a trial's best run that the study shows.
fn pictures(kind: StudyKind, row: &TrialRow) -> &'static [Picture] {
    match kind {
        StudyKind::Paper if row.trial.table == DEFAULT => &PICTURES,
        StudyKind::Ablation => &PICTURES[..1],
        StudyKind::Paper | StudyKind::Findings | StudyKind::Transfer => &[],
    }
}

/// The charts of all trials by the names of their files.
fn charts(kind: StudyKind, results: &StudyResults) -> Vec<(&'static str, String)> {
    let of = |table: &str, title: &str| {
        let rows = results.table(table);
        bars(title, UNIT, &rows.into_iter().map(bar).collect::<Vec<_>>())
    };
    let title = "Every seed of every trial";
    match kind {
        StudyKind::Paper => vec![
            ("default", of(DEFAULT, "Every seed by default")),
            ("strict", of(STRICT, "Every seed strictly by the paper")),
        ],
        StudyKind::Findings => vec![("trials", of("findings", title))],
        StudyKind::Transfer => {
            let all = transfer::bars(results);
            vec![("frictions", bars("Every seed in MuJoCo", UNIT_THERE, &all))]
        }
        StudyKind::Ablation => {
            let title_of_means = "Means of the medians of four trials each";
            let means = bars(title_of_means, "m", &ablation::bars(results));
            vec![("trials", of("ablation", title)), ("entities", means)]
        }
    }
}

fn bar(row: &TrialRow) -> Bar {
    Bar {
        name: row.trial.title.to_owned(),
        value: row.displacement.median,
        points: row.runs.iter().filter_map(RunRow::displacement).collect(),
        mark: row.trial.paper,
    }
}
