//! Numbers that begin at a cache line: whole registers then never straddle two lines.

use std::ops::{Deref, DerefMut};

use crate::real::Real;

/// Bytes of a cache line, and of the widest register.
const LINE: usize = 64;

/// A fixed number of zeros to begin with.
pub(crate) struct Aligned<R> {
    numbers: Vec<R>,
    first: usize,
    len: usize,
}

impl<R: Real> Aligned<R> {
    pub(crate) fn zeros(len: usize) -> Self {
        let numbers = vec![R::zero(); len + LINE / size_of::<R>().min(LINE)];
        // A hint that need not be met: where the type does not fit the line, nothing is gained.
        let first = numbers.as_ptr().align_offset(LINE);
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
