//! The figures of a study, in a folder beside its document.

use super::rows::{Collected, Row};
use super::trials::{DEFAULT, STRICT};
use super::{Kind, Study, ablation, files};
use crate::report::{Bar, Picture, Results, bars};
use cosmic::error::Result;
use cosmic::record::files::{make_folder, write_atomic};
use std::path::{Path, PathBuf};

/// The unit of all bars.
const UNIT: &str =
    "displacement along the ground, m (bar: median; dots: seeds; stroke: the paper's)";

/// Draws and writes a study's figures and says which files these are.
///
/// # Errors
/// Those of reading the runs that are drawn; [`Error::Write`].
pub(super) fn write(study: &Study, collected: &[Collected]) -> Result<Vec<PathBuf>> {
    let folder = study.out.join(study.kind.name());
    make_folder(&folder)?;
    let mut written = Vec::new();
    for (name, text) in charts(study, collected) {
        written.push(keep(&folder, name, &text)?);
    }
    for trial in collected {
        if let Some(best) = trial.best_folder() {
            let pictures = pictures(study.kind, &trial.row);
            if pictures.is_empty() {
                continue;
            }
            let run = Results::read(best)?;
            for picture in pictures {
                let name = format!("{}-{}.svg", trial.row.name, picture.name());
                written.push(keep(&folder, &name, &picture.draw(&run))?);
            }
        }
    }
    Ok(written)
}

fn keep(folder: &Path, name: &str, text: &str) -> Result<PathBuf> {
    let path = folder.join(name);
    write_atomic(&path, |file| file.write_all(text.as_bytes()))?;
    Ok(path)
}

/// Which pictures of a trial's best run are shown.
fn pictures(kind: Kind, row: &Row) -> &'static [Picture] {
    match kind {
        Kind::Paper if row.table == DEFAULT => &Picture::ALL,
        Kind::Ablation => &[Picture::Robot],
        Kind::Paper | Kind::Findings => &[],
    }
}

/// The charts of all trials.
fn charts(study: &Study, collected: &[Collected]) -> Vec<(&'static str, String)> {
    let of = |table: Option<&str>, title: &str| {
        let rows = collected.iter().map(|trial| &trial.row);
        let wanted = rows.filter(|row| table.is_none_or(|table| row.table == table));
        bars(title, UNIT, &wanted.map(bar).collect::<Vec<_>>())
    };
    match study.kind {
        Kind::Paper => vec![
            ("default.svg", of(Some(DEFAULT), "Every seed by default")),
            (
                "strict.svg",
                of(Some(STRICT), "Every seed strictly by the paper"),
            ),
        ],
        Kind::Findings => vec![("trials.svg", of(None, "Every seed of every trial"))],
        Kind::Ablation => {
            let rows: Vec<Row> = collected.iter().map(|trial| trial.row.clone()).collect();
            let results = files::Results::of_rows(study, rows);
            let mean = |(name, value)| Bar {
                name,
                value,
                points: Vec::new(),
                mark: None,
            };
            let means: Vec<Bar> = ablation::means(&results).into_iter().map(mean).collect();
            vec![
                ("trials.svg", of(None, "Every seed of every trial")),
                (
                    "entities.svg",
                    bars("Means of the medians of four trials each", "m", &means),
                ),
            ]
        }
    }
}

fn bar(row: &Row) -> Bar {
    Bar {
        name: row.title.clone(),
        value: row.displacement.median,
        points: row.sample(),
        mark: row.paper,
    }
}
