//! A run in its folder: it records iterations, saves snapshots, and writes the result at the end.

use super::folder::{Lock, begin, keep_scene};
use crate::codesign::{CoDesign, Delivery, Progress, Record};
use crate::error::{Error, Result};
use crate::record::design_file::{DESIGN, DesignFile};
use crate::record::files::{sweep, write_atomic, write_json};
use crate::record::history::{DesignRow, History, Walk};
use crate::record::snapshot::{RunPlan, SNAPSHOT, Snapshot};
use crate::record::summary::{self, DIVERGED, SUMMARY, Summary};
use crate::record::trajectory_file::{self, TRAJECTORY, TrajectoryFile};
use crate::simulator::{Grade, Trajectory};
use std::ops::ControlFlow;
use std::path::Path;
use std::time::{Duration, Instant};

/// Where the robot is kept that a run began with, if it was not the scene's start.
const START: &str = "start.json";
/// The most iterations from one snapshot to the next.
const SNAPSHOT_EVERY: usize = 10;
/// The longest time from one snapshot to the next, if iterations take as long as the last one.
const SNAPSHOT_WITHIN: Duration = Duration::from_secs(1);
/// The run warns after so many iterations in a row without any gradient.
const FLAT: usize = 10;

/// Watches a run and may interrupt it. Several starts are separate runs and may run at the same
/// time: calls come from several threads, one at a time.
pub trait Observer: Send {
    /// A run begins or is resumed.
    fn begin(&mut self, _run: &Run) {}

    /// An iteration is done. `Break` interrupts the run and all runs beside it. They are saved and
    /// can be resumed.
    fn iteration(&mut self, _run: &Run, _record: &Record) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    /// A run is finished, or waits for other runs at a rung of the search.
    fn end(&mut self, _run: &Run) {}

    /// A warning, given once. The run goes on.
    fn warning(&mut self, _run: &Run, _text: &str) {}

    /// True if the run should stop during its delivery; called between the parts of the delivery. The
    /// run is saved and can be resumed.
    fn is_stopped(&self) -> bool {
        false
    }

    /// False once another process has taken the run over. Then it ends with [`Error::Taken`] and writes
    /// nothing any more.
    fn holds(&self) -> bool {
        true
    }
}

/// Watches nothing.
impl Observer for () {}

/// A run that is not finished, with the lock on its folder.
pub struct Run {
    plan: RunPlan,
    codesign: CoDesign,
    progress: Progress,
    history: History,
    lock: Lock,
    /// The worst grade of the time step so far; a warning was given for it.
    warned: Grade,
    /// Number of iterations in a row whose gradients were all zero or not finite.
    flat: usize,
    /// True once a loss that is not finite has been warned about.
    lost: bool,
    /// Wall time spent by earlier processes, s.
    before: f64,
    since: Instant,
}

impl Run {
    /// Begins a run of one start.
    pub(in crate::record) fn create(folder: &Path, plan: &RunPlan) -> Result<Self> {
        let codesign = CoDesign::new(&plan.scene)?;
        let progress = codesign.begin(plan.seed)?;
        Self::begin(folder, plan, codesign, progress)
    }

    pub(in crate::record) fn begin(
        folder: &Path,
        plan: &RunPlan,
        codesign: CoDesign,
        progress: Progress,
    ) -> Result<Self> {
        let lock = begin(folder)?;
        // The snapshot first: it alone lets a killed run be resumed.
        Snapshot::save(folder, plan, 0.0, Some(&progress))?;
        Self::at_work(lock, plan.clone(), 0.0, codesign, progress)
    }

    /// Continues from a snapshot.
    pub(in crate::record) fn open(lock: Lock, snapshot: Snapshot) -> Result<Self> {
        let codesign = CoDesign::new(&snapshot.plan.scene)?;
        Self::open_with(lock, snapshot, codesign)
    }

    /// Continues from a snapshot with the caller's optimisation.
    pub(in crate::record) fn open_with(
        lock: Lock,
        snapshot: Snapshot,
        codesign: CoDesign,
    ) -> Result<Self> {
        let seconds = snapshot.seconds;
        let (plan, progress) = snapshot.unpack(&lock.folder().join(SNAPSHOT), &codesign)?;
        Self::at_work(lock, plan, seconds, codesign, progress)
    }

