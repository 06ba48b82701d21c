//! Pieces of the documents: numbers, tables, what all studies say.

use super::Study;
use super::files::Results;
use super::rows::Row;
use crate::table::{Column, Table, decimals};

/// What a table shows where there is no number.
const NONE: &str = "–";

/// A number to two decimals, with a minus that is one.
pub(super) fn metres(x: Option<f64>) -> String {
    x.map_or(NONE.to_owned(), |x| decimals(x, 2))
}

/// A share as a percentage of change: what `ratio` is more or less than one.
pub(super) fn percent(ratio: Option<f64>) -> String {
    let change = ratio.filter(|ratio| ratio.is_finite());
    change.map_or(NONE.to_owned(), |ratio| {
        let sign = if ratio >= 1.0 { "+" } else { "" };
        format!("{sign}{} %", decimals(100.0 * (ratio - 1.0), 0))
    })
}

/// The quotient of two displacements there are. None over less than a centimetre: a robot that
/// hardly moves is no measure.
pub(super) fn ratio(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    let b = b.filter(|b| *b >= 0.01);
    Option::zip(a, b).map(|(a, b)| a / b)
}

/// A table of Markdown, of cells as they are read.
pub(super) fn table(head: &[&str], rows: &[Vec<String>]) -> String {
    let columns = head.iter().map(|name| Column::new(name, ""));
    let cells = |row: &Vec<String>| row.iter().map(|cell| cell[..].into()).collect();
    Table::new(columns.collect(), rows.iter().map(cells)).to_markdown()
}

/// What every number is.
pub(super) fn preamble(study: &Study) -> String {
    let (seeds, first) = (study.seeds.get() as u64, study.first_seed);
    let last = first + seeds - 1;
    let whose = match seeds {
        1 => format!("seed {first}"),
        _ => format!("{seeds} seeds, {first} to {last}"),
    };
    let limit = study.iterations.map_or(String::new(), |n| {
        format!(" **Every run was stopped after {n} iterations: a study in little.**")
    });
    let (moved, base) = match &study.base {
        None => ("1e-9 m".to_owned(), String::new()),
        Some((file, _)) => (
            "`selection.perturbation`".to_owned(),
            format!(" Every experiment starts from the settings of `{file}`."),
        ),
    };
    format!(
        "Displacements of the payload along the ground, in metres, over {whose}.{limit}{base} The number \
         of a seed is of its delivered design: the median of full rollouts in double precision from \
         8 or more starts moved by {moved}, other starts than those by which the design was chosen. \
         *Quantiles* is from the 10 % to the 90 % quantile of these rollouts, *dt/2* the same design at \
         half the time step, *last* the last iterate, each as its median over the seeds. ± is the \
         standard error of the median over the seeds, by the bootstrap. A run that diverges counts \
         below all others.\n"
    )
}

/// The columns of [`cells`].
pub(super) const COLUMNS: [&str; 12] = [
    "best [spread]",
    "p10",
    "median ±",
    "p90",
    "spread",
    "dt/2",
    "last",
    "V",
    "V_act",
    "one-hot, in bounds",
    "gradients skipped",
    "s",
];

/// What is told of every trial.
pub(super) fn cells(row: &Row) -> Vec<String> {
    let share = |x: Option<f64>| x.map_or(NONE.to_owned(), |x| decimals(x, 3));
    let best_spread = row.best().and_then(|run| run.spread());
    let median = metres(row.displacement.median);
    let error = row.displacement.standard_error;
    let runs = row.runs.len();
    let diverged = match row.runs.iter().filter(|run| run.diverged).count() {
        0 => String::new(),
        n => format!(", {n} diverged"),
    };
    vec![
        format!(
            "{} [{}]",
            metres(row.displacement.best),
            metres(best_spread)
        ),
        metres(row.displacement.p10),
        match error {
            Some(error) => format!("**{median}** ± {}", decimals(error, 2)),
            None => format!("**{median}**"),
        },
        metres(row.displacement.p90),
        metres(row.spread),
        metres(row.half_step),
        metres(row.last),
        share(row.volumes[0]),
        share(row.volumes[1]),
        format!("{}, {} of {runs}{diverged}", row.one_hot, row.within_bounds),
        row.skipped_gradients.to_string(),
        row.seconds.map_or(NONE.to_owned(), |s| decimals(s, 1)),
    ]
}

