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

/// The maximum number of threads; starting more takes longer than a run.
const MOST_THREADS: NonZeroUsize = NonZeroUsize::new(1024).unwrap();

/// Reads whole numbers of a range.
///
/// An argument with this reader also needs `allow_negative_numbers`, because otherwise clap takes the -1 of `--seed -1`
/// for an option.
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

/// Reads a seed of the random generator.
pub(super) fn seed(text: &str) -> std::result::Result<u64, String> {
    whole(0..=u64::MAX)(text)
}

/// Reads a count of 1 or more.
pub(super) fn count(text: &str) -> std::result::Result<NonZeroUsize, String> {
    let expected = |_| "expected a whole number, 1 or more".to_owned();
    text.parse().map_err(expected)
}

/// Reads a number for which `allows` returns true; `expected` describes the allowed numbers.
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

/// Changes of a scene's settings.
#[derive(Debug, Clone, Args)]
pub(super) struct Settings {
    /// Change a key of the scene, as in `--set physics.gravity=3.7`; can be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub(super) set: Vec<String>,
}

impl Settings {
    /// Reads the scene of a built-in name or of a file, and changes it.
    pub(super) fn load(&self, name: &str, registry: &Registry) -> Result<Scene> {
        self.apply(registry.load(name)?)
    }

    /// Changes a scene.
    pub(super) fn apply(&self, scene: Scene) -> Result<Scene> {
        scene.set(&self.set)
    }

    /// Refuses settings when there is no scene to change.
    pub(super) fn refuse(&self, reason: &str) -> Result<()> {
        match self.set.first() {
            None => Ok(()),
            Some(setting) => Err(Error::Usage(format!("--set {setting}: {reason}"))),
        }
    }
}

/// The output of a command.
#[derive(Debug, Clone, Args)]
pub(super) struct Output {
    /// Print only errors
    #[arg(long, short)]
    pub(super) quiet: bool,
    /// Write JSON to standard output
    #[arg(long)]
    pub(super) json: bool,
}

/// The threads and the output of a command that simulates for a long time.
#[derive(Debug, Clone, Args)]
pub(super) struct Work {
    /// Number of threads, at most 1024 [default: one per core]; the results do not depend on it
    #[arg(long, value_name = "N", value_parser = threads, allow_negative_numbers = true)]
    pub(super) threads: Option<NonZeroUsize>,
    /// The output of the command.
    #[command(flatten)]
    pub(super) output: Output,
}
