//! Timing as ADBench does it.

use std::time::{Duration, Instant};

/// How long to measure.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// A sample repeats the work until it takes longer than this.
    pub least: Duration,
    /// No sample is begun after all samples together have taken this long.
    pub limit: Duration,
}

/// The number of samples that ADBench takes at most.
const SAMPLES: usize = 10;

/// Seconds that `work` takes: it is repeated 1, 2, 4, ... times until that takes longer than
/// `effort.least`; the result is the smallest of up to ten such samples, per repetition.
pub fn seconds(effort: Effort, mut work: impl FnMut()) -> f64 {
    let mut sample = |repeats: u32| {
        let start = Instant::now();
        for _ in 0..repeats {
            work();
        }
        start.elapsed()
    };
    let mut repeats = 1;
    let mut smallest = sample(repeats);
    while smallest <= effort.least {
        repeats *= 2;
        smallest = sample(repeats);
    }
    let mut total = smallest;
    for _ in 1..SAMPLES {
        if total > effort.limit {
            break;
        }
        let next = sample(repeats);
        total += next;
        smallest = smallest.min(next);
    }
    smallest.as_secs_f64() / f64::from(repeats)
}