    fn at_work(
        lock: Lock,
        plan: RunPlan,
        before: f64,
        codesign: CoDesign,
        progress: Progress,
    ) -> Result<Self> {
        let folder = lock.folder();
        let history = History::open(folder, progress.before_first(), progress.iteration)?;
        sweep(folder)?;
        keep_scene(folder, &plan.scene)?;
        if progress.entered == Some(progress.iteration) {
            let lattice = &codesign.task().lattice;
            let materials = codesign.design(&progress).materials();
            let start =
                DesignFile::new(lattice, &progress.design, &materials, &progress.controller);
            start.write(&folder.join(START))?;
        }
        Ok(Self {
            plan,
            codesign,
            progress,
            history,
            lock,
            warned: Grade::Safe,
            flat: 0,
            lost: false,
            before,
            since: Instant::now(),
        })
    }

    /// The plan of the run.
    pub fn plan(&self) -> &RunPlan {
        &self.plan
    }

    /// The last iteration.
    pub fn last_iteration(&self) -> usize {
        self.plan.last_after(self.progress.before_first())
    }

    /// The state of the optimisation.
    pub fn progress(&self) -> &Progress {
        &self.progress
    }

    /// Wall time so far, interruptions left out, s.
    pub fn seconds(&self) -> f64 {
        self.before + self.since.elapsed().as_secs_f64()
    }

    /// Does the remaining iterations and writes the result.
    pub(in crate::record) fn finish(mut self, observer: &mut dyn Observer) -> Result<Summary> {
        self.advance(self.last_iteration(), observer)?;
        let is_stopped = || observer.is_stopped();
        let delivery = self.codesign.deliver_unless(&self.progress, &is_stopped);
        self.refuse_lost(observer)?;
        let delivery = delivery.ok_or_else(|| self.interrupted())?;
        let summary = self.write_result(&delivery)?;
        self.lock.finish();
        Ok(summary)
    }

    /// Does the iterations up to `last` and saves the run.
    pub(in crate::record) fn advance(
        &mut self,
        last: usize,
        observer: &mut dyn Observer,
    ) -> Result<()> {
        observer.begin(self);
        self.judge_step(observer)?;
        let mut saved = Instant::now();
        while self.progress.iteration < last {
            let began = Instant::now();
            let record = self.codesign.iterate(&mut self.progress);
            self.refuse_lost(observer)?;
            let seconds = self.seconds();
            self.history.append(&record, seconds)?;
            if self.history.keeps_design(record.iteration) {
                let row = DesignRow::new(
                    record.iteration,
                    &self.progress.design.vectors(),
                    self.walk(),
                );
                self.history.append_design(&row)?;
            }
            let interrupted = observer.iteration(self, &record).is_break();
            let next_ends = saved.elapsed() + began.elapsed();
            let due = record.iteration.is_multiple_of(SNAPSHOT_EVERY);
            self.judge_slopes(&record, observer);
            self.judge_loss(&record, observer);
            // The iteration is not saved: resuming the run repeats it and ends with this error
            // again.
            (self.progress.check_loss(&record))
                .map_err(|lost| self.or_divergence(lost, observer))?;
            let judged = self.judge_step(observer);
            if interrupted || judged.is_err() || due || next_ends > SNAPSHOT_WITHIN {
                self.save()?;
                saved = Instant::now();
            }
            judged?;
            if interrupted {
                return Err(self.interrupted());
            }
        }
        self.save()?;
        observer.end(self);
        Ok(())
    }

    fn interrupted(&self) -> Error {
        Error::Interrupted {
            run: self.lock.folder().to_owned(),
            iteration: self.progress.iteration,
            own_loss: self.progress.own_loss,
        }
    }

    /// How the present robot walks; `None` if it diverges.
    fn walk(&self) -> Option<Walk> {
        let physics = &self.plan.scene.physics;
        let moments = Walk::moments(physics.steps, physics.dt);
        let seen = self.codesign.watch(&self.progress, moments)?;
        let spacing = self.codesign.task().lattice.spacing;
        Walk::of_moments(&seen, physics.dt, spacing)
    }

