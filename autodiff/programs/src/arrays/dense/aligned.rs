//! Arrays that begin at the start of a cache line, so that no register straddles two lines.

use std::ops::{Deref, DerefMut};

use autodiff::Real;
use autodiff::internal::pool::Pooled;

/// The size of a cache line in bytes. The widest registers have the same size.
const LINE: usize = 64;

/// An array of fixed length that begins at the start of a cache line, if possible.
pub(crate) struct Aligned<R> {
    numbers: Vec<R>,
    first: usize,
    len: usize,
}

impl<R: Real> Aligned<R> {
    /// How many numbers fit into a cache line; at least 1.
    pub(crate) const LINE: usize = match LINE.checked_div(size_of::<R>()) {
        Some(numbers @ 1..) => numbers,
        _ => 1,
    };

    pub(crate) fn zeros(len: usize) -> Self {
        let numbers = vec![R::zero(); len + LINE / size_of::<R>().min(LINE)];
        // Alignment only saves time, so it is fine that types of some sizes cannot be aligned.
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

    /// Makes sure that the array has at least `len` numbers. If it is shorter, it is replaced by zeros.
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
