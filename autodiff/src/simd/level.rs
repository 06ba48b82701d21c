//! Detects which SIMD registers this machine has, and chooses those that the process uses.

use std::sync::atomic::{AtomicU8, Ordering};

/// The kinds of registers that lanes can use, ordered from narrow to wide.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Level {
    /// No SIMD: scalar code with the instructions that every processor of the target has.
    Baseline,
    /// The 128-bit registers of WebAssembly. The crate must be compiled for them.
    Simd128,
    /// The 128-bit registers and the fused multiply-add that every aarch64 processor has.
    Neon,
    /// 256-bit registers with fused multiply-add (x86-64).
    Avx2,
    /// 512-bit registers (x86-64).
    Avx512,
}

impl Level {
    const ALL: [Self; 5] = [
        Self::Baseline,
        Self::Simd128,
        Self::Neon,
        Self::Avx2,
        Self::Avx512,
    ];

    /// A name for users: `none`, `simd128`, `neon`, `avx2` or `avx512`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Baseline => "none",
            Self::Simd128 => "simd128",
            Self::Neon => "neon",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }
}

/// The value of [`CHOSEN`] before the first computation.
const NOT_YET: u8 = u8::MAX;

/// The registers that this process uses, as a number of [`Level::ALL`]. They are chosen once, because programs are laid out
/// for a number of lanes.
static CHOSEN: AtomicU8 = AtomicU8::new(NOT_YET);

/// Returns the widest registers that lanes use in this process: those of the machine, unless [`limit`] chose narrower
/// ones.
#[inline]
pub fn level() -> Level {
    let chosen = match CHOSEN.load(Ordering::Relaxed) {
        NOT_YET => limit(Level::Avx512),
        chosen => Level::ALL[usize::from(chosen)],
    };
    #[cfg(any(test, feature = "levels"))]
    return chosen.min(CAP.get());
    #[cfg(not(any(test, feature = "levels")))]
    chosen
}

/// Lets lanes use registers that are at most as wide as `widest`, in this whole process. Call it before the first
/// computation: later calls change nothing. Returns the registers that lanes use.
#[cold]
pub fn limit(widest: Level) -> Level {
    let mut there = levels();
    there.retain(|level| *level <= widest);
    let wanted = there.last().copied().unwrap_or(Level::Baseline);
    let [now, order] = [NOT_YET, wanted as u8];
    match CHOSEN.compare_exchange(now, order, Ordering::Relaxed, Ordering::Relaxed) {
        Ok(_) => wanted,
        Err(before) => Level::ALL[usize::from(before)],
    }
}

/// Returns the kinds of registers that this machine and this build have, from narrow to wide.
///
/// Rollouts have the same bits with all of them but [`Level::Baseline`], which has no fused multiply-add. Only sums over
/// more starts than two, or over points of data, depend on the number of lanes: they differ by rounding.
pub fn levels() -> Vec<Level> {
    #[allow(unused_mut)]
    let mut there = vec![Level::Baseline];
    #[cfg(lanes = "x86")]
    if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
        there.push(Level::Avx2);
        #[cfg(any(lanes_512, test))]
        if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") {
            there.push(Level::Avx512);
        }
    }
    #[cfg(lanes = "neon")]
    there.push(Level::Neon);
    #[cfg(lanes = "simd128")]
    there.push(Level::Simd128);
    there
}

#[cfg(any(test, feature = "levels"))]
thread_local! {
    static CAP: std::cell::Cell<Level> = const { std::cell::Cell::new(Level::Avx512) };
}

/// Runs `work` on this thread. Meanwhile, lanes use registers that are at most as wide as `cap`.
#[cfg(any(test, feature = "levels"))]
pub fn at_most<T>(cap: Level, work: impl FnOnce() -> T) -> T {
    let before = CAP.replace(cap);
    let done = work();
    CAP.set(before);
    done
}
