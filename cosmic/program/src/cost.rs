//! The cost of an optimisation, which is announced before the work begins.

use crate::output::note;
use cosmic::Registry;
use cosmic::error::Result;
use cosmic::lattice::Lattice;
use cosmic::numbers::counted;
use cosmic::parallel::pool;
use cosmic::record::RunPlan;
use cosmic::scene::{Scene, UnstableStep};
use cosmic::search::CoDesign;
use cosmic_lab::check;
use cosmic_lab::sweep::Plan;
use std::fmt;
use std::num::NonZeroUsize;

/// The measured rollouts have at most about this many mechanical steps, so that the measurement is fast.
const MOST_MECHANICAL: usize = 512;
/// A step of a measured rollout has at most this many substeps.
const MOST_SUBSTEPS: usize = 64;
/// The numbers of iterations that are measured: at the start of the co-design, where a pass for the design and a pass for
/// the controller take turns, and after the snap, where one iteration in three also tries other layouts.
const MEASURED: [usize; 2] = [2, 3];

/// A lattice with at least this many edges is large: before the work begins, its user waits for seconds.
const LARGE: usize = 1000;

/// True if the user should be told what the program does before it prints its first result.
pub(super) fn is_large(lattice: &Lattice) -> bool {
    lattice.edges.len() >= LARGE
}

/// Tells the user of a large lattice what the program does before a run, unless `quiet` is true.
pub(super) fn announce(scene: &Scene, quiet: bool) {
    let lattice = Lattice::new(&scene.lattice, &scene.physics);
    if !quiet && is_large(&lattice) {
        note(&format!(
            "a large lattice, {}: checking its time step and measuring the cost of its iterations ...",
            counted(lattice.edges.len(), "edge")
        ));
    }
}

/// The cost of an optimisation.
pub(super) struct Cost {
    steps: usize,
    substeps: usize,
    /// An estimate of the processor time of the whole optimisation, s.
    seconds: f64,
}

impl Cost {
    /// The cost of optimising a scene with its own number of iterations.
    pub(super) fn of(scene: &Scene) -> Result<Self> {
        Self::of_iterations(scene, scene.schedule.iterations)
    }

    /// The cost of a plan.
    pub(super) fn of_plan(plan: &RunPlan) -> Result<Self> {
        Self::of_iterations(&plan.scene, plan.last_iteration() * plan.starts.get())
    }

    fn of_iterations(scene: &Scene, iterations: usize) -> Result<Self> {
        let Seconds {
            before,
            contest,
            after,
        } = seconds_of_iterations(scene)?;
        let schedule = &scene.schedule;
        let all = schedule.iterations.max(1) as f64;
        let share = schedule.snap_at.saturating_sub(1) as f64 / all;
        Ok(Self {
            steps: scene.physics.steps,
            substeps: scene.physics.substeps,
            seconds: iterations as f64 * (share * before + (1.0 - share) * after + contest / all),
        })
    }
}

/// Processor times, s.
struct Seconds {
    /// Of an iteration before the snap.
    before: f64,
    /// Of the contest of gaits, in addition to as many iterations after it; 0 without a contest.
    contest: f64,
    /// Of an iteration after the snap and the contest.
    after: f64,
}

/// Measures the processor times of iterations. The measured iterations have shorter rollouts. The snap itself happens only once,
/// so its time would mislead.
fn seconds_of_iterations(scene: &Scene) -> Result<Seconds> {
    let (short, longer) = shortened(scene);
    let [first, then] = MEASURED;
    let schedule = &short.schedule;
    let snap = schedule.snap_at.saturating_sub(1);
    let after = schedule.snap_at.min(schedule.iterations);
    let [first, then] = [first.min(snap), then.min(schedule.iterations - after)];
    let mut codesign = CoDesign::new(&short)?;
    let mut progress = codesign.begin(0)?;
    let rounds = codesign.contest();
    // On one thread, the processor time is that of all the work.
    pool(Some(NonZeroUsize::MIN))?.install(|| {
        let mut seconds = |from: usize, count: usize| {
            progress.iteration = from;
            let iterate = || (0..count).for_each(|_| drop(codesign.iterate(&mut progress)));
            longer * check::seconds(iterate) / count.max(1) as f64
        };
        let before = seconds(0, first);
        // The snap gives the robot its layout.
        seconds(snap, after - snap);
        let contest = seconds(after, rounds);
        let after = seconds(after + rounds, then);
        Ok(Seconds {
            before,
            contest: rounds as f64 * (contest - after),
            after,
        })
    })
}

/// The scene with shorter rollouts, and the ratio of the two numbers of mechanical steps.
fn shortened(scene: &Scene) -> (Scene, f64) {
    let (mut short, whole) = (scene.clone(), &scene.physics);
    let substeps = whole.substeps.min(MOST_SUBSTEPS);
    let steps = (MOST_MECHANICAL / substeps).min(whole.steps);
    let shorter = |n: usize| (n as f64 * steps as f64 / whole.steps as f64).ceil() as usize;
    let dt = whole.dt * substeps as f64 / whole.substeps as f64;
    let physics = &mut short.physics;
    (physics.steps, physics.substeps, physics.dt) = (steps, substeps, dt);
    // Whether the time step is stable is not the question here.
    physics.unstable_step = UnstableStep::Warn;
    short.schedule.window =
        (scene.schedule.window).map(|time| time * steps as f64 / whole.steps as f64);
    short.schedule.horizon = scene.schedule.horizon.map(shorter);
    // The first iterations have horizons of all lengths.
    short.schedule.horizon_over = [0, MEASURED[0] + 1];
    short.loss.window = shorter(scene.loss.window);
    short.loss.every = scene.loss.every.min(short.loss.window);
    let longer = whole.steps as f64 / steps as f64 * (whole.substeps as f64 / substeps as f64);
    (short, longer)
}

impl fmt::Display for Cost {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let steps = counted(self.steps, "step");
        match self.substeps {
            1 => write!(out, "{steps} a rollout")?,
            substeps => write!(out, "{steps} of {substeps} substeps a rollout")?,
        }
        let time = processor_time(self.seconds);
        write!(out, ", {time} for an optimisation")
    }
}

/// A processor time in seconds as rounded text.
fn processor_time(seconds: f64) -> String {
    let (number, unit) = match seconds {
        seconds if seconds < 90.0 => (seconds, "second"),
        seconds if seconds < 5400.0 => (seconds / 60.0, "minute"),
        seconds => (seconds / 3600.0, "hour"),
    };
    let number = number.max(1.0).round();
    let s = if number == 1.0 { "" } else { "s" };
    format!("about {number} processor {unit}{s}")
}

/// The cost of a sweep is measured with at most this many of its trials.
const MEASURED_TRIALS: usize = 4;

/// Estimates the processor time of so many runs of a sweep, in words.
pub(super) fn cost_of_sweep(sweep: &Plan, runs: usize, registry: &Registry) -> Result<String> {
    let (trials, seeds) = (sweep.trials.len(), sweep.seeds.get());
    let measured = trials.min(MEASURED_TRIALS);
    let costs = (0..measured).map(|trial| Cost::of_plan(&sweep.run(trial * seeds, registry)?));
    let costs: Vec<Cost> = costs.collect::<Result<_>>()?;
    let mean = costs.iter().map(|cost| cost.seconds).sum::<f64>() / measured as f64;
    let others = match measured < trials {
        true => format!(", if all trials cost as much as the first {measured}"),
        false => String::new(),
    };
    Ok(processor_time(runs as f64 * mean) + &others)
}
