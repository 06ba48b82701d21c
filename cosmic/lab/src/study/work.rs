//! The work of a study: its plan, its runs, its results.

use super::check::with_half_steps;
use super::measurement::Measurement;
use super::results::{Provenance, StudyResults};
use super::rows::collect;
use super::{Study, StudyKind, ablation, figures, findings, motifs, paper, transfer};
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
    /// Those of [`plan_runs`](Self::plan_runs); [`Error::Usage`] where the results there are of other
    /// experiments or of more seeds.
    pub fn prepare(&self) -> Result<SweepPlan> {
        let plan = self.checked_plan()?;
        StudyResults::may_replace(self)?;
        // Now, not after hours of work whose results could not be written.
        make_folder(&self.out)?;
        self.keep_plan(plan)
    }

    /// Freezes the plan as [`prepare`](Self::prepare) does, and no results are in view: any processes do
    /// the runs.
    ///
    /// # Errors
    /// [`Error::Usage`] where the runs are of other experiments, and where a study of transfer has no
    /// MuJoCo; those of [`SweepPlan::freeze`].
    pub fn plan_runs(&self) -> Result<SweepPlan> {
        self.keep_plan(self.checked_plan()?)
    }

    /// The plan, if it goes with the one that is there.
    fn checked_plan(&self) -> Result<SweepPlan> {
        Measurement::of(self).check()?;
        let plan = self.plan()?;
        for PlannedScene { name, scene, .. } in &plan.scenes {
            with_half_steps(scene).check().map_err(|error| {
                Error::Usage(format!(
                    "{name}: its designs are rolled out with half the time step and twice the \
                     steps as well, which no scene may have: {}",
                    error.within()
                ))
            })?;
        }
        if !self.runs.join(PLAN).exists() {
            return Ok(plan);
        }
        let before: SweepPlan = SweepPlan::read(&self.runs)?;
        if (&before.scenes, before.iterations) == (&plan.scenes, plan.iterations) {
            return Ok(plan);
        }
        let runs = self.runs.display();
        Err(Error::Usage(format!(
            "{runs}: the runs there are of other scenes or another number of iterations; \
             name another folder by --runs"
        )))
    }

    fn keep_plan(&self, plan: SweepPlan) -> Result<SweepPlan> {
        if !self.runs.join(PLAN).exists() {
            plan.freeze(&self.runs)?;
        } else if SweepPlan::read(&self.runs)? != plan {
            plan.check()?;
            plan.write(&self.runs)?;
        }
        Ok(plan)
    }

    /// Completes the runs, one per thread, and measures the delivered designs.
    ///
    /// # Errors
    /// The errors of [`Sweep::run_all`] and of [`Measurement::keep`]; [`Error::Usage`] where other
    /// processes are still at work on some.
    pub fn simulate(
        &self,
        plan: &SweepPlan,
        threads: Option<NonZeroUsize>,
        overseer: &dyn Overseer,
    ) -> Result<()> {
        let sweep = Sweep {
            folder: &self.runs,
            plan,
            measure: &|_| Ok(()),
        };
        sweep.run_all(threads, overseer)?;
        let left = plan.runs() - plan.over(&self.runs);
        if left > 0 {
            return Err(Error::Usage(format!(
                "other processes are at work on {left} runs; the same command goes on when they \
                 are done"
            )));
        }
        let (total, measurement) = (plan.runs(), Measurement::of(self));
        let stopped = || Error::Stopped { done: total, total };
        let is_stopped = || overseer.is_stopped();
        let measured = in_parallel(total, Crew::of_one(threads), |index, _| {
            if is_stopped() {
                return Err(stopped());
            }
            let folder = plan.folder(&self.runs, index);
            if RunState::of(&folder) != RunState::Done {
                return Ok(());
            }
            let kept = measurement.keep(&folder, &is_stopped)?;
            kept.ok_or_else(stopped)?;
            if self.kind == StudyKind::Transfer {
                overseer.measured(index);
            }
            Ok(())
        });
        measured.map(drop)
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
