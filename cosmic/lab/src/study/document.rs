//! Parts of the documents: numbers, tables, the text that all studies share.

use super::Study;
use super::results::StudyResults;
use super::rows::{RunRow, TrialRow};
use crate::table::{Cell, Column, Table, TableOf, decimals};
use cosmic::scene::Departure;

/// The sign for a missing number.
pub(super) const NONE: &str = "–";

/// A number to two decimals.
pub(super) fn metres(x: Option<f64>) -> String {
    x.map_or(NONE.to_owned(), |x| decimals(x, 2))
}

/// A ratio as a change in percent.
pub(super) fn percent(ratio: Option<f64>) -> String {
    let change = ratio.filter(|ratio| ratio.is_finite());
    change.map_or(NONE.to_owned(), |ratio| {
        let sign = if ratio >= 1.0 { "+" } else { "" };
        format!("{sign}{} %", decimals(100.0 * (ratio - 1.0), 0))
    })
}

/// A column of words, or of numbers to this many decimals.
fn column(name: &str, decimals: usize) -> Column {
    Column::new(name, "").decimals(decimals, NONE)
}

/// Rows of cells under columns of two decimals.
pub(super) fn table(names: &[&str], rows: impl IntoIterator<Item = Vec<Cell>>) -> String {
    let columns = names.iter().map(|name| column(name, 2));
    Table::new(columns.collect(), rows).to_markdown()
}

/// A whole document: the meaning of the numbers, the text of the study, sections under their headings,
/// and the command that made it.
pub(super) fn document(study: &Study, title: &str, about: &str, sections: &[[&str; 2]]) -> String {
    let mut text = format!("# {title}\n\n{}{about}", preamble(study));
    for [heading, body] in sections {
        text += &format!("\n## {heading}\n\n{body}");
    }
    text + "\n" + &made_by(study)
}

/// The meaning of the numbers.
fn preamble(study: &Study) -> String {
    let (seeds, first) = (study.seeds.get() as u64, study.first_seed);
    let last = first + (seeds - 1);
    let whose = match seeds {
        1 => format!("seed {first}"),
        _ => format!("{seeds} seeds, {first} to {last}"),
    };
    let limit = study.iterations.map_or(String::new(), |n| {
        format!(" **Every run was stopped after {n} iterations: a study in little.**")
    });
    let (moved, base) = match &study.base.file[..] {
        "" => ("1e-9 m", String::new()),
        file => (
            "`selection.perturbation`",
            format!(" Every experiment starts from the settings of `{file}`."),
        ),
    };
    format!(
        "Displacements of the payload along the ground, in metres, over {whose}.{limit}{base} The number \
         of a seed is of its delivered design: the median of full rollouts in double precision from \
         8 or more starts moved by {moved}, other starts than those by which the design was chosen. \
         *Spread* is from the 10 % to the 90 % quantile of these rollouts, *dt/2* the same design at half \
         the time step, *last* the last iterate, *clock alone* the share of the displacement that is left \
         without feedback, *peak strain* that of the actuators, each as its median over the seeds. ± is the \
         standard error of the median over the seeds, by the bootstrap. A run that diverges counts below all \
         others.\n"
    )
}

/// A table of trials: the study's own columns, those that all studies share, and letters for departures
/// from the paper, with a legend below.
pub(super) fn trial_table<'r>(
    rows: &'r [&'r TrialRow],
    special: impl Fn(TableOf<'r, &'r TrialRow>) -> TableOf<'r, &'r TrialRow>,
) -> String {
    let known = departures(rows);
    let table = special(Table::of("", "", rows))
        .column("best [spread]", "", |row| {
            let spread = metres(row.best().and_then(RunRow::spread));
            format!("{} [{spread}]", metres(row.displacement.best))
        })
        .column("p10", "", |row| row.displacement.p10)
        .column("median ±", "", |row| {
            let error = row.displacement.standard_error;
            let error = error.map_or(String::new(), |error| format!(" ± {}", decimals(error, 2)));
            format!("**{}**{error}", metres(row.displacement.median))
        })
        .column("p90", "", |row| row.displacement.p90)
        .column("spread", "", |row| row.spread)
        .column("dt/2", "", |row| row.half_step)
        .column("last", "", |row| row.last)
        .column("clock alone", "", |row| row.clock_alone.median)
        .column("peak strain, largest", "", |row| {
            let [median, largest] = [row.strain_peak.median, row.strain_peak.best].map(metres);
            format!("{median}, {largest}")
        })
        .decimals(2, NONE)
        .add(column("V", 3), |row| row.volumes[0])
        .add(column("V_act", 3), |row| row.volumes[1])
        .column("one-hot, in bounds, in one piece", "", |row| {
            let (one_hot, within, runs) = (row.one_hot, row.within_bounds, row.runs.len());
            let whole = row.one_piece;
            let diverged = match row.runs.iter().filter(|run| run.diverged).count() {
                0 => String::new(),
                n => format!(", {n} diverged"),
            };
            format!("{one_hot}, {within}, {whole} of {runs}{diverged}")
        })
        .column("gradients skipped", "", |row| row.skipped_gradients)
        .add(column("s", 1), |row| row.seconds)
        .column("departures", "", |row| letters(&known, row))
        .done();
    format!("{}\n{}", table.to_markdown(), legend(&known))
}

