//! Standard output and standard error.

use crate::arguments::Output;
use cosmic::error::{Error, Result, command, in_shell};
use cosmic::judge::Reliability;
use cosmic::judge::verdict::{Item, Level};
use cosmic::numbers::fixed;
use std::io::{self, IsTerminal, Write};
use std::path::Path;

/// Prints an error to standard error, with "error: " before it. Some errors about files already begin with "error: ".
pub(super) fn complain(error: &Error) {
    note(&format!("error: {}", error.within()));
}

/// Writes to standard output.
pub(super) fn print(text: &str) -> Result<()> {
    let mut out = io::stdout().lock();
    written(out.write_all(text.as_bytes()).and_then(|()| out.flush()))
}

/// Checks the result of writing to standard output. If the reader has closed the pipe, as in `cosmic scene default |
/// head`, this is not an error.
pub(super) fn written(text: io::Result<()>) -> Result<()> {
    match text {
        Err(source) if source.kind() != io::ErrorKind::BrokenPipe => {
            Err(Error::writing("standard output")(source))
        }
        _ => Ok(()),
    }
}

/// Prints a line to standard error.
pub(super) fn note(text: &str) {
    // If the terminal is gone, nobody can read the line, so errors are ignored.
    let _ = writeln!(io::stderr(), "{text}");
}

/// Formats a displacement in metres; `None` becomes "diverged".
pub(super) fn metres(x: Option<f64>) -> String {
    x.map_or("diverged".to_owned(), |x| fixed(x, 3) + " m")
}

/// The remark that follows the displacement of an unreliable robot; empty for other robots.
pub(super) fn unreliable(verdict: Option<&Reliability>) -> &'static str {
    match verdict {
        Some(Reliability::Unreliable { .. }) => ", unreliable",
        Some(Reliability::Reliable) | None => "",
    }
}

/// What comes before the displacement of a robot that should walk far but stays in place; empty for other robots.
pub(super) fn in_place(verdict: Option<&Reliability>) -> &'static str {
    match verdict.is_some_and(Reliability::stays_in_place) {
        true => "stays in place: ",
        false => "",
    }
}

/// The displacement of a robot in a line about a run, and whether it can be trusted.
pub(super) fn reached(displacement: Option<f64>, verdict: Option<&Reliability>) -> String {
    let (before, after) = (in_place(verdict), unreliable(verdict));
    format!("{before}{}{after}", metres(displacement))
}

/// A message that names the file with the last states of a diverged rollout, and the command that replays them.
pub(super) fn see_again(diverged: &Path) -> String {
    let (file, word) = (diverged.display(), in_shell(diverged));
    let replay = command(format_args!("evaluate {word}"));
    format!("the last states are in {file}; replay them with: {replay}")
}

/// Converts an item of a verdict to text, in the colour of its level if standard output is a terminal.
pub(super) fn in_colour(item: &Item) -> String {
    let is_dumb = std::env::var_os("TERM").is_some_and(|term| term == "dumb");
    let is_plain = is_dumb || std::env::var_os("NO_COLOR").is_some();
    let has_colours = io::stdout().is_terminal() && !is_plain;
    let colour = match item.level {
        _ if !has_colours => return item.text.clone(),
        Level::Remark => return item.text.clone(),
        Level::Good => 32,
        Level::Doubtful => 33,
        Level::Bad => 31,
    };
    format!("\x1b[{colour}m{}\x1b[0m", item.text)
}

/// Converts paths to texts for JSON. Bytes that are not Unicode are replaced.
pub(super) fn in_json<P: AsRef<Path>>(paths: &[P]) -> Vec<String> {
    let shown = |path: &P| path.as_ref().display().to_string();
    paths.iter().map(shown).collect()
}

/// Writes a value to standard output as indented JSON.
pub(super) fn print_json(value: &impl serde::Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(value);
    let text = text.map_err(|error| Error::writing("standard output")(error.into()))?;
    print(&(text + "\n"))
}

/// Writes a result as JSON or as text.
pub(super) fn print_as(json: bool, value: &impl serde::Serialize, text: &str) -> Result<()> {
    if json { print_json(value) } else { print(text) }
}

/// Writes a result as JSON or as text. `--quiet` does not hide results.
pub(super) fn answer(output: &Output, value: &impl serde::Serialize, text: &str) -> Result<()> {
    print_as(output.json, value, text)
}

/// Prints the paths of the files that a command wrote, one per line or as JSON.
pub(super) fn answer_written<P: AsRef<Path>>(output: &Output, written: &[P]) -> Result<()> {
    let value = serde_json::json!({ "written": in_json(written) });
    answer(output, &value, &lines(written))
}

/// The paths as text, one per line.
pub(super) fn lines<P: AsRef<Path>>(paths: &[P]) -> String {
    let line = |path: &P| format!("{}\n", path.as_ref().display());
    paths.iter().map(line).collect()
}
