//! [`Run`], which does the iterations of a run, records them in the folder, saves snapshots, and writes the result.

use super::folder::{Lock, begin, keep_scene};
use crate::error::{Error, Result};
use crate::judge::{Delivery, Measurements, Measuring};
use crate::outcome::{DesignFile, Summary};
use crate::record::files::{DESIGN, sweep, write_atomic, write_json};
use crate::record::history::{DesignRow, Frames, History};
use crate::record::snapshot::{RunPlan, SNAPSHOT, Snapshot};
use crate::record::summary::{self, DIVERGED, SUMMARY};
use crate::record::trajectory_file::{self, TRAJECTORY, TrajectoryFile};
use crate::scene::SelectionSettings;
use crate::search::{CoDesign, Progress, Record};
use crate::world::{Grade, Trajectory};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// The name of the file with the robot, if a run began with a given robot.
const START: &str = "start.json";
/// The largest number of iterations from one snapshot to the next.
const SNAPSHOT_EVERY: usize = 10;
/// The longest time from one snapshot to the next, unless an iteration takes longer.
const SNAPSHOT_WITHIN: Duration = Duration::from_secs(1);
/// The run warns after this number of iterations in a row without a usable gradient.
const FLAT: usize = 10;

/// Watches a run and may interrupt it. Several starts are separate runs in parallel. They call one observer from
/// several threads, but never at the same time.
pub trait Observer: Send {
    /// Called when a run begins or is resumed.
    fn begin(&mut self, _run: &Run) {}

    /// Called after every iteration. To interrupt the run and all other starts, return `Break`; they are saved and can
    /// be resumed.
    fn iteration(&mut self, _run: &Run, _record: &Record) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    /// Called when a run has done its iterations.
    fn end(&mut self, _run: &Run) {}

    /// Called with a warning. Each warning is given once, and the run continues.
    fn warning(&mut self, _run: &Run, _text: &str) {}

    /// The flag with which another thread asks the run to stop. The run looks at it in every step of every rollout. It
    /// then abandons the iteration, so that it stops soon even if an iteration takes hours. The run is saved as it was
    /// before that iteration, and can be resumed.
    fn stop(&self) -> Option<Arc<AtomicBool>> {
        None
    }

    /// Called several times during the delivery. To stop the run there, return true; the run is saved and can be
    /// resumed.
    fn is_stopped(&self) -> bool {
        is_asked(self)
    }
}

/// Ignores all events.
impl Observer for () {}

/// True if the [flag](Observer::stop) of an observer is set.
fn is_asked(observer: &(impl Observer + ?Sized)) -> bool {
    let stop = observer.stop();
    stop.is_some_and(|stop| stop.load(Ordering::Relaxed))
}

/// An unfinished run. It holds the lock on its folder.
pub struct Run {
    plan: RunPlan,
    codesign: CoDesign,
    progress: Progress,
    history: History,
    lock: Lock,
    /// The worst grade of the time step so far. A warning is given only if the grade gets worse.
    warned: Grade,
    /// The number of iterations in a row whose gradients were all zero or not finite.
    flat: usize,
    /// True once the run has warned about a payload that does not move.
    stuck: bool,
    /// True if a warning was given that the loss is not finite.
    lost: bool,
    /// Wall time of the run in earlier processes, in seconds.
    before: f64,
    since: Instant,
}

impl Run {
    /// Begins a run of one start in a new or empty folder.
    pub(in crate::record) fn create(folder: &Path, plan: &RunPlan) -> Result<Self> {
        let codesign = CoDesign::new(&plan.scene)?;
        let progress = codesign.begin(plan.seed)?;
        Self::begin(folder, plan, codesign, progress)
    }

    /// Begins a run with the caller's optimisation and progress.
    pub(in crate::record) fn begin(
        folder: &Path,
        plan: &RunPlan,
        codesign: CoDesign,
        progress: Progress,
    ) -> Result<Self> {
        let lock = begin(folder)?;
        // The snapshot is written first, because a killed run can be resumed from it alone.
        Snapshot::save(folder, plan, 0.0, Some(&progress))?;
        Self::at_work(lock, plan.clone(), 0.0, codesign, progress)
    }