/// The departures of some trials from the paper, each once.
fn departures<'r>(rows: &[&'r TrialRow]) -> Vec<&'r Departure> {
    let mut known: Vec<&Departure> = Vec::new();
    for departure in rows.iter().flat_map(|row| &row.departures) {
        if !known.contains(&departure) {
            known.push(departure);
        }
    }
    known
}

/// The letters of a trial's departures from the paper.
fn letters(known: &[&Departure], row: &TrialRow) -> String {
    let is_in = |known: &Departure| row.departures.iter().any(|d| d.option == known.option);
    let letters = ('A'..).zip(known).filter(|(_, departure)| is_in(departure));
    let letters: String = letters.map(|(letter, _)| letter).collect();
    if letters.is_empty() {
        "none".to_owned()
    } else {
        letters
    }
}

/// The legend of the letters.
fn legend(known: &[&Departure]) -> String {
    if known.is_empty() {
        return "Departures from the paper: none.\n".to_owned();
    }
    let line =
        |(letter, d): (char, &&Departure)| format!("- {letter}: `{}`, {}\n", d.option, d.says);
    let lines: String = ('A'..).zip(known).map(line).collect();
    format!("Departures from the paper, each a named option:\n\n{lines}")
}

/// The margin by which the share of a motif must exceed chance to count as recurring.
const WELL_ABOVE: f64 = 0.1;

/// The motifs of a table's trials beside those of shuffled layouts.
pub(super) fn motifs(results: &StudyResults, of: &str) -> String {
    let trials = results.rows.iter().enumerate();
    let trials: Vec<_> = trials.filter(|(_, row)| row.trial.table == of).collect();
    let mut names = vec!["motif, in brackets by chance"];
    names.extend(trials.iter().map(|(_, row)| &row.trial.name[..]));
    names.push("trials well above chance");
    let rows = results.motifs.iter().map(|motif| {
        let found: Vec<[f64; 2]> = trials.iter().map(|(k, _)| motif.found[*k]).collect();
        let cell = |of: &[f64; 2]| {
            let [found, chance] = of.map(|x| decimals(x, 2));
            format!("{found} ({chance})").into()
        };
        let above = |of: &&[f64; 2]| of[0] - of[1] > WELL_ABOVE;
        let above = found.iter().filter(above).count();
        let mut cells = vec![motif.says[..].into()];
        cells.extend(found.iter().map(cell));
        cells.push(format!("{above} of {}", found.len()).into());
        cells
    });
    format!(
        "Mean over the designs of all seeds; by chance is the mean over 50 shuffles of each design's \
         materials; well above it is by more than {WELL_ABOVE}.\n\n{}",
        table(&names, rows)
    )
}

/// The pictures of the best seeds of some trials.
pub(super) fn pictures(study: &Study, rows: &[&TrialRow], names: &[&str]) -> String {
    let folder = study.kind.name();
    let of = |row: &&TrialRow| {
        let Some(best) = row.best() else {
            return format!("{}: no run without divergence.\n\n", row.trial.title);
        };
        let picture = |name: &&str| format!("![{name}]({folder}/{}-{name}.svg)\n", row.trial.name);
        let pictures: String = names.iter().map(picture).collect();
        format!(
            "### {}, seed {}\n\n{pictures}\n",
            row.trial.title, best.seed
        )
    };
    rows.iter().map(of).collect()
}

/// The end of every document: the command that made it.
fn made_by(study: &Study) -> String {
    let name = study.kind.name();
    format!(
        "## How these results were made\n\nWritten by the command\n\n```sh\n{}\n```\n\nand not by \
         hand; interrupted, the same command goes on. Every run's numbers are in \
         [{name}.csv]({name}.csv) and [{name}.json]({name}.json). Every seed's run ends with the same \
         bytes on the same machine and build, for any number of threads; gaits are chaotic, and \
         another machine may find others. Seconds are wall time, one thread a run.\n",
        study.command()
    )
}

#[cfg(test)]
mod tests {
    use super::{metres, percent};
    use cosmic::record::summary::ratio;

    #[test]
    fn numbers_that_are_not_there_show() {
        assert_eq!(metres(None), "–");
        assert_eq!(percent(Some(1.66)), "+66 %");
        assert_eq!(percent(ratio(Some(1.0), Some(4.0))), "\u{2212}75 %");
        assert_eq!(ratio(Some(1.0), Some(1e-9)), None);
    }
}
