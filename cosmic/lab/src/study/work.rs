//! The work of a study: its plan, its runs, its results.

use super::check::{Check, with_half_steps};
use super::in_mujoco::Transfer;
use super::results::{Provenance, StudyResults};
use super::rows::collect;
use super::{Study, StudyKind, ablation, figures, findings, motifs, paper, python, transfer};
use crate::sweep::{Overseer, PLAN, PlannedScene, RunState, Sweep, SweepPlan};
use cosmic::error::{Error, Result};
use cosmic::parallel::{Crew, in_parallel};
use cosmic::record::files::make_folder;
use std::num::NonZeroUsize;
use std::path::PathBuf;

impl Study {
    /// Freezes the plan, or continues with the plan in the folder. Other seeds of the same experiments
    /// may join those that are there.
    ///
    /// # Errors
    /// [`Error::Usage`] where the runs are of other experiments, or the results of others or of
    /// more seeds, and where a study of transfer has no MuJoCo; those of [`SweepPlan::freeze`].
    pub fn prepare(&self) -> Result<SweepPlan> {
        if self.kind == StudyKind::Transfer {
            python::check(&self.python)?;
        }
        let plan = self.plan()?;
        for PlannedScene { name, scene } in &plan.scenes {
            with_half_steps(scene).check().map_err(|error| {
                Error::Usage(format!(
                    "{name}: its designs are rolled out with half the time step and twice the \
                     steps as well, which no scene may have: {}",
                    error.within()
                ))
            })?;
        }
        let is_new = !self.runs.join(PLAN).exists();
        if !is_new {
            let before = SweepPlan::read(&self.runs)?;
            if (&before.scenes, before.iterations) != (&plan.scenes, plan.iterations) {
                let runs = self.runs.display();
                return Err(Error::Usage(format!(
                    "{runs}: the runs there are of other scenes or another number of iterations; \
                     name another folder by --runs"
                )));
            }
        }
        StudyResults::may_replace(self)?;
        // Now, not after hours of work whose results could not be written.
        make_folder(&self.out)?;
        if is_new {
            plan.freeze(&self.runs)?;
        } else {
            plan.check()?;
            plan.write(&self.runs)?;
        }
        Ok(plan)
    }

    /// Completes the runs, one per thread, and measures the delivered designs.
    ///
    /// # Errors
    /// The errors of [`Sweep::run_all`] and those of keeping a run; [`Error::Usage`] where other processes are still
    /// at work on some.
    pub fn simulate(
        &self,
        plan: &SweepPlan,
        threads: Option<NonZeroUsize>,
        overseer: &dyn Overseer,
    ) -> Result<()> {
        let folder = &self.runs;
        Sweep { folder, plan }.run_all(threads, overseer)?;
        let left = plan.runs() - plan.over(&self.runs);
        if left > 0 {
            return Err(Error::Usage(format!(
                "other processes are at work on {left} runs; the same command goes on when they \
                 are done"
            )));
        }
        let total = plan.runs();
        let checked = in_parallel(total, Crew::of_one(threads), |index, _| {
            if overseer.is_stopped() {
                return Err(Error::Stopped { done: total, total });
            }
            let folder = plan.folder(&self.runs, index);
            match RunState::of(&folder) {
                RunState::Done => Check::keep(&folder)?,
                _ => return Ok(()),
            }
            if self.kind != StudyKind::Transfer {
                return Ok(());
            }
            let is_stopped = || overseer.is_stopped();
            let kept = Transfer::keep(&folder, &self.python, &is_stopped)?;
            kept.ok_or(Error::Stopped { done: total, total })?;
            overseer.measured(index);
            Ok(())
        });
        checked.map(drop)
    }

    /// Writes the results from the runs' records and returns the paths.
    ///
    /// # Errors
    /// If a record is missing or malformed, or a file cannot be written.
    pub fn write(&self) -> Result<Vec<PathBuf>> {
        let rows = collect(&self.runs, &self.plan()?, &self.trials()?)?;
        let results = StudyResults {
            settings: Provenance::of(self),
            motifs: motifs::count(&rows)?,
            rows,
        };
        let document = match self.kind {
            StudyKind::Paper => paper::document_of(self, &results),
            StudyKind::Ablation => ablation::document_of(self, &results),
            StudyKind::Findings => findings::document_of(self, &results),
            StudyKind::Transfer => transfer::document_of(self, &results),
        };
        let mut written = figures::write(self, &results)?;
        written.extend(results.write(self, &document)?);
        Ok(written)
    }
}
