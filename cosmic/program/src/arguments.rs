//! Arguments that several commands share.

use clap::Args;
use cosmic::Registry;
use cosmic::error::{Error, Result};
use cosmic::reading::with_decimal_point;
use cosmic::scene::Scene;
use std::fmt::Display;
use std::num::NonZeroUsize;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// The largest number of threads that the user may ask for. To start more would take longer than a run.
const MOST_THREADS: NonZeroUsize = NonZeroUsize::new(1024).unwrap();

/// Returns a parser for arguments: it accepts whole numbers in the range `allowed`.
///
/// An argument with this parser also needs `allow_negative_numbers`. Without it, clap reads the -1 of `--seed -1` as an
/// option.
pub(super) fn whole<T>(
    allowed: RangeInclusive<T>,
) -> impl Fn(&str) -> std::result::Result<T, String> + Clone
where
    T: FromStr + PartialOrd + Display + Clone,
{
    move |text| {
        let number = text.parse().ok().filter(|number| allowed.contains(number));
        let (least, most) = (allowed.start(), allowed.end());
        number.ok_or_else(|| format!("expected a whole number from {least} to {most}"))
    }
}

/// Parses a seed of the random generator.
pub(super) fn seed(text: &str) -> std::result::Result<u64, String> {
    whole(0..=u64::MAX)(text)
}

/// Parses a count of 1 or more.
pub(super) fn count(text: &str) -> std::result::Result<NonZeroUsize, String> {
    let expected = |_| "expected a whole number, 1 or more".to_owned();
    text.parse().map_err(expected)
}

/// Parses a number for which `allows` returns true. `expected` describes the allowed numbers in the error.
pub(super) fn number(
    text: &str,
    allows: impl Fn(f64) -> bool,
    expected: String,
) -> std::result::Result<f64, String> {
    let number = text.parse().ok().filter(|x| allows(*x));
    number.ok_or_else(|| match with_decimal_point(text) {
        Some(number) => format!("{expected}; use a decimal point: {number}"),
        None => expected,
    })
}

fn threads(text: &str) -> std::result::Result<NonZeroUsize, String> {
    whole(NonZeroUsize::MIN..=MOST_THREADS)(text)
}

/// The option `--set`, which changes settings of a scene.
#[derive(Debug, Clone, Args)]
pub(super) struct Settings {
    /// Change a key of the scene, as in `--set physics.gravity=3.7`; can be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub(super) set: Vec<String>,
}

impl Settings {
    /// Reads the built-in scene or the scene file `name`, and changes it by the settings of `--set`.
    pub(super) fn load(&self, name: &str, registry: &Registry) -> Result<Scene> {
        registry.load(name)?.set(&self.set)
    }

    /// Refuses `--set` for sources that have no scene to change. If `--set` is given, returns an error that contains
    /// `reason`.
    pub(super) fn refuse(&self, reason: &str) -> Result<()> {
        match self.set.first() {
            None => Ok(()),
            Some(setting) => Err(Error::Usage(format!("--set {setting}: {reason}"))),
        }
    }
}

/// The options `--quiet` and `--json`.
#[derive(Debug, Clone, Args)]
pub(super) struct Output {
    /// Print the results and errors, but no progress and no advice
    #[arg(long, short)]
    pub(super) quiet: bool,
    /// Write JSON to standard output
    #[arg(long)]
    pub(super) json: bool,
}

/// The options of commands that simulate for a long time: threads and output.
#[derive(Debug, Clone, Args)]
pub(super) struct Work {
    /// Number of threads, at most 1024 [default: one per core]; the results do not depend on it
    #[arg(long, value_name = "N", value_parser = threads, allow_negative_numbers = true)]
    pub(super) threads: Option<NonZeroUsize>,
    /// Decides what the command prints.
    #[command(flatten)]
    pub(super) output: Output,
}
