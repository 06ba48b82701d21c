//! Sums of outer products: the cotangents of a layer's weights.
//!
//! The factors of several steps are collected and then added as one matrix product. So the memory of the
//! gradient is touched only once in [`BATCH`] steps.

use super::aligned::Aligned;
use crate::product::{Product, Strided, Transpose};
use crate::real::Real;
use crate::simd::lanes;

/// The number of outer products that are added together, one for each step and start.
const BATCH: usize = 16;

/// Inputs and output cotangents of the last steps, one start after the other.
pub(super) struct Pending<R> {
    x: Vec<R>,
    /// Padded to whole registers. With one start, the cotangents of the current step follow the last ones.
    y_bar: Aligned<R>,
    /// With several starts: the interleaved cotangents of the current step.
    interleaved: Aligned<R>,
    starts: usize,
    rows: usize,
    columns: usize,
    /// The distance from one start's cotangents to the next's.
    stride: usize,
    /// The number of outer products that are kept.
    len: usize,
}

impl<R: Real> Pending<R> {
    pub(super) fn new(starts: usize, rows: usize, columns: usize) -> Self {
        let numbers = if starts == 1 { 0 } else { rows * starts };
        let stride = rows.next_multiple_of(lanes::<R>());
        Self {
            x: vec![R::zero(); BATCH * columns],
            // Both have room for a register past the last.
            y_bar: Aligned::zeros(BATCH * stride + lanes::<R>()),
            interleaved: Aligned::zeros(numbers + lanes::<R>()),
            starts,
            rows,
            columns,
            stride,
            len: 0,
        }
    }

    /// The cotangents of the current step.
    pub(super) fn current(&self) -> &[R] {
        match self.starts {
            1 => &self.y_bar[self.len * self.stride..][..self.rows],
            starts => &self.interleaved[..self.rows * starts],
        }
    }

    /// The place for the cotangents of the current step, with room for a register past the last.
    pub(super) fn current_mut(&mut self) -> &mut [R] {
        match self.starts {
            1 => &mut self.y_bar[self.len * self.stride..],
            _ => &mut self.interleaved,
        }
    }

    /// Keeps the current step, whose inputs are `x`. Returns whether the batch is full.
    pub(super) fn keep(&mut self, x: &[R]) -> bool {
        let (starts, stride, columns) = (self.starts, self.stride, self.columns);
        let to = &mut self.x[self.len * columns..][..columns * starts];
        if starts == 1 {
            to.copy_from_slice(x);
        } else {
            R::vectorize(Transpose {
                from: x,
                from_row: starts,
                rows: columns,
                columns: starts,
                to,
                to_row: columns,
            });
            let to = &mut self.y_bar[self.len * stride..][..stride * starts];
            R::vectorize(Transpose {
                from: &self.interleaved,
                from_row: starts,
                rows: self.rows,
                columns: starts,
                to,
                to_row: stride,
            });
        }
        self.len += starts;
        self.len == BATCH
    }

    /// Adds the batch's sum of `y_bar x^T` to a matrix and empties the batch.
    pub(super) fn flush(&mut self, to: &mut [R]) {
        let product = Product {
            a: Strided::by_rows(&self.y_bar, self.stride).transposed(),
            b: &self.x,
            b_row: self.columns,
            to,
            to_row: self.columns,
            rows: self.rows,
            depth: self.len,
            columns: self.columns,
        };
        product.add();
        self.clear();
    }

    pub(super) fn clear(&mut self) {
        self.len = 0;
    }
}
