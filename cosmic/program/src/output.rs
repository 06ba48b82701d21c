//! Standard output and standard error.

use cosmic::error::{Error, Result, in_shell};
use std::io::{self, Write};
use std::path::Path;

/// Reports on faults of a file begin with "error:" on their own.
pub(super) fn complain(error: &Error) {
    let text = error.to_string();
    let prefix = if text.starts_with("error:") {
        ""
    } else {
        "error: "
    };
    let _ = writeln!(io::stderr(), "{prefix}{text}");
}

/// Writes to standard output.
pub(super) fn print(text: &str) -> Result<()> {
    let mut out = io::stdout().lock();
    written(out.write_all(text.as_bytes()).and_then(|()| out.flush()))
}

/// What became of a text for standard output. A reader that has seen enough (`cosmic scene default
/// | head`) is no error.
pub(super) fn written(text: io::Result<()>) -> Result<()> {
    match text {
        Err(source) if source.kind() != io::ErrorKind::BrokenPipe => Err(Error::Write {
            path: "standard output".into(),
            source,
        }),
        _ => Ok(()),
    }
}

/// A line on standard error.
pub(super) fn note(text: &str) {
    // Nobody is left to tell if the terminal is gone.
    let _ = writeln!(io::stderr(), "{text}");
}

/// A count of things whose plural ends in s.
pub(super) fn counted(count: usize, thing: &str) -> String {
    match count {
        1 => format!("1 {thing}"),
        _ => format!("{count} {thing}s"),
    }
}

/// Where the last states of a rollout that diverged are kept, and what to do with them.
pub(super) fn see_again(diverged: &Path) -> String {
    let (file, word) = (diverged.display(), in_shell(diverged));
    format!("the last states are in {file}; see it again with: cosmic evaluate {word}")
}

/// Paths as JSON has them: what is no Unicode in one is replaced, as on a line of text.
pub(super) fn in_json<P: AsRef<Path>>(paths: &[P]) -> Vec<String> {
    let shown = |path: &P| path.as_ref().display().to_string();
    paths.iter().map(shown).collect()
}

/// Writes a value to standard output as indented JSON.
pub(super) fn print_json(value: &impl serde::Serialize) -> Result<()> {
    let source = |error: serde_json::Error| Error::Write {
        path: "standard output".into(),
        source: error.into(),
    };
    let text = serde_json::to_string_pretty(value).map_err(source)?;
    print(&(text + "\n"))
}
