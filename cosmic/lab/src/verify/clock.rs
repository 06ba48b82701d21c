//! Measures the run time and the memory of a piece of work while nothing else runs.

use std::fs;
use std::hint::black_box;
use std::time::Duration;

use cosmic::codesign::Quantiles;
#[cfg(not(windows))]
use cpu_time::ThreadTime as Clock;
// Windows counts the processor time of a thread in ticks of 16 ms. Wall time is more precise there.
#[cfg(windows)]
use std::time::Instant as Clock;

/// Pieces of work are repeated until they have taken this many seconds in total.
const LONG: f64 = 1.0;
/// If several pieces of work take turns, a new round begins only within this time.
const LONGEST: Duration = Duration::from_secs(2);

/// Returns the processor time that the current thread needs for a piece of work.
fn timed<T>(work: impl FnOnce() -> T) -> Duration {
    let start = Clock::now();
    black_box(work());
    start.elapsed()
}

/// Returns the median processor time of a piece of work over up to `repeats` runs, in seconds.
pub(super) fn median_time<T>(repeats: usize, mut work: impl FnMut() -> T) -> f64 {
    let mut times = Vec::new();
    while times.is_empty() || times.len() < repeats && times.iter().sum::<f64>() < LONG {
        times.push(timed(&mut work).as_secs_f64());
    }
    Quantiles::of(&times).p50
}

/// Returns the shortest processor time of each piece of work over several rounds, in seconds. Each round runs every
/// piece once, so that a disturbance of the machine affects all of them. There are `rounds` rounds, or fewer if they
/// take long.
pub(super) fn least_times<W, T>(rounds: usize, works: &[W], run: impl Fn(&W) -> T) -> Vec<f64> {
    let start = Clock::now();
    let mut least = vec![f64::INFINITY; works.len()];
    for _ in 0..rounds {
        for (least, work) in least.iter_mut().zip(works) {
            *least = least.min(timed(|| run(work)).as_secs_f64());
        }
        if start.elapsed() > LONGEST {
            break;
        }
    }
    least
}

/// Does a piece of work. Returns its result, its processor time in seconds, and the largest amount of additional memory
/// that the process held meanwhile, in bytes, if the system tells. Do not trust sizes below a MiB: the system counts
/// whole pages, and with a delay.
pub fn measured<T: Send>(work: impl FnOnce() -> T + Send) -> (T, f64, Option<u64>) {
    let measure = || {
        let _ballast = ballast();
        let before = memory("VmRSS:").filter(|_| forget_peak());
        let mut result = None;
        let time = timed(|| result = Some(work())).as_secs_f64();
        let held = before.and_then(|before| Some(peak_memory()?.saturating_sub(before)));
        (result.expect("the work was done"), time, held)
    };
    // A new thread has no spare buffers from earlier work.
    std::thread::scope(|scope| {
        let done = scope.spawn(measure).join();
        done.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

/// Fills the memory that the allocator has kept from earlier work, by allocating blocks. The system already counts that
/// memory for this process. If the measured work used that memory, the work would seem to need less than it does.
fn ballast() -> Vec<Vec<u8>> {
    /// The size of a block. Blocks must be small, because the allocator keeps only small blocks.
    const BLOCK: usize = 64 << 10;
    /// The number of blocks that are allocated in one round. The system updates its count of memory with a delay; after
    /// this many blocks the count is nearly right.
    const BLOCKS: usize = 32;
    /// The largest number of rounds. All rounds together allocate 256 MiB, which is more than allocators keep.
    const ROUNDS: usize = 128;
    let mut blocks = Vec::new();
    for _ in 0..ROUNDS {
        let before = memory("VmRSS:").unwrap_or(0);
        blocks.extend((0..BLOCKS).map(|_| black_box(vec![1u8; BLOCK])));
        let risen = memory("VmRSS:").unwrap_or(u64::MAX).saturating_sub(before);
        // Most of this round's memory came fresh from the system, so the kept memory is used up.
        if risen as usize > BLOCK * BLOCKS / 5 * 4 {
            break;
        }
    }
    blocks
}

/// The largest amount of memory that this process has held so far, in bytes; `None` if the system does not tell.
pub fn peak_memory() -> Option<u64> {
    memory("VmHWM:")
}

/// Reads the size that the system reports for this process under `key`, in bytes; `None` if it reports none.
fn memory(key: &str) -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(key))?;
    let kibibytes: u64 = line.trim().strip_suffix(" kB")?.parse().ok()?;
    Some(kibibytes * 1024)
}

/// Resets the peak memory that the system reports. Returns true on success.
fn forget_peak() -> bool {
    fs::write("/proc/self/clear_refs", "5").is_ok()
}
