//! Numbers that begin at a cache line.

use std::ops::{Deref, DerefMut};

use autodiff::Real;

/// Bytes of a cache line.
const LINE: usize = 64;

/// A slice whose first number is the first of a cache line: no register of it lies in two.
pub struct Buffer<R> {
    all: Vec<R>,
    first: usize,
    len: usize,
}

impl<R: Real> Default for Buffer<R> {
    fn default() -> Self {
        Self::zeros(0)
    }
}

impl<R: Real> Buffer<R> {
    pub(super) fn zeros(len: usize) -> Self {
        let all = vec![R::zero(); len + LINE / size_of::<R>()];
        Self {
            first: all.as_ptr().align_offset(LINE),
            all,
            len,
        }
    }

    /// Makes a shorter one as long as this; what it then holds is anything.
    pub(super) fn reserve(&mut self, len: usize) {
        if len > self.len {
            *self = Self::zeros(len);
        }
    }
}

impl<R> Deref for Buffer<R> {
    type Target = [R];
    #[inline(always)]
    fn deref(&self) -> &[R] {
        &self.all[self.first..][..self.len]
    }
}

impl<R> DerefMut for Buffer<R> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [R] {
        &mut self.all[self.first..][..self.len]
    }
}

/// Asks for the numbers to be brought near, one line after the other.
#[inline(always)]
#[allow(unsafe_code)] // The processor does not foresee rows read backwards.
pub(super) fn prefetch<R>(soon: &[R]) {
    #[cfg(target_arch = "x86_64")]
    for line in soon.chunks(LINE / size_of::<R>()) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: a hint, about memory that is there.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(line.as_ptr().cast()) };
    }
}
