//! What is to be studied, and where.

use super::trials::{Base, StudyKind, Trial, trials};
use crate::sweep::{PlannedScene, SweepPlan};
use cosmic::error::{Result, in_shell};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

/// What is to be studied, and where.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    /// Which study.
    pub kind: StudyKind,
    /// The first seed.
    pub first_seed: u64,
    /// How many seeds, from the first on.
    pub seeds: NonZeroUsize,
    /// Stop every run after so many iterations: to try a study in little.
    pub iterations: Option<NonZeroUsize>,
    /// Settings under those of every scene.
    pub base: Base,
    /// Where the results go.
    pub out: PathBuf,
    /// Where the runs are, or go on.
    pub runs: PathBuf,
}

impl StudyKind {
    /// Where the runs of a study are, and its results, unless other folders are named.
    pub fn folder(self) -> PathBuf {
        Path::new("runs").join(format!("study-{}", self.name()))
    }
}

impl Study {
    /// The experiments.
    ///
    /// # Errors
    /// Those of [`trials`].
    pub(super) fn trials(&self) -> Result<Vec<Trial>> {
        trials(self.kind, &self.base)
    }

    /// Every experiment with every seed.
    ///
    /// # Errors
    /// Those of [`trials`].
    pub(super) fn plan(&self) -> Result<SweepPlan> {
        let scene = |Trial { name, scene, .. }| PlannedScene { name, scene };
        Ok(SweepPlan {
            scenes: self.trials()?.into_iter().map(scene).collect(),
            first_seed: self.first_seed,
            seeds: self.seeds,
            iterations: self.iterations,
        })
    }

    /// The command that makes these results, as a user writes it.
    pub(super) fn command(&self) -> String {
        let mut command = format!("cosmic study {} --seeds {}", self.kind.name(), self.seeds);
        if self.first_seed != 0 {
            command += &format!(" --first-seed {}", self.first_seed);
        }
        if let Some(iterations) = self.iterations {
            command += &format!(" --iterations {iterations}");
        }
        let (out, runs) = (&self.out, &self.runs);
        let folders = [
            (
                "base",
                Path::new(&self.base.file),
                self.base == Base::default(),
            ),
            ("out", out, out == runs),
            ("runs", runs, *runs == self.kind.folder()),
        ];
        for (option, path, _) in folders.into_iter().filter(|(.., usual)| !usual) {
            command += &format!(" --{option} {}", in_shell(path));
        }
        command
    }
}
