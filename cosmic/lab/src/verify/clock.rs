//! Run times and memory of single pieces of work, measured alone.

use std::fs;
use std::hint::black_box;
use std::time::Duration;

use super::probe::median;

#[cfg(not(windows))]
use cpu_time::ThreadTime as Clock;
// Windows counts a thread's time in ticks of 16 ms: the clock on the wall is the better one there.
#[cfg(windows)]
use std::time::Instant as Clock;

/// Work that takes longer than this, s, is not done again.
const LONG: f64 = 1.0;
/// After this long there is no further round of works that take turns.
const LONGEST: Duration = Duration::from_secs(2);

/// The processor time of this thread that a work takes.
pub(super) fn timed<T>(work: impl FnOnce() -> T) -> Duration {
    let start = Clock::now();
    black_box(work());
    start.elapsed()
}

/// The median processor time of up to so many runs of a work, in s.
pub(super) fn median_time<T>(repeats: usize, mut work: impl FnMut() -> T) -> f64 {
    let (mut times, mut spent) = (Vec::new(), 0.0);
    while times.is_empty() || times.len() < repeats && spent < LONG {
        let time = timed(&mut work).as_secs_f64();
        spent += time;
        times.push(time);
    }
    median(times)
}

/// The least processor time of each work over some rounds, or over fewer where these take long, in
/// s. Each round runs every work once, so that a disturbance of the machine meets all of them.
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

/// The result of a work, its processor time and how many bytes it held at most beyond what was
/// held before, where the system says. Numbers below a MiB are not to be trusted: the system
/// counts pages, and not at once.
pub(super) fn measured<T: Send>(work: impl FnOnce() -> T + Send) -> (T, f64, Option<u64>) {
    let measure = || {
        let _ballast = ballast();
        let before = resident_memory().filter(|_| forget_peak());
        let mut result = None;
        let time: Duration = timed(|| result = Some(work()));
        let after = before.and_then(|before| Some(peak_memory()?.saturating_sub(before)));
        let result = result.expect("the work was done");
        (result, time.as_secs_f64(), after)
    };
    // A thread of its own has no spare buffers of earlier work.
    std::thread::scope(|scope| {
        let done = scope.spawn(measure).join();
        done.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

/// Blocks that fill the memory which earlier work gave back to the allocator and the allocator
/// kept: what is measured would otherwise be found there, and not be seen.
fn ballast() -> Vec<Vec<u8>> {
    /// Small enough to come from what is kept.
    const BLOCK: usize = 64 << 10;
    /// Enough for the system's count to be near the truth.
    const BLOCKS: usize = 32;
    /// 256 MiB: more is not kept.
    const ROUNDS: usize = 128;
    let mut blocks = Vec::new();
    for _ in 0..ROUNDS {
        let before = resident_memory();
        blocks.extend((0..BLOCKS).map(|_| black_box(vec![1u8; BLOCK])));
        let risen = resident_memory()
            .unwrap_or(u64::MAX)
            .saturating_sub(before.unwrap_or(0));
        // Fresh from the system, most of it.
        if risen as usize > BLOCK * BLOCKS / 5 * 4 {
            break;
        }
    }
    blocks
}

/// The most memory that this process has held so far, in bytes, where the system says.
pub fn peak_memory() -> Option<u64> {
    memory("VmHWM:")
}

/// The memory that this process holds, in bytes, where the system says.
fn resident_memory() -> Option<u64> {
    memory("VmRSS:")
}

/// A size in the system's account of this process, in bytes.
fn memory(key: &str) -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(key))?;
    let kibibytes: u64 = line.trim().strip_suffix(" kB")?.parse().ok()?;
    Some(kibibytes * 1024)
}

/// Lets the system count the peak from here on; whether it does.
fn forget_peak() -> bool {
    fs::write("/proc/self/clear_refs", "5").is_ok()
}

#[cfg(test)]
mod tests {
    use super::{measured, median_time, peak_memory};

    #[test]
    fn a_median_is_a_time() {
        let mut runs = 0;
        let time = median_time(3, || runs += 1);
        assert!(runs == 3 && (0.0..1.0).contains(&time));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn memory_is_known_on_linux() {
        assert!(peak_memory().unwrap() > 1 << 16);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn memory_is_that_of_the_work() {
        let ((), _, first) = measured(|| drop(std::hint::black_box(vec![1u8; 64 << 20])));
        // Systems may refuse to start the count again.
        if let Some(bytes) = first {
            assert!(bytes >= 60 << 20, "{bytes}");
        }
    }
}
