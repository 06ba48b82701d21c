//! Arrays that begin at a cache line, so that no register straddles two lines.

use std::ops::{Deref, DerefMut};

use crate::pool::Pooled;
use crate::real::Real;

/// The bytes of a cache line and of the widest register.
const LINE: usize = 64;

/// An array of fixed length.
pub(crate) struct Aligned<R> {
    numbers: Vec<R>,
    first: usize,
    len: usize,
}

impl<R: Real> Aligned<R> {
    /// The numbers in a cache line, at least 1.
    pub(crate) const LINE: usize = match LINE.checked_div(size_of::<R>()) {
        Some(numbers @ 1..) => numbers,
        _ => 1,
    };

    pub(crate) fn zeros(len: usize) -> Self {
        let numbers = vec![R::zero(); len + LINE / size_of::<R>().min(LINE)];
        // Alignment only saves time. Some types cannot be aligned because of their size.
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

    /// Makes the array at least this long. Its values are then arbitrary.
    pub(crate) fn make_room(&mut self, len: usize) {
        if self.len < len {
            *self = Self::zeros(len);
        }
    }
}

impl<R: Real> Pooled for Aligned<R> {
    fn bytes(&self) -> usize {
        self.numbers.capacity() * size_of::<R>()
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
