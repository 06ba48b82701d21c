//! SIMD lanes as a [`Real`]: many evaluations at once, in the widest registers that the
//! processor has, chosen at run time. Nothing has to be set at compile time.

#[cfg(test)]
mod tests;
#[cfg(target_arch = "x86_64")]
mod x86;

use crate::real::{Mask, Real};

/// The most lanes that any type has.
pub(crate) const WIDEST: usize = 16;

/// A number type that holds `N` scalars of type `S`, one a lane.
pub trait Lane<S>: Real {
    /// How many scalars.
    const N: usize;
    /// The same scalar in every lane.
    fn splat(value: S) -> Self;
    /// The first `N` scalars of a slice.
    fn load(from: &[S]) -> Self;
    /// Writes the lanes to the first `N` places of a slice.
    fn store(self, to: &mut [S]);
    /// All of a slice shorter than `N`, then zeros.
    fn load_part(from: &[S]) -> Self;
    /// Fills a slice shorter than `N`.
    fn store_part(self, to: &mut [S]);

    /// [`load`](Lane::load) from place `at` on, without a check.
    ///
    /// # Safety
    /// The slice holds at least `at + N` scalars.
    #[allow(unsafe_code)] // Checks were a seventh of a gradient's instructions (callgrind).
    #[inline(always)]
    unsafe fn load_at(from: &[S], at: usize) -> Self {
        debug_assert!(at + Self::N <= from.len());
        // SAFETY: the caller's promise.
        Self::load(unsafe { from.get_unchecked(at..at + Self::N) })
    }
    /// [`store`](Lane::store) from place `at` on, without a check.
    ///
    /// # Safety
    /// The slice holds at least `at + N` scalars.
    #[allow(unsafe_code)] // As above.
    #[inline(always)]
    unsafe fn store_at(self, to: &mut [S], at: usize) {
        debug_assert!(at + Self::N <= to.len());
        // SAFETY: the caller's promise.
        self.store(unsafe { to.get_unchecked_mut(at..at + Self::N) });
    }
    /// The `n` scalars from place `at` on, then zeros, without a check.
    ///
    /// # Safety
    /// The slice holds at least `at + n` scalars, and `n` is no more than `N`.
    #[allow(unsafe_code)] // As above.
    #[inline(always)]
    unsafe fn load_n(from: &[S], (at, n): (usize, usize)) -> Self {
        debug_assert!(n <= Self::N && at + n <= from.len());
        // SAFETY: the caller's promise.
        unsafe {
            match n == Self::N {
                true => Self::load_at(from, at),
                false => Self::load_part(from.get_unchecked(at..at + n)),
            }
        }
    }
    /// Writes the first `n` lanes from place `at` on, without a check.
    ///
    /// # Safety
    /// As of [`load_n`](Lane::load_n).
    #[allow(unsafe_code)] // As above.
    #[inline(always)]
    unsafe fn store_n(self, to: &mut [S], (at, n): (usize, usize)) {
        debug_assert!(n <= Self::N && at + n <= to.len());
        // SAFETY: the caller's promise.
        unsafe {
            match n == Self::N {
                true => self.store_at(to, at),
                false => self.store_part(to.get_unchecked_mut(at..at + n)),
            }
        }
    }
    /// The mask that is true in lane `k` where bit `k` is set.
    fn mask(bits: u16) -> Self::Mask;
    /// Moves the first lanes, in order, to the places of the set bits; zeros elsewhere.
    fn expand(self, bits: u16) -> Self;
    /// Moves the lanes at the places of the set bits, in order, to the first places; then zeros.
    fn compress(self, bits: u16) -> Self;
    /// The lanes of both interleaved: `self[0], other[0], self[1], ...`, the first `N` and the last `N`.
    fn zip(self, other: Self) -> [Self; 2];

    /// The hyperbolic tangent of each. SIMD lanes compute them abreast, as none waits for another.
    #[inline(always)]
    fn tanh_each<const K: usize>(mut x: [Self; K]) -> [Self; K] {
        for k in 0..K {
            x[k] = x[k].tanh();
        }
        x
    }

    /// The first `N` scalars of a slice, or all of a shorter one, then zeros.
    #[inline(always)]
    fn load_up_to(from: &[S]) -> Self {
        if from.len() >= Self::N {
            Self::load(from)
        } else {
            Self::load_part(from)
        }
    }
    /// Writes the lanes, as many as the slice has places for.
    #[inline(always)]
    fn store_up_to(self, to: &mut [S]) {
        if to.len() >= Self::N {
            self.store(to)
        } else {
            self.store_part(to)
        }
    }
}

/// Every number is a lane of itself.
impl<R: Real> Lane<R> for R {
    const N: usize = 1;
    #[inline(always)]
    fn splat(value: R) -> R {
        value
    }
    #[inline(always)]
    fn load(from: &[R]) -> R {
        from[0]
    }
    #[inline(always)]
    fn store(self, to: &mut [R]) {
        to[0] = self;
    }
    #[inline(always)]
    fn load_part(_empty: &[R]) -> R {
        R::zero()
    }
    #[inline(always)]
    fn store_part(self, _empty: &mut [R]) {}
    #[inline(always)]
    fn mask(bits: u16) -> R::Mask {
        R::Mask::splat(bits & 1 == 1)
    }
    #[inline(always)]
    fn expand(self, bits: u16) -> R {
        if bits & 1 == 1 { self } else { R::zero() }
    }
    #[inline(always)]
    fn compress(self, bits: u16) -> R {
        self.expand(bits)
    }
    #[inline(always)]
    fn zip(self, other: R) -> [R; 2] {
        [self, other]
    }
}

