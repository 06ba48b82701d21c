//! What lanes do: [`Lane`], a number that holds several, and [`Vectorized`], work in lanes of any width.

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
/// use autodiff::simd::{Lane, Vectorized};
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

struct LaneCount;

impl<R: Real> Vectorized<R> for LaneCount {
    type Output = usize;
    #[inline(always)]
    fn run<L: Lane<R>>(self) -> usize {
        L::N
    }
}

/// How many lanes a register of this type has on this machine.
pub(crate) fn lanes<R: Real>() -> usize {
    let lanes = R::vectorize(LaneCount);
    let fits = lanes.is_power_of_two() && lanes <= WIDEST;
    assert!(
        fits,
        "lanes of a number type are a power of two, {WIDEST} at most"
    );
    lanes
}
