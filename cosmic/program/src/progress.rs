//! Shows the progress of runs: as bars in a terminal, and as occasional lines in a pipe or a file.

use crate::arguments::Output;
use crate::output::{metres, note, reached};
use cosmic::keys::Keyed;
use cosmic::numbers::{clock, counted};
use cosmic::record::{Observer, Run};
use cosmic::search::{Phase, Record};
use cosmic_lab::sweep::{Plan, RunOutcome, SweepObserver};
use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::collections::BTreeMap;
use std::mem;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Instant;

/// Without bars, a line is printed whenever this many iterations are done.
const LINE_EVERY: usize = 10;

/// Shows the active runs on standard error, because standard output is for results. Also passes on the user's request
/// to stop.
pub(super) struct Progress {
    quiet: bool,
    /// The progress bars. They are hidden with `--quiet` and if there is no terminal.
    bars: MultiProgress,
    stop: Arc<AtomicBool>,
    /// The lines to print when the first run begins.
    introduction: Vec<String>,
    /// What was said [about](about) phases so far.
    explained: Vec<&'static str>,
    /// The active runs, by their seeds.
    runs: BTreeMap<u64, Shown>,
}

/// The display of an active run.
struct Shown {
    /// The progress bar of the run. Its prefix names the scene and the seed; its length is the number of the last
    /// iteration.
    bar: ProgressBar,
    last: usize,
    pace: Pace,
    /// The displacement that was measured most recently, in metres.
    displacement: Option<f64>,
    skipped: usize,
}

/// Says what a phase does, so that a distance that falls does not look like a failure.
fn about(phase: Phase) -> &'static str {
    match phase {
        Phase::CoDesign => {
            "co-design: bars, materials and controller change together; bars are still mixtures of materials, so the \
             distances are not those of a robot that can be built"
        }
        Phase::Attraction => {
            "attraction: every bar moves towards one material; the distance may fall meanwhile"
        }
        Phase::Snap | Phase::FineTuning => {
            "fine-tuning: every bar has one material now, and the controller learns to walk with this robot"
        }
    }
}

impl Progress {
    pub(super) fn new(output: &Output, stop: Arc<AtomicBool>, introduction: Vec<String>) -> Self {
        let bars = MultiProgress::new();
        if output.quiet {
            bars.set_draw_target(ProgressDrawTarget::hidden());
        }
        Self {
            quiet: output.quiet,
            bars,
            stop,
            introduction,
            explained: Vec::new(),
            runs: BTreeMap::new(),
        }
    }
}

impl Shown {
    fn new(run: &Run, bars: &MultiProgress) -> Self {
        let plan = run.plan();
        let (done, last) = (run.progress().iteration, run.last_iteration());
        let title = format!("{} seed {}", plan.name, plan.seed);
        Self {
            bar: bars.add(bar(title, done as u64, last as u64)),
            last,
            pace: Pace::new(done),
            displacement: None,
            skipped: run.progress().skipped,
        }
    }

    /// Shows an iteration on the bar. If there is no bar, returns a line at every tenth iteration and at the last one.
    fn iteration(&mut self, record: &Record) -> Option<String> {
        self.displacement = record.displacement.or(self.displacement);
        self.skipped += record.skipped;
        let (iteration, last) = (record.iteration, self.last);
        let text = self.describe(record);
        let line = format!("{}  {iteration}/{last}  {text}", self.bar.prefix());
        self.bar.set_position(iteration as u64);
        self.bar.set_message(text);
        (iteration.is_multiple_of(LINE_EVERY) || iteration == last).then_some(line)
    }

    /// Describes an iteration in one line: the phase, the last displacement, the volumes and the remaining time.
    fn describe(&self, record: &Record) -> String {
        let phase = record.phase.name().replace('_', " ");
        let displacement = match self.displacement {
            None => "- m".to_owned(),
            Some(x) if x.is_nan() => "diverged".to_owned(),
            Some(x) if record.phase.is_undecided() => metres(Some(x)) + " (undecided)",
            Some(x) => metres(Some(x)),
        };
        let (volume, actuators) = (record.volume, record.actuator_volume);
        let left = self.pace.left(record.iteration, self.last);
        let skipped = match self.skipped {
            0 => String::new(),
            n => format!("  {} skipped", counted(n, "gradient")),
        };
        format!(
            "{phase}  {displacement}  V {volume:.3}  V_act {actuators:.3}{skipped}  {left} left"
        )
    }
}