/// Work that is written for any lane width; see [`Real::vectorize`]. Lanes are numbers like any other,
/// also inside duals and on a tape:
///
/// ```
/// use autodiff::lanes::{Lane, Vectorized};
/// use autodiff::{Dual, Real};
///
/// /// The slopes of `x^3` at many points.
/// struct Slopes<'a>(&'a [f64]);
///
/// impl Vectorized<f64> for Slopes<'_> {
///     type Output = Vec<f64>;
///     #[inline(always)]
///     fn run<L: Lane<f64>>(self) -> Vec<f64> {
///         let mut slopes = vec![0.0; self.0.len()];
///         for (x, slope) in self.0.chunks(L::N).zip(slopes.chunks_mut(L::N)) {
///             let x = Dual::<L, 1>::variable(L::load_up_to(x), 0);
///             (x * x * x).tangent[0].store_up_to(slope);
///         }
///         slopes
///     }
/// }
///
/// let slopes = f64::vectorize(Slopes(&[0.0, 1.0, 2.0, 3.0, 4.0]));
/// assert_eq!(slopes, [0.0, 3.0, 12.0, 27.0, 48.0]);
/// ```
pub trait Vectorized<S: Real> {
    /// What the work returns.
    type Output;
    /// Does the work in lanes of type `L`. Mark implementations, and all that they call,
    /// `#[inline(always)]`: only then is the code compiled for the instruction set it is entered with.
    fn run<L: Lane<S>>(self) -> Self::Output;
}

/// Which registers lanes use.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// What every processor of the target has; scalar code.
    Baseline,
    /// 256-bit registers and fused multiply-add.
    Avx2,
    /// 512-bit registers.
    Avx512,
}

/// The widest level that this machine has.
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

/// Does work in registers no wider than this, on this thread.
#[cfg(test)]
pub(crate) fn at_most<T>(cap: Level, work: impl FnOnce() -> T) -> T {
    let before = CAP.replace(cap);
    let done = work();
    CAP.set(before);
    done
}

#[inline]
fn found() -> Level {
    // Unoptimised, every inlined intermediate has a stack slot of its own: with wide registers some
    // megabytes for a kernel.
    if cfg!(unoptimised) {
        return Level::Baseline;
    }
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") {
            return Level::Avx512;
        }
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            return Level::Avx2;
        }
    }
    Level::Baseline
}

#[cfg(target_arch = "x86_64")]
pub(crate) use enter::{f32_lanes, f64_lanes};

#[cfg(not(target_arch = "x86_64"))]
pub(crate) fn f64_lanes<V: Vectorized<f64>>(work: V) -> V::Output {
    work.run::<f64>()
}

#[cfg(not(target_arch = "x86_64"))]
pub(crate) fn f32_lanes<V: Vectorized<f32>>(work: V) -> V::Output {
    work.run::<f32>()
}

/// Prefetches `len` numbers from `first` on, which are soon to be read or written. A hint: the pointer
/// need not be valid.
#[inline(always)]
pub(crate) fn prefetch<T>(first: *const T, len: usize) {
    #[cfg(target_arch = "x86_64")]
    for line in 0..(len * size_of::<T>()).div_ceil(64) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        #[allow(unsafe_code)]
        // `cargo bench -p benches --bench rollout`: a fifth of a gradient's time.
        // SAFETY: a hint to the cache; it reads nothing that the program can see.
        unsafe {
            _mm_prefetch::<_MM_HINT_T0>(first.cast::<i8>().wrapping_add(64 * line));
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (first, len);
}

/// The only entry into code compiled for wider registers.
#[cfg(target_arch = "x86_64")]
mod enter {
    // `cargo bench -p benches --bench tapes` shows what it is for.
    #![allow(unsafe_code)]

    use super::x86::{F32x8, F32x16, F64x4, F64x8};
    use super::{Level, Vectorized, level};

    #[inline]
    pub(crate) fn f64_lanes<V: Vectorized<f64>>(work: V) -> V::Output {
        match level() {
            // SAFETY: the level says that the processor has the instructions.
            Level::Avx512 => unsafe { f64_avx512(work) },
            Level::Avx2 => unsafe { f64_avx2(work) },
            Level::Baseline => work.run::<f64>(),
        }
    }

    #[inline]
    pub(crate) fn f32_lanes<V: Vectorized<f32>>(work: V) -> V::Output {
        match level() {
            // SAFETY: as above.
            Level::Avx512 => unsafe { f32_avx512(work) },
            Level::Avx2 => unsafe { f32_avx2(work) },
            Level::Baseline => work.run::<f32>(),
        }
    }

    #[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
    pub(super) fn f64_avx512<V: Vectorized<f64>>(work: V) -> V::Output {
        work.run::<F64x8>()
    }
    #[target_feature(enable = "avx2,fma")]
    pub(super) fn f64_avx2<V: Vectorized<f64>>(work: V) -> V::Output {
        work.run::<F64x4>()
    }
    #[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
    pub(super) fn f32_avx512<V: Vectorized<f32>>(work: V) -> V::Output {
        work.run::<F32x16>()
    }
    #[target_feature(enable = "avx2,fma")]
    pub(super) fn f32_avx2<V: Vectorized<f32>>(work: V) -> V::Output {
        work.run::<F32x8>()
    }
}