    /// Continues a run from a snapshot. If `own` is given, this optimisation of the caller is used.
    pub(in crate::record) fn open(
        lock: Lock,
        snapshot: Snapshot,
        own: Option<CoDesign>,
    ) -> Result<Self> {
        let codesign = own.map_or_else(|| CoDesign::new(&snapshot.plan.scene), Ok)?;
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
            let lattice = codesign.world().lattice();
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
            stuck: false,
            lost: false,
            before,
            since: Instant::now(),
        })
    }

    /// The plan of the run.
    pub fn plan(&self) -> &RunPlan {
        &self.plan
    }

    /// The number of the last iteration.
    pub fn last_iteration(&self) -> usize {
        self.plan.last_after(self.progress.before_first())
    }

    /// The state of the optimisation.
    pub fn progress(&self) -> &Progress {
        &self.progress
    }

    /// Wall time of the run so far without interruptions, in seconds.
    pub fn seconds(&self) -> f64 {
        self.before + self.since.elapsed().as_secs_f64()
    }

    /// Does the remaining iterations and writes the result.
    pub(in crate::record) fn finish(mut self, observer: &mut dyn Observer) -> Result<Summary> {
        self.advance(self.last_iteration(), observer)?;
        let delivery = self.deliver(observer)?;
        let summary = self.write_result(&delivery)?;
        self.lock.finish();
        Ok(summary)
    }

    /// Measures the finished robot. Saves the measurements that are done, so that a resumed run goes on with the others.
    fn deliver(&self, observer: &dyn Observer) -> Result<Delivery> {
        let (mut saved, mut is_kept) = (Instant::now(), !self.progress.measurements.is_empty());
        let mut keep = |known: &Measurements| {
            if saved.elapsed() > SNAPSHOT_WITHIN {
                is_kept = true;
                // A snapshot that cannot be written now is written when the delivery stops, or its error is that of the
                // result.
                let _ = self.save_with(known);
                saved = Instant::now();
            }
        };
        let mut measuring = Measuring {
            rollouts: SelectionSettings::FINAL_ROLLOUTS,
            known: self.progress.measurements.clone(),
            is_stopped: &|| observer.is_stopped(),
            keep: Some(&mut keep),
        };
        let delivery = self.codesign.deliver_unless(&self.progress, &mut measuring);
        let known = measuring.known;
        // Rollouts that were stopped have no result.
        if let Some(delivery) = delivery.filter(|_| !observer.is_stopped()) {
            if is_kept {
                // The snapshot of a finished run does not depend on interruptions.
                self.save_with(&Measurements::default())?;
            }
            return Ok(delivery);
        }
        self.save_with(&known)?;
        Err(self.interrupted())
    }

    /// Does the iterations up to `last` and saves the run.
    pub(in crate::record) fn advance(
        &mut self,
        last: usize,
        observer: &mut dyn Observer,
    ) -> Result<()> {
        observer.begin(self);
        if let Some(text) = self.lock.warning() {
            observer.warning(self, &text);
        }
        self.judge_step(observer)?;
        self.codesign.stop_by(observer.stop());
        let mut saved = Instant::now();
        while self.progress.iteration < last {
            let began = Instant::now();
            let before = self.progress.clone();
            let record = self.codesign.iterate(&mut self.progress);
            let design = (self.history.keeps_design(record.iteration)).then(|| self.design_row());
            if is_asked(observer) {
                return self.abandon(before);
            }
            let seconds = self.seconds();
            self.history.append(&record, seconds)?;
            if let Some(row) = design {
                self.history.append_design(&row)?;
            }
            let interrupted = observer.iteration(self, &record).is_break();
            let next_ends = saved.elapsed() + began.elapsed();
            let due = record.iteration.is_multiple_of(SNAPSHOT_EVERY);
            self.judge_payload(&record, observer);
            self.judge_slopes(&record, observer);
            self.judge_loss(&record, observer);
            // The iteration is not saved, so a resumed run repeats it and ends with the same error.
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

    /// Takes back the current iteration, which was interrupted, and saves the run as it was `before`. Returns the
    /// interruption.
    fn abandon(&mut self, before: Progress) -> Result<()> {
        self.progress = before;
        self.save()?;
        Err(self.interrupted())
    }

    /// The current robot and its motion, for the history.
    fn design_row(&self) -> DesignRow {
        let z = self.progress.design.vectors();
        DesignRow::new(self.progress.iteration, &z, self.walk())
    }

    fn interrupted(&self) -> Error {
        Error::Interrupted {
            run: self.lock.folder().to_owned(),
            iteration: self.progress.iteration,
            own_loss: self.progress.own_loss,
        }
    }

    /// The motion of the current robot, for the history; `None` if the rollout diverges.
    fn walk(&self) -> Option<Frames> {
        let physics = &self.plan.scene.physics;
        let moments = Frames::moments(physics.steps, physics.dt);
        let seen = self.codesign.watch(&self.progress, moments)?;
        let spacing = self.codesign.world().lattice().spacing;
        Frames::of_moments(&seen, physics.dt, spacing)
    }

    /// Warns if the grade of the time step is worse than ever before. Returns an error if the time step is unstable and
    /// the scene does not allow that.
    fn judge_step(&mut self, observer: &mut dyn Observer) -> Result<()> {
        let check = self.codesign.step_check(&self.progress);
        let iteration = self.progress.iteration;
        let begins = iteration == self.progress.before_first();
        let physics = &self.plan.scene.physics;
        check.accept(physics).map_err(|_| Error::UnstableRun {
            run: self.lock.folder().to_owned(),
            iteration,
            own_loss: self.progress.own_loss,
            step: Box::new(check.error("")),
        })?;
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
            "after iteration {}: the loss is {loss}; gradients are skipped while the loss is not finite",
            record.iteration
        );
        observer.warning(self, &text);
    }

    /// Returns `error`, which says that the loss of the run was never finite. If the robot diverges, the cause is
    /// known: then writes the design and its last states, and returns the error about the divergence instead.
    fn or_divergence(&self, error: Error, observer: &mut dyn Observer) -> Error {
        let delivery = self.codesign.deliver(&self.progress);
        if is_asked(observer) {
            return self.interrupted();
        }
        if delivery.seen.divergence.is_none() {
            return error;
        }
        observer.warning(self, &error.to_string());
        self.write_design(&delivery).err().unwrap_or(error)
    }

    /// Warns once about a payload that does not move.
    fn judge_payload(&mut self, record: &Record, observer: &mut dyn Observer) {
        if !record.stuck || self.stuck {
            return;
        }
        self.stuck = true;
        let text = format!(
            "after iteration {}: the payload has not moved in the last iterations, so its gradient is zero; the \
             gradient of the centre of mass is used until the payload moves",
            record.iteration - 1
        );
        observer.warning(self, &text);
    }

    /// Warns if neither the design nor the controller seems to influence the loss, because all gradients are zero or
    /// not finite.
    fn judge_slopes(&mut self, record: &Record, observer: &mut dyn Observer) {
        let [performance, stability] = record.design_gradient;
        let mut slopes = [performance, stability, record.controller_gradient]
            .into_iter()
            .flatten()
            .peekable();
        if slopes.peek().is_none() {
            return;
        }
        // A gradient that is not finite is skipped. So, like a zero gradient, it changes nothing.
        let is_flat = slopes.all(|slope| slope == 0.0 || !slope.is_finite());
        self.flat = if is_flat { self.flat + 1 } else { 0 };
        if self.flat == FLAT {
            let text = format!(
                "after iteration {}: all gradients of the last {FLAT} iterations were zero or not finite; probably \
                 the loss does not depend on design and controller within the horizon, or it is not finite",
                record.iteration
            );
            observer.warning(self, &text);
        }
    }

    fn save(&self) -> Result<()> {
        self.save_with(&self.progress.measurements)
    }

    /// Saves the run with these final measurements.
    fn save_with(&self, known: &Measurements) -> Result<()> {
        self.history.sync()?;
        let progress = Progress {
            measurements: known.clone(),
            ..self.progress.clone()
        };
        Snapshot::save(
            self.lock.folder(),
            &self.plan,
            self.seconds(),
            Some(&progress),
        )
    }

    fn write_result(&self, delivery: &Delivery) -> Result<Summary> {
        let folder = self.lock.folder();
        self.write_design(delivery)?;
        let Trajectory { steps, states, .. } = delivery.seen.trajectory.clone();
        let moves = TrajectoryFile {
            dt: self.plan.scene.physics.dt,
            steps,
            states,
            bars: delivery.seen.bars.clone(),
        };
        write_json(&folder.join(TRAJECTORY), trajectory_file::FORMAT, &moves)?;
        let summary = Summary {
            scene: self.plan.name.clone(),
            seconds: self.seconds(),
            ..Summary::new(&self.plan.scene, &self.progress, delivery)
        };
        write_json(&folder.join(SUMMARY), summary::FORMAT, &summary)?;
        Ok(summary)
    }

    /// Writes the final design of the run. If its rollout diverged, also writes the last states and returns an error.
    fn write_design(&self, delivery: &Delivery) -> Result<()> {
        let folder = self.lock.folder();
        let design = DesignFile::new(
            self.codesign.world().lattice(),
            &delivery.design,
            &delivery.materials,
            &delivery.controller,
        );
        design.write(&folder.join(DESIGN))?;
        let Some(divergence) = &delivery.seen.divergence else {
            return Ok(());
        };
        let case = design.case(&self.plan.scene, DESIGN)?;
        let text = case.diverged_json(divergence) + "\n";
        write_atomic(&folder.join(DIVERGED), |file| {
            file.write_all(text.as_bytes())
        })?;
        Err(Error::from(divergence))
    }
}