impl Observer for Progress {
    fn begin(&mut self, run: &Run) {
        let introduction = mem::take(&mut self.introduction);
        for line in introduction.iter().filter(|_| !self.quiet) {
            self.bars.suspend(|| note(line));
        }
        let shown = Shown::new(run, &self.bars);
        self.runs.insert(run.plan().seed, shown);
    }

    fn iteration(&mut self, run: &Run, record: &Record) -> ControlFlow<()> {
        let shown = self.runs.get_mut(&run.plan().seed);
        let line = shown.and_then(|shown| shown.iteration(record));
        let about = about(record.phase);
        if !self.quiet && !self.explained.contains(&about) {
            self.explained.push(about);
            self.bars.suspend(|| note(about));
        }
        if let Some(line) = line.filter(|_| !self.quiet && self.bars.is_hidden()) {
            note(&line);
        }
        ControlFlow::Continue(())
    }

    fn end(&mut self, run: &Run) {
        self.runs.remove(&run.plan().seed);
    }

    fn warning(&mut self, _: &Run, text: &str) {
        if !self.quiet {
            self.bars.suspend(|| note(&format!("warning: {text}")));
        }
    }

    fn stop(&self) -> Option<Arc<AtomicBool>> {
        Some(Arc::clone(&self.stop))
    }
}

/// Estimates the remaining time from the speed of this process.
struct Pace {
    /// The number of iterations or runs that were done before this process began.
    before: usize,
    since: Instant,
}

impl Pace {
    fn new(before: usize) -> Self {
        Self {
            before,
            since: Instant::now(),
        }
    }

    /// Estimates the remaining time, if `done` of `total` iterations or runs are done.
    fn left(&self, done: usize, total: usize) -> String {
        let each = self.since.elapsed().as_secs_f64() / (done - self.before) as f64;
        clock(each * total.saturating_sub(done) as f64)
    }
}

/// Prints a line whenever one of several simultaneous runs ends.
pub(super) struct FinishedRuns {
    quiet: bool,
    stop: Arc<AtomicBool>,
    /// The titles of all runs: their trials and seeds.
    titles: Vec<String>,
    done: AtomicUsize,
    pace: Pace,
}

impl FinishedRuns {
    /// Begins to show the runs of `plan` in `folder`, of which some may be finished.
    pub(super) fn new(output: &Output, stop: Arc<AtomicBool>, plan: &Plan, folder: &Path) -> Self {
        let over = plan.runs() - plan.left(folder).count();
        Self {
            quiet: output.quiet,
            stop,
            titles: (0..plan.runs()).map(|index| title(plan, index)).collect(),
            done: AtomicUsize::new(over),
            pace: Pace::new(over),
        }
    }
}

impl SweepObserver for FinishedRuns {
    fn stop(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.stop)
    }

    fn ended(&self, index: usize, outcome: &RunOutcome) {
        let done = 1 + self.done.fetch_add(1, Ordering::Relaxed);
        if self.quiet {
            return;
        }
        let (title, total) = (&self.titles[index], self.titles.len());
        let (says, left) = (told(outcome), self.pace.left(done, total));
        note(&format!("{done}/{total}  {title}  {says}  {left} left"));
    }

    fn warning(&self, run: &str, text: &str) {
        if !self.quiet {
            note(&format!("warning: {run}: {text}"));
        }
    }
}

/// The title of a run: its trial and its seed.
pub(super) fn title(plan: &Plan, index: usize) -> String {
    let (trial, seed) = plan.parts(index);
    format!("{} seed {seed}", trial.name)
}

/// Describes the outcome of a run in a few words.
pub(super) fn told(outcome: &RunOutcome) -> String {
    match outcome {
        RunOutcome::Done(summary) => {
            let median = reached(summary.displacement_robust_p50, Some(&summary.reliability));
            let seconds = summary.shown("seconds").unwrap_or_default();
            format!("{median}  {seconds}")
        }
        RunOutcome::Diverged(says) => says.clone(),
        RunOutcome::Over => "was done before".to_owned(),
        RunOutcome::Taken => "is being run by another process".to_owned(),
    }
}

impl Drop for Shown {
    /// Removes the bar from the terminal.
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

fn bar(title: String, done: u64, last: u64) -> ProgressBar {
    let style = ProgressStyle::with_template("{prefix} [{bar:24}] {pos}/{len}  {msg}")
        .expect("the template is valid")
        .progress_chars("=> ");
    let bar = ProgressBar::new(last).with_style(style);
    bar.with_position(done).with_prefix(title)
}
