//! The errors of this crate, with their messages and exit codes.

use std::borrow::Cow;
use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::RwLock;

use crate::geometry::Vector;
use crate::numbers::rounded;

/// An error of the library or the program.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file whose content is wrong.
    #[error("{report}")]
    Malformed {
        /// The file's name as the user gave it.
        file: String,
        /// The line of the first problem, from 1.
        line: usize,
        /// The column of the first problem in characters, from 1.
        column: usize,
        /// A sentence about the first problem.
        message: String,
        /// The allowed values, or a hint for the first problem. May be empty.
        allowed: String,
        /// Every problem, with the source line and a caret under it.
        report: String,
    },
    /// Two things that must have the same size but do not, such as a design and its lattice.
    #[error("{file}: expected {expected} {what}, found {found}")]
    Misfit {
        /// The file's name as the user gave it.
        file: String,
        /// What was counted, as a plural noun such as "edges".
        what: String,
        /// The expected count.
        expected: usize,
        /// The count that was found.
        found: usize,
    },
    /// A request that cannot be carried out; the text says why.
    #[error("{0}")]
    Usage(String),
    /// A run whose loss is code of the program that began it. Only that program can continue the run.
    #[error(
        "{file}: the loss of this run is code of the program that began the run, and no file holds it; that \
         program {remedy}"
    )]
    OwnLoss {
        /// The run's folder or snapshot.
        file: String,
        /// What the user can do in that program. The text continues a sentence that begins with "that program".
        remedy: &'static str,
    },
    /// There is no built-in scene and no file of this name.
    #[error("no built-in scene and no file is named `{}`; {hint}", escaped(name))]
    NoScene {
        /// The name that was asked for.
        name: String,
        /// A similar name, or the known names.
        hint: String,
    },
    /// A file or folder that does not exist or cannot be read.
    #[error("cannot read {}: {source}", shown(path))]
    Read {
        /// The file or folder.
        path: PathBuf,
        /// The error of the operating system. For a missing file, its text may also give the reason and a remedy.
        source: io::Error,
    },
    /// A file or folder that cannot be written.
    #[error("cannot write {}: {source}{}", shown(path), make_room(source))]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The simulation diverged: a state is not finite, is beyond 1e6 m or 1e6 m/s, or has a node that is faster than
    /// the scene allows.
    #[error(
        "diverged in step {step}: node {node} at {} m, velocity {} m/s, {cause}",
        position.shown(),
        velocity.shown()
    )]
    Diverged {
        /// The step that computed the state, from 0.
        step: usize,
        /// The first node that is not finite, out of bounds or too fast.
        node: usize,
        /// The position of this node, in metres.
        position: Vector<f64>,
        /// The velocity of this node, in m/s.
        velocity: Vector<f64>,
        /// The cause of the divergence, or the bound that was exceeded, as text.
        cause: String,
    },
    /// The time step is so long that the vibrations of the robot grow.
    #[error(
        "the time step of {} s is unstable: the fastest vibration ({frequency:.1} 1/s, \
         strongest at node {node}) grows if the time step is {limit:.3e} s or more; {remedy}",
        rounded(*dt, 5)
    )]
    UnstableStep {
        /// The time step, in seconds.
        dt: f64,
        /// The smallest time step that is unstable, in seconds.
        limit: f64,
        /// The largest angular frequency among the vibrations, in 1/s.
        frequency: f64,
        /// The node that moves most in the fastest vibration.
        node: usize,
        /// How to make the time step stable, as an instruction.
        remedy: String,
    },
    /// A run that stopped because its robot changed in such a way that the time step became unstable. The run is saved.
    #[error("after iteration {iteration}: {step}{}", or_go_on(run, *own_loss))]
    UnstableRun {
        /// The run's folder.
        run: PathBuf,
        /// The last iteration that was done.
        iteration: usize,
        /// True if the loss of the run is code of the program that began it. No command can resume such a run.
        own_loss: bool,
        /// The error about the time step of the changed robot: an [`Error::UnstableStep`].
        step: Box<Error>,
    },
    /// A run in use: another process, or another thread of this process, is running it. The value is the run's folder.
    #[error("{}: another process is running this run", .0.display())]
    Taken(PathBuf),
    /// A run that a process of another host has claimed, on a disk without locks. This host cannot know whether that
    /// process still works.
    #[error(
        "{}: {by} claims this run; if that process has ended, remove its claim with: rm {remove}",
        run.display()
    )]
    Claimed {
        /// The run's folder.
        run: PathBuf,
        /// The process and its host, as text.
        by: String,
        /// The files to remove, as words of a shell command.
        remove: String,
    },
    /// Some results are not finite although no simulated state diverged.
    /// The text names the results, and the cause if it is known.
    #[error("these results are not finite: {0}")]
    NotFinite(String),
    /// A number that cannot be computed, because the rollouts that determine it diverged.
    #[error("{0}")]
    NoFigure(String),
    /// Some checks of a group failed.
    #[error("{failed} of {total} checks failed: {what}")]
    CheckFailed {
        /// The failed checks, joined to one text.
        what: String,
        /// The number of checks that failed.
        failed: usize,
        /// The number of checks that ran.
        total: usize,
    },
    /// Some runs of a sweep failed, each for its own reason. All other runs of the sweep are finished.
    #[error("{run}: {}{}", error.within(), and_others(*others))]
    PassedOver {
        /// The first run that failed.
        run: String,
        /// The reason why the first run failed.
        error: Box<Error>,
        /// The number of other runs that failed.
        others: usize,
    },
    /// A command with several runs was interrupted. Each of its runs can be resumed.
    #[error("interrupted with {done} of {total} runs done; repeat the same command to continue")]
    Stopped {
        /// The number of runs that are done.
        done: usize,
        /// The number of all runs.
        total: usize,
    },
    /// A run was interrupted. It can be resumed.
    #[error("interrupted after iteration {iteration}; {}", go_on(run, *own_loss))]
    Interrupted {
        /// The run's folder.
        run: PathBuf,
        /// The number of iterations that the run has done.
        iteration: usize,
        /// True if the loss of the run is code of the program that began it. No command can resume such a run.
        own_loss: bool,
    },
}

