//! Numbers that begin at a cache line: whole registers then never straddle two lines.

use std::ops::{Deref, DerefMut};

use crate::real::Real;

/// Bytes of a cache line, and of the widest register.
const LINE: usize = 64;
/// Bytes of a page.
const PAGE: usize = 4096;

/// A fixed number of zeros to begin with.
pub(crate) struct Aligned<R> {
    numbers: Vec<R>,
    first: usize,
    len: usize,
}

impl<R: Real> Aligned<R> {
    /// Numbers of a cache line.
    pub(crate) const LINE: usize = match LINE.checked_div(size_of::<R>()) {
        Some(numbers @ 1..) => numbers,
        _ => 1,
    };

    pub(crate) fn zeros(len: usize) -> Self {
        Self::zeros_to(LINE, len)
    }

    /// From the start of a page on, where the first cache begins with its sets.
    pub(crate) fn to_pages(len: usize) -> Self {
        Self::zeros_to(PAGE, len)
    }

    fn zeros_to(bytes: usize, len: usize) -> Self {
        let numbers = vec![R::zero(); len + bytes / size_of::<R>().min(bytes)];
        // A hint that need not be met: where the type does not fit, nothing is gained.
        let first = numbers.as_ptr().align_offset(bytes);
        let first = if first <= numbers.len() - len {
            first
        } else {
            0
        };
        Self {
            numbers,
            first,
            len,
        }
    }
}

impl<R> Deref for Aligned<R> {
    type Target = [R];
    #[inline(always)]
    fn deref(&self) -> &[R] {
        &self.numbers[self.first..self.first + self.len]
    }
}

impl<R> DerefMut for Aligned<R> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [R] {
        &mut self.numbers[self.first..self.first + self.len]
    }
}
