//! The measurements of a study's runs, one by one: the delivered design at half the time step and with the goal
//! behind, and how far it gets in MuJoCo.

use super::check::Check;
use super::in_mujoco::Transfer;
use super::{Study, StudyKind, python};
use crate::sweep::PlannedStudy;
use cosmic::error::{Error, Result};
use std::path::{Path, PathBuf};

/// The measurements that a study takes of each of its runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    kind: StudyKind,
    python: PathBuf,
}

impl Measurement {
    /// The measurements of the study that a plan names.
    ///
    /// # Errors
    /// [`Error::Usage`] for a study that this program does not know.
    pub fn planned(study: &PlannedStudy) -> Result<Self> {
        let is_it = |kind: &StudyKind| kind.name() == study.kind;
        let Some(kind) = StudyKind::ALL.into_iter().find(is_it) else {
            let known = StudyKind::ALL.map(StudyKind::name).join(", ");
            let found = &study.kind;
            return Err(Error::Usage(format!(
                "the plan is of the study `{found}`; this program knows {known}"
            )));
        };
        Ok(Self {
            kind,
            python: PathBuf::from(study.python.as_deref().unwrap_or_default()),
        })
    }

    pub(super) fn of(study: &Study) -> Self {
        Self {
            kind: study.kind,
            python: study.python.clone(),
        }
    }

    /// Checks that this machine can measure.
    ///
    /// # Errors
    /// [`Error::Usage`] for a study of transfer without MuJoCo.
    pub fn check(&self) -> Result<()> {
        if self.kind == StudyKind::Transfer {
            python::check(&self.python)?;
        }
        Ok(())
    }

    /// Measures a run that is done and writes what it finds into the run's folder, unless it is there.
    /// `None` if it was stopped.
    ///
    /// # Errors
    /// The errors of reading the run's files and of writing others; [`Error::Usage`] where Python fails.
    pub fn keep(&self, folder: &Path, is_stopped: &dyn Fn() -> bool) -> Result<Option<()>> {
        Check::keep(folder)?;
        if self.kind == StudyKind::Transfer {
            return Transfer::keep(folder, &self.python, is_stopped);
        }
        Ok(Some(()))
    }
}

#[cfg(test)]
mod tests {
    use super::{Measurement, StudyKind};
    use crate::sweep::PlannedStudy;

    #[test]
    fn a_plan_s_study_is_known_by_its_name() {
        let planned = |kind: &str| {
            Measurement::planned(&PlannedStudy {
                kind: kind.to_owned(),
                python: None,
            })
        };
        for kind in StudyKind::ALL {
            assert_eq!(planned(kind.name()).unwrap().kind, kind);
        }
        let error = planned("papers").unwrap_err().to_string();
        assert!(error.contains("`papers`") && error.contains("paper, ablation"));
    }
}
