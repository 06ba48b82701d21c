//! Loads and stores without bounds checks, for loops whose bounds were checked once.

use std::hint::assert_unchecked;

use crate::real::Lane;

/// Adds loads and stores without bounds checks to registers.
pub trait Unchecked<S>: Lane<S> {
    /// Like [`load`](Lane::load), but loads from index `at` on and without a bounds check.
    ///
    /// # Safety
    /// The slice must hold at least `at + N` scalars.
    #[allow(unsafe_code)] // Bounds checks took a seventh of a gradient's instructions (callgrind).
    #[inline(always)]
    unsafe fn load_at(from: &[S], at: usize) -> Self {
        debug_assert!(at + Self::N <= from.len());
        // SAFETY: guaranteed by the caller.
        Self::load(unsafe { from.get_unchecked(at..at + Self::N) })
    }
    /// Like [`store`](Lane::store), but stores from index `at` on and without a bounds check.
    ///
    /// # Safety
    /// The slice must hold at least `at + N` scalars.
    #[allow(unsafe_code)] // See `load_at`.
    #[inline(always)]
    unsafe fn store_at(self, to: &mut [S], at: usize) {
        debug_assert!(at + Self::N <= to.len());
        // SAFETY: guaranteed by the caller.
        self.store(unsafe { to.get_unchecked_mut(at..at + Self::N) });
    }
    /// Loads `n` scalars from index `at` on, without a bounds check. The other lanes are zero.
    ///
    /// # Safety
    /// The slice must hold at least `at + n` scalars, and `n` must be at most `N`.
    #[allow(unsafe_code)] // See `load_at`.
    #[inline(always)]
    unsafe fn load_n(from: &[S], at: usize, n: usize) -> Self {
        debug_assert!(n <= Self::N && at + n <= from.len());
        // SAFETY: guaranteed by the caller. The hint saves the check of `load_part`.
        unsafe {
            if n == Self::N {
                Self::load_at(from, at)
            } else {
                let part = from.get_unchecked(at..at + n);
                assert_unchecked(part.len() < Self::N);
                Self::load_part(part)
            }
        }
    }
    /// Stores the first `n` lanes from index `at` on, without a bounds check.
    ///
    /// # Safety
    /// The slice must hold at least `at + n` scalars, and `n` must be at most `N`.
    #[allow(unsafe_code)] // See `load_at`.
    #[inline(always)]
    unsafe fn store_n(self, to: &mut [S], at: usize, n: usize) {
        debug_assert!(n <= Self::N && at + n <= to.len());
        // SAFETY: guaranteed by the caller. The hint saves the check of `store_part`.
        unsafe {
            if n == Self::N {
                self.store_at(to, at)
            } else {
                let part = to.get_unchecked_mut(at..at + n);
                assert_unchecked(part.len() < Self::N);
                self.store_part(part)
            }
        }
    }
}

impl<S, L: Lane<S>> Unchecked<S> for L {}
