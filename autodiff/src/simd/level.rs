//! The registers of this machine.

/// The registers that lanes use.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Scalar code with the instructions that every processor of the target has.
    Baseline,
    /// The 128-bit registers of WebAssembly, if the crate is compiled for them.
    Simd128,
    /// 128-bit registers and fused multiply-add of every aarch64 processor.
    Neon,
    /// 256-bit registers and fused multiply-add.
    Avx2,
    /// 512-bit registers.
    Avx512,
}

/// The widest registers of this machine.
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

/// Does work in registers that are at most this wide, on this thread.
#[cfg(test)]
pub(crate) fn at_most<T>(cap: Level, work: impl FnOnce() -> T) -> T {
    let before = CAP.replace(cap);
    let done = work();
    CAP.set(before);
    done
}

#[inline]
fn found() -> Level {
    // Without optimisation every inlined intermediate has a stack slot. With wide registers a kernel would
    // need megabytes.
    if cfg!(unoptimised) {
        return Level::Baseline;
    }
    #[cfg(lanes = "x86")]
    {
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