/// The departures in force in some rows: a letter each, and what they are.
pub(super) struct Departures {
    known: Vec<(String, String)>,
}

impl Departures {
    pub(super) fn of(rows: &[&Row]) -> Self {
        let mut known: Vec<(String, String)> = Vec::new();
        for departure in rows.iter().flat_map(|row| &row.departures) {
            let entry = (departure.option.clone(), departure.says.clone());
            if !known.contains(&entry) {
                known.push(entry);
            }
        }
        Self { known }
    }

    /// The letters of a row's departures.
    pub(super) fn letters(&self, row: &Row) -> String {
        let is_in = |option: &str| row.departures.iter().any(|d| d.option == option);
        let letters = (b'A'..).zip(&self.known);
        let letters: String = letters
            .filter(|(_, (option, _))| is_in(option))
            .map(|(letter, _)| char::from(letter))
            .collect();
        match letters.is_empty() {
            true => "none".to_owned(),
            false => letters,
        }
    }

    /// What the letters stand for.
    pub(super) fn legend(&self) -> String {
        if self.known.is_empty() {
            return "Departures from the paper: none.\n".to_owned();
        }
        let line = |(letter, (option, says)): (u8, &(String, String))| {
            format!("- {}: `{option}`, {says}\n", char::from(letter))
        };
        let lines: String = (b'A'..).zip(&self.known).map(line).collect();
        format!("Departures from the paper, each a named option:\n\n{lines}")
    }
}

/// By how much a motif's share exceeds that by chance where it recurs for a reason.
const WELL_ABOVE: f64 = 0.1;

/// The motifs of some trials: each against the chance of shuffled layouts.
pub(super) fn motifs(results: &Results, names: &[&str]) -> String {
    let mut head = vec!["motif, in brackets by chance"];
    head.extend(names);
    head.push("trials well above chance");
    let column = |name: &&str| results.rows.iter().position(|row| row.name == *name);
    let columns: Vec<usize> = names.iter().filter_map(column).collect();
    let row = |motif: &super::MotifRow| {
        let cell = |k: &usize| {
            let [found, chance] = motif.found[*k];
            format!("{} ({})", decimals(found, 2), decimals(chance, 2))
        };
        let mut row = vec![motif.says.clone()];
        row.extend(columns.iter().map(cell));
        let is_above = |k: &&usize| motif.found[**k][0] - motif.found[**k][1] > WELL_ABOVE;
        let above = columns.iter().filter(is_above).count();
        row.push(format!("{above} of {}", columns.len()));
        row
    };
    let rows: Vec<Vec<String>> = results.motifs.iter().map(row).collect();
    format!(
        "Mean over the designs of all seeds; by chance is the mean over 50 shuffles of each design's \
         materials; well above it is by more than {WELL_ABOVE}.\n\n{}",
        table(&head, &rows)
    )
}

/// The pictures of a trial's best seed.
pub(super) fn pictures(study: &Study, row: &Row, names: &[&str]) -> String {
    let Some(best) = row.best() else {
        return format!("{}: no run without divergence.\n\n", row.title);
    };
    let folder = study.kind.name();
    let picture = |name: &&str| format!("![{name}]({folder}/{}-{name}.svg)\n", row.name);
    let pictures: String = names.iter().map(picture).collect();
    format!("### {}, seed {}\n\n{pictures}\n", row.title, best.seed)
}

/// The end of every document.
pub(super) fn made_by(study: &Study) -> String {
    let name = study.kind.name();
    format!(
        "## How these results were made\n\nWritten by the command\n\n```sh\n{}\n```\n\nand not by \
         hand; interrupted, the same command goes on. Every run's numbers are in \
         [{name}.csv]({name}.csv) and [{name}.json]({name}.json). Every seed's run ends with the same \
         bytes on the same machine and build, for any number of threads; gaits are chaotic, and \
         another machine may find others. Seconds are wall time, one thread a run.\n",
        study.commands()
    )
}

#[cfg(test)]
mod tests {
    use super::{metres, percent, ratio};

    #[test]
    fn numbers_that_are_not_there_show() {
        assert_eq!(metres(None), "–");
        assert_eq!(percent(Some(1.66)), "+66 %");
        assert_eq!(percent(ratio(Some(1.0), Some(4.0))), "\u{2212}75 %");
        assert_eq!(ratio(Some(1.0), Some(1e-9)), None);
    }
}
