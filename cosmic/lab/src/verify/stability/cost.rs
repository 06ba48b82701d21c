//! The cost of the guard.

use crate::verify::clock::timed;
use crate::verify::probe::median;
use cosmic::case::Case;
use cosmic::simulator::Span;

/// Repeats of both measurements.
const REPEATS: usize = 300;
/// Steps of a measured rollout, at most.
const STEPS: usize = 4096;

/// Processor time of one thread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GuardCost {
    /// Microseconds a step of a plain rollout, the least of many.
    pub plain: f64,
    /// Microseconds a step of a guarded rollout, the least of many.
    pub guarded: f64,
    /// The cost of the guard as a share of the plain rollout: the median over neighbouring pairs, which
    /// changes of the machine's speed do not bias.
    pub share: f64,
}

/// Measures a case's rollout with and without the guard, in turns: a disturbance of the machine affects
/// both.
pub fn guard_cost(case: &Case) -> GuardCost {
    let mut case = case.clone();
    case.physics.steps = case.physics.steps.clamp(1, STEPS);
    let task = case.task();
    let design = case.own_design();
    let (controller, start) = (&case.controller, &case.start);
    let end = Span::from_start(vec![case.physics.steps]);
    let plain = || timed(|| task.rollout(&design, controller, start, &end)).as_secs_f64();
    let guarded = || timed(|| task.guarded(&design, controller, start, &end)).as_secs_f64();
    let mut pairs: Vec<[f64; 2]> = Vec::new();
    for k in 0..REPEATS {
        // Each is first as often as the other: the state of the cache favours neither.
        let early = (k % 2 == 1).then(&guarded);
        pairs.push([plain(), early.unwrap_or_else(&guarded)]);
    }
    let least = |k: usize| pairs.iter().map(|p| p[k]).fold(f64::INFINITY, f64::min);
    let per_step = 1e6 / case.physics.steps as f64;
    let ratios = pairs.iter().map(|[plain, guarded]| guarded / plain);
    GuardCost {
        plain: least(0) * per_step,
        guarded: least(1) * per_step,
        share: median(ratios) - 1.0,
    }
}