/// The result of a function of this crate that can fail.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// Converts an I/O error to the error for a file or folder that cannot be read. Made for `map_err`.
    pub fn reading(path: impl Into<PathBuf>) -> impl FnOnce(io::Error) -> Self {
        let path = path.into();
        |source| Error::Read { path, source }
    }

    /// Converts an I/O error to the error for a file or folder that cannot be written. Made for `map_err`.
    pub fn writing(path: impl Into<PathBuf>) -> impl FnOnce(io::Error) -> Self {
        let path = path.into();
        |source| Error::Write { path, source }
    }

    /// True if the error is about rollouts: they diverged, or their results are not finite.
    #[cfg(feature = "files")]
    pub(crate) fn is_of_rollouts(&self) -> bool {
        matches!(self, Error::Diverged { .. } | Error::NotFinite(_))
    }

    /// The advice at the end of the message about an unstable time step: how to make the step stable, or how to allow
    /// it. `None` for other errors.
    pub fn remedy(&self) -> Option<String> {
        match self {
            Error::UnstableStep { remedy, .. } => Some(remedy.clone()),
            Error::UnstableRun {
                run,
                own_loss,
                step,
                ..
            } => Some(step.remedy()? + &or_go_on(run, *own_loss)),
            _ => None,
        }
    }

    /// The message without its [remedy](Self::remedy).
    pub fn without_remedy(&self) -> String {
        let text = self.to_string();
        let remedy = self.remedy().unwrap_or_default();
        let message = text.strip_suffix(&remedy).unwrap_or(&text);
        message.trim_end_matches("; ").to_owned()
    }

    /// The message without a leading `error: `, so that it can be a part of another message.
    pub fn within(&self) -> String {
        let text = self.to_string();
        text.strip_prefix("error: ").unwrap_or(&text).to_owned()
    }

    /// The exit code of the process: 0 success, 1 failed check, 2 bad usage, malformed file, unstable
    /// step or run in use, 3 diverged, 4 missing,
    /// unreadable or unwritable file, 75 interrupted and resumable.
    pub fn exit_code(&self) -> u8 {
        match self {
            Error::CheckFailed { .. } => 1,
            Error::PassedOver { error, .. } => error.exit_code(),
            Error::Malformed { .. }
            | Error::Misfit { .. }
            | Error::Usage(_)
            | Error::OwnLoss { .. }
            | Error::UnstableStep { .. }
            | Error::Taken(_)
            | Error::Claimed { .. }
            | Error::UnstableRun { .. } => 2,
            Error::Diverged { .. } | Error::NotFinite(_) | Error::NoFigure(_) => 3,
            Error::NoScene { .. } | Error::Read { .. } | Error::Write { .. } => 4,
            Error::Interrupted { .. } | Error::Stopped { .. } => 75,
        }
    }
}

