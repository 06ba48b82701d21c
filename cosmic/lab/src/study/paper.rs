//! The paper's designs and environments beside the paper's numbers.

use super::Study;
use super::files::Results;
use super::markdown::{
    COLUMNS, Departures, cells, made_by, metres, motifs, percent, pictures, preamble, ratio, table,
};
use super::rows::Row;
use super::trials::{DEFAULT, STRICT};
use crate::report::Picture;
use crate::table::decimals;

/// By how much the paper's design b outdoes its baseline.
const PAPER_GAIN: f64 = 1.66;

/// The whole document.
pub(super) fn document(study: &Study, results: &Results) -> String {
    let default = results.table(DEFAULT);
    let names: Vec<&str> = default.iter().map(|row| &row.name[..]).collect();
    let figures: String = default
        .iter()
        .map(|row| pictures(study, row, &Picture::ALL.map(Picture::name)))
        .collect();
    [
        "# The paper's results again\n".to_owned(),
        preamble(study),
        format!(
            "## By default\n\n{}\n![every seed](paper/default.svg)\n",
            beside_the_paper(&default)
        ),
        format!(
            "## Strictly by the paper\n\nThe paper's algorithm with no departure{}: no bound on the \
             cotangent, every design gradient by itself, no alternatives at the snap, no single \
             edges tried after it, no settling, the loss at the end point only, the last iterate \
             delivered, the tall layout in both the baseline and the three-legged start. Reported \
             as it comes.\n\n{}\n![every seed](paper/strict.svg)\n",
            study
                .base
                .as_ref()
                .map_or("", |_| " but those named below"),
            beside_the_paper(&results.table(STRICT))
        ),
        format!("## Against the baselines\n\n{}", against_baselines(results)),
        format!("## Up the incline\n\n{}", incline(results)),
        format!("## Motifs\n\n{}", motifs(results, &names)),
        format!("## The best seed of each, by default\n\n{figures}"),
        made_by(study),
    ]
    .join("\n")
}

/// A table with the paper's numbers and the departures beside every row.
fn beside_the_paper(rows: &[&Row]) -> String {
    let departures = Departures::of(rows);
    let mut head = vec!["scene", "paper", "median / paper"];
    head.extend(COLUMNS);
    head.push("departures");
    let line = |row: &&Row| {
        let ratio = row.ratio.map_or(metres(None), |x| decimals(x, 2));
        let mut line = vec![row.title.clone(), metres(row.paper), ratio];
        line.extend(cells(row));
        line.push(departures.letters(row));
        line
    };
    let lines: Vec<Vec<String>> = rows.iter().map(line).collect();
    format!("{}\n{}", table(&head, &lines), departures.legend())
}

/// Design b over both baselines, of both tables.
fn against_baselines(results: &Results) -> String {
    let line = |name: &str| {
        let median = |scene: &str| results.row(&format!("{name}-{scene}")).displacement.median;
        let own = median("stability");
        let over = |baseline: &str| percent(ratio(own, median(baseline)));
        let (tall, short) = (over("baseline_tall"), over("baseline_short"));
        vec![name.to_owned(), tall, short, percent(Some(PAPER_GAIN))]
    };
    let head = ["b over", "tall baseline", "short baseline", "the paper's"];
    format!(
        "Medians over the seeds.\n\n{}",
        table(&head, &[line(DEFAULT), line(STRICT)])
    )
}

/// Across and up, of one unperturbed rollout of each design.
fn incline(results: &Results) -> String {
    let line = |name: &str| {
        let row = results.row(&format!("{name}-incline"));
        let [across, up] = row.world.map(metres);
        vec![name.to_owned(), across, up]
    };
    let paper = vec![
        "the paper's".to_owned(),
        "1.36".to_owned(),
        "0.35".to_owned(),
    ];
    let lines = [line(DEFAULT), line(STRICT), paper];
    format!(
        "Medians over the seeds of one unperturbed rollout.\n\n{}",
        table(&["", "across", "up"], &lines)
    )
}
