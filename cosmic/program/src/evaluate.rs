//! `cosmic evaluate`.

use crate::arguments::Settings;
use crate::output::{note, print, see_again};
use crate::source::Source;
use clap::Args;
use cosmic::Registry;
use cosmic::case::{Case, CaseResults};
use cosmic::error::{Error, Result};
use cosmic::record::DIVERGED;
use cosmic::record::files::write_atomic;
use std::path::{Path, PathBuf};

/// Simulate one robot and print the results as JSON
///
/// If the simulation diverges (exit code 3), the last states are written to diverged.json: beside the
/// file of --out, or else in the current folder. An existing diverged.json is replaced.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// A reference case, a run's folder or design.json (with its scene.toml beside it), a scene
    /// file, or a built-in scene
    #[arg(value_name = "FILE")]
    file: String,
    #[command(flatten)]
    settings: Settings,
    /// Also compute the exact gradients
    #[arg(long)]
    gradient: bool,
    /// Write the states of these steps [default: the steps listed in the file, or 0, 1, 2, 3 and the last]
    #[arg(long, value_name = "STEPS", value_delimiter = ',')]
    record: Vec<usize>,
    /// Write to this file instead of standard output
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

impl Arguments {
    pub(super) fn run(&self, registry: &Registry) -> Result<()> {
        self.check_out()?;
        let case = Source::read(&self.file, &self.settings, registry)?.case;
        let results = case.evaluate(self.gradient, &self.record)?;
        let text = results.to_json() + "\n";
        match &self.out {
            Some(path) => write_atomic(path, |file| file.write_all(text.as_bytes()))?,
            None => print(&text)?,
        }
        self.judge(&case, &results)
    }

    /// Refuses `--out diverged.json`, because the last states of a divergence would overwrite this file.
    fn check_out(&self) -> Result<()> {
        let name = self.out.as_deref().and_then(Path::file_name);
        if !name.is_some_and(|name| name.eq_ignore_ascii_case(DIVERGED)) {
            return Ok(());
        }
        Err(Error::Usage(format!(
            "--out: {DIVERGED} is reserved for the last states of a diverged simulation; use another name"
        )))
    }

    /// Returns an error if the simulation diverged or if a result is not finite. After a divergence it also
    /// writes the last states to `diverged.json`.
    fn judge(&self, case: &Case, results: &CaseResults) -> Result<()> {
        let names = results.not_finite();
        let listed = names.join(", ");
        let Some(divergence) = &results.divergence else {
            if names.is_empty() {
                return Ok(());
            }
            let is_lost = names.iter().any(|name| name.starts_with("grad_l_disp."));
            let cause = match is_lost {
                true => {
                    "; the derivatives of so many steps may exceed the range of numbers: take fewer steps"
                }
                false => "",
            };
            return Err(Error::NotFinite(listed + cause));
        };
        if !names.is_empty() {
            note(&format!(
                "these results are not finite and were written as null: {listed}"
            ));
        }
        let text = case.diverged_json(divergence) + "\n";
        let path = self.beside(DIVERGED);
        match write_atomic(&path, |file| file.write_all(text.as_bytes())) {
            Ok(()) => note(&see_again(&path)),
            // This is only a note, because the command returns the error about the divergence.
            Err(error) => note(&format!("the last states could not be written: {error}")),
        }
        Err(Error::from(divergence))
    }

    /// The path of a file `name` beside the file of `--out`. If the results go to standard output, a pipe or a device,
    /// the path is in the current folder.
    fn beside(&self, name: &str) -> PathBuf {
        let file = self.out.as_deref().filter(|out| out.is_file());
        let folder = file.and_then(Path::parent);
        folder.map_or_else(|| name.into(), |folder| folder.join(name))
    }
}
