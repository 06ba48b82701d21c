//! A symmetric matrix that has numbers only near its diagonal, its factor, and the solution of linear equations.
//!
//! The matrix is stored by columns, from the diagonal down. The numbers of several starts are interleaved, as in
//! [arrays](super::super). Every number is computed by the same operations in the same order for any number of starts
//! and any register, so results are bit-identical.
#![allow(unsafe_code)] // Unchecked loads: see `Unchecked::load_at`.

use super::super::weighted::{each, sum};
use crate::real::Real;
use crate::simd::{Lane, Unchecked, WIDEST};

/// How many numbers of a column are computed together, in registers. It is the same for all registers and any number of
/// starts.
const PART: usize = WIDEST;

/// The shape of a banded matrix.
#[derive(Clone, Copy, Debug)]
pub(super) struct Band {
    /// The number of columns.
    pub(super) size: usize,
    /// The number of diagonals below the main diagonal.
    below: usize,
    /// The distance from the beginning of a column to that of the next one, in numbers of one start. After the last
    /// diagonal there are zeros, so that whole parts can be loaded, also from the row below.
    stride: usize,
}

/// Methods take the number of starts as an argument, because callers give it as a constant where it is 1.
impl Band {
    pub(super) fn new(size: usize, below: usize, starts: usize) -> Self {
        Self {
            size,
            below,
            stride: below + 2 + PART.div_ceil(starts),
        }
    }

    /// The number of numbers of the matrix, for one start. Zeros included.
    pub(super) fn len(self) -> usize {
        self.size * self.stride
    }

    /// The number of numbers of a right-hand side, for one start. After the last number there are zeros.
    pub(super) fn len_of_side(self) -> usize {
        self.size + self.stride
    }

    /// The index of an entry in or below the diagonal, in numbers of one start.
    pub(super) fn index(self, row: usize, column: usize) -> usize {
        column * self.stride + row - column
    }

    /// Replaces a row and its column by those of the unit matrix, for the start `s`.
    #[inline(always)]
    pub(super) fn set_unit<R: Real>(self, starts: usize, matrix: &mut [R], row: usize, s: usize) {
        for column in row.saturating_sub(self.below)..row {
            matrix[self.index(row, column) * starts + s] = R::zero();
        }
        for below in row + 1..self.size.min(row + self.below + 1) {
            matrix[self.index(below, row) * starts + s] = R::zero();
        }
        matrix[self.index(row, row) * starts + s] = R::one();
    }

    /// Replaces a symmetric positive definite matrix `A` by its factor: matrices `U` and `D` with `A = U D^-1 U'`, where `D`
    /// is the diagonal of the triangle `U`. The factor has `U` below the diagonal, and in it the inverses of the numbers of
    /// `D`.
    ///
    /// # Panics
    /// If the matrix is too short.
    #[inline(always)]
    pub(super) fn factorize<R: Real, L: Lane<R>>(self, starts: usize, matrix: &mut [R]) {
        let stride = self.stride * starts;
        let matrix = &mut matrix[..self.size * stride];
        // Two columns at a time, because both need the same columns before them.
        for k in (0..self.size).step_by(2) {
            let both = k + 1 < self.size;
            self.subtract_before::<R, L>(starts, matrix, k, both);
            let (first, second) = matrix[k * stride..].split_at_mut(stride);
            for s in 0..starts {
                first[s] = first[s].recip();
            }
            if both {
                self.subtract_column::<R, L>(starts, first, second);
                for s in 0..starts {
                    second[s] = second[s].recip();
                }
            }
        }
    }

