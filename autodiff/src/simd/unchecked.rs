//! Loads and stores without bounds checks, for loops whose bounds were checked once.

use crate::real::Lane;

/// Loads and stores of registers without bounds checks.
pub(crate) trait Unchecked<S>: Lane<S> {
    /// [`load`](Lane::load) from place `at`, without a check.
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
    /// [`store`](Lane::store) from place `at`, without a check.
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
    /// Loads `n` scalars from place `at`, followed by zeros, without a check.
    ///
    /// # Safety
    /// The slice holds at least `at + n` scalars, and `n` is at most `N`.
    #[allow(unsafe_code)] // As above.
    #[inline(always)]
    unsafe fn load_n(from: &[S], at: usize, n: usize) -> Self {
        debug_assert!(n <= Self::N && at + n <= from.len());
        // SAFETY: the caller's promise.
        unsafe {
            if n == Self::N {
                Self::load_at(from, at)
            } else {
                Self::load_part(from.get_unchecked(at..at + n))
            }
        }
    }
    /// Writes the first `n` lanes from place `at`, without a check.
    ///
    /// # Safety
    /// As for [`load_n`](Unchecked::load_n).
    #[allow(unsafe_code)] // As above.
    #[inline(always)]
    unsafe fn store_n(self, to: &mut [S], at: usize, n: usize) {
        debug_assert!(n <= Self::N && at + n <= to.len());
        // SAFETY: the caller's promise.
        unsafe {
            if n == Self::N {
                self.store_at(to, at)
            } else {
                self.store_part(to.get_unchecked_mut(at..at + n))
            }
        }
    }
}

impl<S, L: Lane<S>> Unchecked<S> for L {}