    /// Warns of a time step that became worse than any before, and refuses an unstable one unless
    /// the scene allows it.
    fn judge_step(&mut self, observer: &mut dyn Observer) -> Result<()> {
        let check = self.codesign.step_check(&self.progress);
        let (iteration, own_loss) = (self.progress.iteration, self.progress.own_loss);
        let begins = iteration == self.progress.before_first();
        let physics = &self.plan.scene.physics;
        check.accept_in(self.lock.folder(), iteration, own_loss, physics)?;
        if begins && let Some(text) = check.of_other_designs() {
            observer.warning(self, &text);
        }
        if check.grade() > self.warned {
            let when = if begins {
                String::new()
            } else {
                format!("after iteration {iteration}: ")
            };
            observer.warning(self, &format!("{when}{check}"));
            self.warned = check.grade();
        }
        Ok(())
    }

    /// Warns once about a loss that is not finite.
    fn judge_loss(&mut self, record: &Record, observer: &mut dyn Observer) {
        let lost = record.loss_horizon.filter(|loss| !loss.is_finite());
        let Some(loss) = lost.filter(|_| !self.lost) else {
            return;
        };
        self.lost = true;
        let text = format!(
            "after iteration {}: the loss is {loss}; its gradient is skipped, and so are all others \
             without a finite loss",
            record.iteration
        );
        observer.warning(self, &text);
    }

    /// The error of a run without a finite loss, or the divergence of its robot if that is the cause. In
    /// the second case the last states are written.
    fn or_divergence(&self, error: Error, observer: &mut dyn Observer) -> Error {
        let delivery = self.codesign.deliver(&self.progress);
        if delivery.divergence.is_none() {
            return error;
        }
        observer.warning(self, &error.to_string());
        self.write_design(&delivery).err().unwrap_or(error)
    }

    /// Warns of a task that design and controller do not influence.
    fn judge_slopes(&mut self, record: &Record, observer: &mut dyn Observer) {
        let [performance, stability] = record.design_gradient;
        let mut slopes = [performance, stability, record.controller_gradient]
            .into_iter()
            .flatten()
            .peekable();
        if slopes.peek().is_none() {
            return;
        }
        // A gradient that is not finite is skipped: it moves nothing, like a zero.
        let is_flat = slopes.all(|slope| slope == 0.0 || !slope.is_finite());
        self.flat = if is_flat { self.flat + 1 } else { 0 };
        if self.flat == FLAT {
            let text = format!(
                "after iteration {}: all gradients of the last {FLAT} iterations were zero or not \
                 finite: within the horizon nothing that is designed has an influence on the task, or \
                 the loss is no number",
                record.iteration
            );
            observer.warning(self, &text);
        }
    }

    fn save(&self) -> Result<()> {
        self.history.sync()?;
        let (folder, progress) = (self.lock.folder(), &self.progress);
        Snapshot::save(folder, &self.plan, self.seconds(), Some(progress))
    }

    /// Refuses to write where another process has taken over.
    fn refuse_lost(&self, observer: &dyn Observer) -> Result<()> {
        if observer.holds() {
            return Ok(());
        }
        Err(Error::Taken(self.lock.folder().to_owned()))
    }

    fn write_result(&self, delivery: &Delivery) -> Result<Summary> {
        let folder = self.lock.folder();
        self.write_design(delivery)?;
        let Trajectory { steps, states } = delivery.trajectory.clone();
        let dt = self.plan.scene.physics.dt;
        let bars = delivery.bars.clone();
        let moves = TrajectoryFile {
            dt,
            steps,
            states,
            bars,
        };
        write_json(&folder.join(TRAJECTORY), trajectory_file::FORMAT, &moves)?;
        let summary = Summary::new(&self.plan, &self.progress, delivery, self.seconds());
        write_json(&folder.join(SUMMARY), summary::FORMAT, &summary)?;
        Ok(summary)
    }

    /// Writes the delivered design.
    fn write_design(&self, delivery: &Delivery) -> Result<()> {
        let design = DesignFile::new(
            &self.codesign.task().lattice,
            &delivery.design,
            &delivery.materials,
            &delivery.controller,
        );
        design.write(&self.lock.folder().join(DESIGN))?;
        self.refuse_divergence(&design, delivery)
    }

    /// Refuses a delivered design that diverges, and writes its last states.
    fn refuse_divergence(&self, design: &DesignFile, delivery: &Delivery) -> Result<()> {
        let Some(divergence) = &delivery.divergence else {
            return Ok(());
        };
        let case = design.case(&self.plan.scene, DESIGN)?;
        let text = case.diverged_json(divergence) + "\n";
        write_atomic(&self.lock.folder().join(DIVERGED), |file| {
            file.write_all(text.as_bytes())
        })?;
        Err(Error::from(divergence))
    }
}
