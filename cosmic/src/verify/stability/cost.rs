//! What the guard costs.

use std::hint::black_box;
use std::time::Duration;

use cpu_time::ThreadTime;

use crate::case::Case;
use crate::simulator::Span;

/// Times that each rollout is measured; the least counts, as the one least disturbed.
const REPEATS: usize = 60;
/// Steps of a measured rollout, at most.
const STEPS: usize = 4096;

/// Microseconds per step, processor time of one thread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GuardCost {
    /// Of a plain rollout.
    pub plain: f64,
    /// Of a guarded one.
    pub guarded: f64,
}

impl GuardCost {
    /// What the guard adds, as a share of the plain rollout.
    pub fn share(&self) -> f64 {
        self.guarded / self.plain - 1.0
    }
}

/// Measures a case's rollout with and without the guard, by turns: what disturbs the machine
/// disturbs both.
pub fn guard_cost(case: &Case) -> GuardCost {
    let mut case = case.clone();
    case.physics.steps = case.physics.steps.clamp(1, STEPS);
    let task = case.task();
    let mixture = case.mixture(case.projection, &case.z);
    let robot = (&case.controller, &case.start);
    let end = Span::from_start(vec![case.physics.steps]);
    let mut least = [Duration::MAX; 2];
    for _ in 0..REPEATS {
        let plain = timed(|| task.rollout(&mixture, robot, &end));
        let guarded = timed(|| task.guarded(&mixture, robot, &end));
        least = [least[0].min(plain), least[1].min(guarded)];
    }
    let [plain, guarded] = least.map(|time| time.as_secs_f64() * 1e6 / case.physics.steps as f64);
    GuardCost { plain, guarded }
}

fn timed<T>(work: impl FnOnce() -> T) -> Duration {
    let start = ThreadTime::now();
    black_box(work());
    start.elapsed()
}
