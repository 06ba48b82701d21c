//! The paper's designs and environments beside the paper's numbers.

use super::Study;
use super::document::{document, motifs, percent, pictures, table, trial_table};
use super::results::StudyResults;
use super::rows::TrialRow;
use super::trials::{DEFAULT, STRICT};
use crate::report::PICTURES;
use cosmic::record::summary::ratio;

/// The paper's displacement of design b over that of its baseline.
const PAPER_GAIN: f64 = 1.66;

/// The whole document.
pub(super) fn document_of(study: &Study, results: &StudyResults) -> String {
    let default = results.table(DEFAULT);
    let own = match &study.base.file[..] {
        "" => "",
        _ => " but those named below",
    };
    let by_default = beside_the_paper(&default) + "\n![every seed](paper/default.svg)\n";
    let strictly = format!(
        "The paper's algorithm with no departure{own}: no bound on the cotangent, every design \
         gradient by itself, no alternatives at the snap, no single edges tried after it, no \
         settling, the loss at the end point only, the last iterate delivered, the tall layout in \
         both the baseline and the three-legged start. Reported as it comes.\n\n{}\n\
         ![every seed](paper/strict.svg)\n",
        beside_the_paper(&results.table(STRICT))
    );
    let names = PICTURES.map(|(name, _)| name);
    document(
        study,
        "The paper's results again",
        "",
        &[
            ["By default", &by_default],
            ["Strictly by the paper", &strictly],
            ["Against the baselines", &against_baselines(results)],
            ["Up the incline", &incline(results)],
            ["Motifs", &motifs(results, DEFAULT)],
            [
                "The best seed of each, by default",
                &pictures(study, &default, &names),
            ],
        ],
    )
}

/// A table with the paper's numbers beside every row.
fn beside_the_paper(rows: &[&TrialRow]) -> String {
    trial_table(rows, |table| {
        table
            .column("scene", "", |row| row.trial.title)
            .column("paper", "", |row| row.trial.paper)
            .column("median / paper", "", |row| row.ratio)
    })
}

/// Design b over both baselines, of both tables.
fn against_baselines(results: &StudyResults) -> String {
    let row = |name: &str| {
        let median = |scene: &str| results.row(&format!("{name}-{scene}")).displacement.median;
        let over = |baseline: &str| percent(ratio(median("stability"), median(baseline))).into();
        let (tall, short) = (over("baseline_tall"), over("baseline_short"));
        vec![name.into(), tall, short, percent(Some(PAPER_GAIN)).into()]
    };
    let names = ["b over", "tall baseline", "short baseline", "the paper's"];
    let rows = [DEFAULT, STRICT].map(row);
    format!("Medians over the seeds.\n\n{}", table(&names, rows))
}

/// Displacements across and up in one unperturbed rollout of each design.
fn incline(results: &StudyResults) -> String {
    let of = |name| results.row(&format!("{name}-incline")).world;
    let paper = [Some(1.36), Some(0.35)];
    let rows = [
        (DEFAULT, of(DEFAULT)),
        (STRICT, of(STRICT)),
        ("the paper's", paper),
    ];
    let rows = rows.map(|(name, [across, up])| vec![name.into(), across.into(), up.into()]);
    format!(
        "Medians over the seeds of one unperturbed rollout.\n\n{}",
        table(&["", "across", "up"], rows)
    )
}
