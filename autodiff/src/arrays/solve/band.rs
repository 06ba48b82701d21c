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
    /// diagonal there are zeros, so that whole parts can be loaded.
    stride: usize,
}

/// Methods take the number of starts as an argument, because callers give it as a constant where it is 1.
impl Band {
    pub(super) fn new(size: usize, below: usize, starts: usize) -> Self {
        Self {
            size,
            below,
            stride: below + 1 + PART.div_ceil(starts),
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

    /// Replaces a symmetric positive definite matrix `A` by its factor: matrices `U` and `D` with `A = U D^-1 U'`, where `D`
    /// is the diagonal of the triangle `U`. The factor has `U` below the diagonal, and in it the inverses of the numbers of
    /// `D`.
    ///
    /// # Panics
    /// If the matrix is too short.
    #[inline(always)]
    pub(super) fn factorize<R: Real, L: Lane<R>>(self, starts: usize, matrix: &mut [R]) {
        let (below, stride, len) = (self.below, self.stride * starts, (self.below + 1) * starts);
        let matrix = &mut matrix[..self.size * stride];
        for k in 0..self.size {
            let (known, column) = matrix.split_at_mut(k * stride);
            // A part of the column stays in registers while the columns before it are subtracted.
            let mut part = 0;
            while part < len {
                let mut rest = [L::zero(); PART];
                let registers = const { PART.div_ceil(L::N) };
                // SAFETY: parts begin within the diagonals of a column, and after these a column has room for a part.
                unsafe {
                    for r in 0..registers {
                        rest[r] = L::load_at(column, part + r * L::N);
                    }
                    for j in k.saturating_sub(below - part / starts)..k {
                        let known = known.get_unchecked(j * stride..);
                        let row = (k - j) * starts;
                        let inverse = each::<R, L>(known, starts);
                        let factor = -(each::<R, L>(known.get_unchecked(row..), starts) * inverse);
                        for r in 0..registers {
                            let of_known = L::load_at(known, row + part + r * L::N);
                            rest[r] = factor.fma(of_known, rest[r]);
                        }
                    }
                    for r in 0..registers {
                        rest[r].store_at(column, part + r * L::N);
                    }
                }
                part += PART;
            }
            for s in 0..starts {
                column[s] = column[s].recip();
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
        // SAFETY: registers begin within the diagonals of a column; after these a column has room for a register, and so
        // has the right-hand side.
        unsafe {
            for k in 0..self.size {
                let column = factor.get_unchecked(k * stride..(k + 1) * stride);
                let b = b.get_unchecked_mut(k * starts..k * starts + stride);
                for s in 0..starts {
                    b[s] *= column[s];
                }
                let known = -each::<R, L>(b, starts);
                let mut at = starts;
                while at < len {
                    let rest = known.fma(L::load_at(column, at), L::load_at(b, at));
                    rest.store_at(b, at);
                    at += L::N;
                }
            }
            // The numbers after the last one have been subtracted from; they count as zero.
            b[self.size * starts..].fill(R::zero());
            for k in (0..self.size).rev() {
                let column = factor.get_unchecked(k * stride..(k + 1) * stride);
                let (b, later) = b.get_unchecked_mut(k * starts..).split_at_mut(starts);
                let known = sum::<R, L>(&column[starts..len], Some(&later[..len - starts]), starts);
                for s in 0..starts {
                    b[s] -= known[s] * column[s];
                }
            }
        }
    }
}