/// Checks that `found`, the number of `what` in `file`, equals `expected`.
///
/// # Errors
/// [`Error::Misfit`].
pub fn fits(file: &str, what: &str, found: usize, expected: usize) -> Result<()> {
    if found != expected {
        return Err(Error::Misfit {
            file: file.to_owned(),
            what: what.to_owned(),
            expected,
            found,
        });
    }
    Ok(())
}

/// Checks that `found`, the number of `what` in `file`, is not 0.
///
/// # Errors
/// [`Error::Usage`].
pub(crate) fn some(file: &str, what: &str, found: usize) -> Result<()> {
    match found {
        0 => Err(Error::Usage(format!(
            "{file}: expected one or more {what}, found 0"
        ))),
        _ => Ok(()),
    }
}

/// The end of a message: the advice to free disk space. Empty unless the disk or the quota is full.
fn make_room(source: &io::Error) -> &'static str {
    match source.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            "; free some space there, then resume the run or repeat the command"
        }
        _ => "",
    }
}

/// The end of a message: the number of failed runs of a sweep other than the first one.
fn and_others(others: usize) -> String {
    match others {
        0 => String::new(),
        1 => "\n1 more run of this sweep failed".to_owned(),
        n => format!("\n{n} more runs of this sweep failed"),
    }
}

/// A path as text for people. Control characters, such as the tab that TOML makes of `\t` in "C:\temp", are escaped.
fn shown(path: &Path) -> String {
    escaped(&path.display().to_string())
}

/// A text in which control characters are escaped as in TOML.
pub(crate) fn escaped(text: &str) -> String {
    let escaped = |c: char| match c.is_control() {
        true => c.escape_default().to_string(),
        false => c.to_string(),
    };
    text.chars().map(escaped).collect()
}

/// Writes a path as one word of a shell command, quoted if necessary.
pub fn in_shell(path: &Path) -> String {
    let text = path.display().to_string();
    let folder = if text.starts_with('-') { "./" } else { "" };
    let text = format!("{folder}{text}");
    let plain = |c: char| c.is_alphanumeric() || "/._-+,:@%".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        text
    } else {
        format!("'{}'", text.replace('\'', r"'\''"))
    }
}

/// The words with which the user starts the program.
static STARTED_WITH: RwLock<Cow<str>> = RwLock::new(Cow::Borrowed("cosmic"));

/// Sets the words with which the user starts the program, such as `cargo run --release --`. The commands in messages
/// begin with them; before the first call they begin with `cosmic`.
pub fn started_with(words: String) {
    if let Ok(mut started) = STARTED_WITH.write() {
        *started = words.into();
    }
}

/// A command for messages, which works if the user types it as it is printed.
pub fn command(arguments: impl Display) -> String {
    let started = STARTED_WITH.read();
    let words = started.as_deref().map_or("cosmic", |words| words);
    format!("{words} {arguments}")
}

/// The end of a message: how to continue an unfinished run.
pub(crate) fn go_on(run: &Path, own_loss: bool) -> String {
    if own_loss {
        format!(
            "continue with record::resume_with and the loss of the run in {}",
            run.display()
        )
    } else {
        let again = command(format_args!("resume {}", in_shell(run)));
        format!("continue with: {again}")
    }
}

/// The end of a message about an unstable time step: to begin a new run or to continue this one. The advice about the
/// time step comes before it.
fn or_go_on(run: &Path, own_loss: bool) -> String {
    if own_loss {
        ", and begin a new run; to keep the time step, set physics.unstable_step = \"warn\" in its scene".into()
    } else {
        let again = command(format_args!("resume {} --allow-unstable", in_shell(run)));
        format!(", and begin a new run, or continue this one anyway with: {again}")
    }
}