    /// Subtracts the parts of all columns before column `k` from this column, and from the next one if `both` is true.
    #[inline(always)]
    fn subtract_before<R: Real, L: Lane<R>>(
        self,
        starts: usize,
        matrix: &mut [R],
        k: usize,
        both: bool,
    ) {
        let (below, stride, len) = (self.below, self.stride * starts, (self.below + 1) * starts);
        let (known, columns) = matrix.split_at_mut(k * stride);
        let registers = const { PART.div_ceil(L::N) };
        // A part of the columns stays in registers while the columns before it are subtracted.
        for part in (0..len).step_by(PART) {
            let mut rest = [[L::zero(); PART]; 2];
            // SAFETY: parts begin within the diagonals of a column, and after these a column has room for a part. Without a
            // second column, the first one is loaded twice.
            unsafe {
                let second = if both { stride } else { 0 };
                for r in 0..registers {
                    rest[0][r] = L::load_at(columns, part + r * L::N);
                    rest[1][r] = L::load_at(columns, second + part + r * L::N);
                }
                for j in k.saturating_sub(below - part / starts)..k {
                    let known = known.get_unchecked(j * stride..);
                    let row = (k - j) * starts;
                    let inverse = each::<R, L>(known, starts);
                    let next = row + starts;
                    let to_first = -(each::<R, L>(known.get_unchecked(row..), starts) * inverse);
                    let to_second = -(each::<R, L>(known.get_unchecked(next..), starts) * inverse);
                    for r in 0..registers {
                        let at = part + r * L::N;
                        rest[0][r] = to_first.fma(L::load_at(known, row + at), rest[0][r]);
                        rest[1][r] = to_second.fma(L::load_at(known, next + at), rest[1][r]);
                    }
                }
                for r in 0..registers {
                    rest[0][r].store_at(columns, part + r * L::N);
                    if both {
                        rest[1][r].store_at(columns, stride + part + r * L::N);
                    }
                }
            }
        }
    }

    /// Subtracts the part of a finished column from the next one.
    #[inline(always)]
    fn subtract_column<R: Real, L: Lane<R>>(self, starts: usize, column: &[R], next: &mut [R]) {
        let len = (self.below + 1) * starts;
        // SAFETY: registers begin within the diagonals of a column; after these a column has room for a part.
        unsafe {
            let inverse = each::<R, L>(column, starts);
            let factor = -(each::<R, L>(column.get_unchecked(starts..), starts) * inverse);
            for at in (0..len).step_by(L::N) {
                let rest = factor.fma(L::load_at(column, starts + at), L::load_at(next, at));
                rest.store_at(next, at);
            }
        }
    }

    /// Replaces the right-hand side `b` by the solution `x` of `A x = b`, with the factor of `A`.
    ///
    /// # Panics
    /// If the factor or the right-hand side is too short.
    #[inline(always)]
    pub(super) fn solve<R: Real, L: Lane<R>>(self, starts: usize, factor: &[R], b: &mut [R]) {
        let (stride, len) = (self.stride * starts, (self.below + 1) * starts);
        let factor = &factor[..self.size * stride];
        let b = &mut b[..self.len_of_side() * starts];
        // Two columns at a time: loads of what the columns before have just stored are slow.
        // SAFETY: registers begin within the diagonals of a column; after these a column has room for a part, and so has the
        // right-hand side.
        unsafe {
            for k in (0..self.size).step_by(2) {
                let first = factor.get_unchecked(k * stride..);
                let b = b.get_unchecked_mut(k * starts..);
                for s in 0..starts {
                    b[s] *= first[s];
                }
                let known = -each::<R, L>(b, starts);
                if k + 1 == self.size {
                    break;
                }
                let second = factor.get_unchecked((k + 1) * stride..);
                for s in 0..starts {
                    b[starts + s] = (b[starts + s] - b[s] * first[starts + s]) * second[s];
                }
                let next = -each::<R, L>(&b[starts..], starts);
                for at in (2 * starts..len + starts).step_by(L::N) {
                    let rest = known.fma(L::load_at(first, at), L::load_at(b, at));
                    next.fma(L::load_at(second, at - starts), rest)
                        .store_at(b, at);
                }
            }
            // The numbers after the last one have been subtracted from; they count as zero.
            b[self.size * starts..].fill(R::zero());
            for k in (0..self.size).step_by(2).rev() {
                let first = factor.get_unchecked(k * stride..(k + 1) * stride);
                let (b, later) = b.get_unchecked_mut(k * starts..).split_at_mut(2 * starts);
                let later = &later[..len - starts];
                let known = sum::<R, L>(&first[2 * starts..len + starts], Some(later), starts);
                let second = match k + 1 < self.size {
                    true => factor.get_unchecked((k + 1) * stride..(k + 2) * stride),
                    // The numbers after the last column's diagonal are zeros.
                    false => first,
                };
                let next = sum::<R, L>(&second[starts..len], Some(later), starts);
                for s in 0..starts {
                    if k + 1 < self.size {
                        b[starts + s] -= next[s] * second[s];
                    }
                    b[s] -= first[starts + s].fma(b[starts + s], known[s]) * first[s];
                }
            }
        }
    }
}
