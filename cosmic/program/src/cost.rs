//! The cost of an optimisation, which is announced before the work begins.

use cosmic::case::Case;
use cosmic::error::Result;
use cosmic::record::RunPlan;
use cosmic::scene::{GradientPrecision, Scene};
use cosmic::simulator::Span;
use cosmic_lab::check;
use std::fmt;

/// The processor time of an iteration, in full rollouts in f64. An iteration computes one or two gradients over a part of
/// the rollout, and ranks robots. Measured for `earth` (f32), which takes 4.3 rollouts per iteration; the estimate is
/// right within a factor of about 2.
const ROLLOUTS_F32: f64 = 4.5;
/// Like [`ROLLOUTS_F32`], for gradients in f64. Registers hold half as many numbers in f64.
const ROLLOUTS_F64: f64 = 7.0;
/// The measured rollout has at most this many substeps in a step, so that the measurement is fast.
const MOST_SUBSTEPS: usize = 64;
/// The time of a step is the difference between rollouts of these numbers of steps.
const MEASURED: [usize; 2] = [16, 64];

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
        let physics = &scene.physics;
        let rollouts = match scene.gradient.precision {
            GradientPrecision::F32 => ROLLOUTS_F32,
            GradientPrecision::F64 => ROLLOUTS_F64,
        };
        let rollout = physics.steps as f64 * seconds_of_step(scene)?;
        Ok(Self {
            steps: physics.steps,
            substeps: physics.substeps,
            seconds: iterations as f64 * rollouts * rollout,
        })
    }
}

/// Measures the processor time of a time step of the robot with which a scene begins, s.
fn seconds_of_step(scene: &Scene) -> Result<f64> {
    let mut short = scene.clone();
    let physics = &mut short.physics;
    let [less, more] = MEASURED;
    let substeps = physics.substeps.min(MOST_SUBSTEPS);
    let share = substeps as f64 / physics.substeps as f64;
    (physics.steps, physics.substeps, physics.dt) = (more, substeps, share * physics.dt);
    let case = Case::of_scene(&short, 0)?;
    let (simulator, body) = (case.task().simulator, case.body());
    let seconds = |steps: usize| {
        let span = Span::from_start(vec![steps]);
        check::seconds(|| simulator.rollout(&body, &case.controller, &case.start, &span))
    };
    let measured = (0..3).map(|_| seconds(more) - seconds(less));
    let least = measured.fold(f64::INFINITY, f64::min).max(0.0);
    Ok(least / ((more - less) as f64 * share))
}

impl fmt::Display for Cost {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            steps, substeps, ..
        } = self;
        match substeps {
            1 => write!(out, "{steps} steps a rollout")?,
            _ => write!(out, "{steps} steps of {substeps} substeps a rollout")?,
        }
        let (number, unit) = match self.seconds {
            seconds if seconds < 90.0 => (seconds, "second"),
            seconds if seconds < 5400.0 => (seconds / 60.0, "minute"),
            seconds => (seconds / 3600.0, "hour"),
        };
        let number = number.max(1.0).round();
        let s = if number == 1.0 { "" } else { "s" };
        write!(
            out,
            ", about {number} processor {unit}{s} for an optimisation"
        )
    }
}
