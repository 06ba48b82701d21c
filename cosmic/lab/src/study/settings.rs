//! The settings of a study.

use super::trials::{Base, StudyKind, Trial, trials};
use crate::sweep::{PlannedScene, PlannedStudy, SweepPlan};
use cosmic::error::{Result, in_shell};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

/// A study and its folders.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    /// Which study.
    pub kind: StudyKind,
    /// The first seed.
    pub first_seed: u64,
    /// The number of seeds, from the first on.
    pub seeds: NonZeroUsize,
    /// Stops every run after this many iterations, to try a study in little.
    pub iterations: Option<NonZeroUsize>,
    /// Settings under those of every scene.
    pub base: Base,
    /// The folder of the results.
    pub out: PathBuf,
    /// The folder of the runs, in which an interrupted study continues.
    pub runs: PathBuf,
    /// The Python with MuJoCo, for the study of transfer.
    pub python: PathBuf,
}

impl StudyKind {
    /// The default folder of a study's runs and results.
    pub fn folder(self) -> PathBuf {
        Path::new("runs").join(format!("study-{}", self.name()))
    }
}

impl Study {
    /// The experiments.
    ///
    /// # Errors
    /// The errors of [`trials`].
    pub(super) fn trials(&self) -> Result<Vec<Trial>> {
        trials(self.kind, &self.base)
    }

    /// Every experiment with every seed.
    ///
    /// # Errors
    /// The errors of [`trials`].
    pub(super) fn plan(&self) -> Result<SweepPlan> {
        let scene = |Trial { name, scene, .. }| PlannedScene {
            name,
            swept: Vec::new(),
            scene,
        };
        let python = || self.python.display().to_string();
        let study = PlannedStudy {
            kind: self.kind.name().to_owned(),
            python: (self.kind == StudyKind::Transfer).then(python),
        };
        Ok(SweepPlan {
            study: Some(study),
            first_seed: self.first_seed,
            seeds: self.seeds,
            iterations: self.iterations,
            scenes: self.trials()?.into_iter().map(scene).collect(),
        })
    }

    /// The command that repeats the study.
    pub(super) fn command(&self) -> String {
        let mut command = format!("cosmic study {} --seeds {}", self.kind.name(), self.seeds);
        if self.first_seed != 0 {
            command += &format!(" --first-seed {}", self.first_seed);
        }
        if let Some(iterations) = self.iterations {
            command += &format!(" --iterations {iterations}");
        }
        let (out, runs, base) = (&self.out, &self.runs, Path::new(&self.base.file));
        let folders = [
            ("base", base, self.base == Base::default()),
            ("out", out, out == runs),
            ("runs", runs, *runs == self.kind.folder()),
        ];
        for (option, path, _) in folders.into_iter().filter(|(.., usual)| !usual) {
            command += &format!(" --{option} {}", in_shell(path));
        }
        command
    }
}
