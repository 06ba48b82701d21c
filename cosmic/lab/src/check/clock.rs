//! Measures processor times.

use std::hint::black_box;

use cosmic::judge::Quantiles;
#[cfg(not(windows))]
use cpu_time::ThreadTime as Clock;
// Windows counts the processor time of a thread in ticks of 16 ms. Wall time is more precise there.
#[cfg(windows)]
use std::time::Instant as Clock;

/// A piece of work is repeated until it has taken this many seconds in total.
const LONG: f64 = 0.2;

/// Returns the processor time in seconds that the current thread needs for a piece of work.
pub fn seconds<T>(work: impl FnOnce() -> T) -> f64 {
    let start = Clock::now();
    black_box(work());
    start.elapsed().as_secs_f64()
}

/// Returns the median processor time of a piece of work over up to `repeats` runs, in seconds.
pub(super) fn median_time<T>(repeats: usize, mut work: impl FnMut() -> T) -> f64 {
    let mut times = Vec::new();
    while times.is_empty() || times.len() < repeats && times.iter().sum::<f64>() < LONG {
        times.push(seconds(&mut work));
    }
    Quantiles::of(&times).p50
}
