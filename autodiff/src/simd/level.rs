//! Detects which SIMD registers this machine has.

/// The kinds of registers that lanes can use, ordered from narrow to wide.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
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

/// Returns the widest registers of this machine.
#[inline]
pub fn level() -> Level {
    #[cfg(test)]
    return found().min(CAP.get());
    #[cfg(not(test))]
    found()
}

#[cfg(test)]
thread_local! {
    static CAP: std::cell::Cell<Level> = const { std::cell::Cell::new(Level::Avx512) };
}

/// Runs `work` on this thread. Meanwhile, lanes use registers that are at most as wide as `cap`.
#[cfg(test)]
pub(crate) fn at_most<T>(cap: Level, work: impl FnOnce() -> T) -> T {
    let before = CAP.replace(cap);
    let done = work();
    CAP.set(before);
    done
}

#[inline]
fn found() -> Level {
    #[cfg(lanes = "x86")]
    {
        #[cfg(any(lanes_512, test))]
        if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") {
            return Level::Avx512;
        }
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            return Level::Avx2;
        }
    }
    if cfg!(lanes = "neon") {
        Level::Neon
    } else if cfg!(lanes = "simd128") {
        Level::Simd128
    } else {
        Level::Baseline
    }
}
