//! A symmetric matrix that has numbers only near its diagonal, and the solution of linear equations.
//!
//! The matrix is stored by rows, from the diagonal on. The numbers of several starts are interleaved, as in
//! [arrays](super::super). Every number is computed by the same operations in the same order for any number of starts
//! and any register, so results are bit-identical.
#![allow(unsafe_code)] // Unchecked loads: see `Unchecked::load_at`.

use autodiff::Real;
use autodiff::internal::{Unchecked, WIDEST};
use autodiff::simd::Lane;

use crate::arrays::row::each;

/// The number of rows that are eliminated together, and of the columns of a tile. It is the same for all registers and
/// any number of starts.
const BLOCK: usize = 8;

/// The shape of a banded matrix.
///
/// Rows and columns are divided into blocks. A row has whole tiles, from the one with the diagonal to the last one
/// that is not zero. The last block is filled up with rows of the unit matrix.
#[derive(Clone, Copy, Debug)]
pub(super) struct Band {
    /// The number of rows.
    size: usize,
    /// The number of diagonals beside the main diagonal, on one side.
    beside: usize,
    /// The number of blocks of rows.
    blocks: usize,
    /// The number of tiles of a row.
    tiles: usize,
}

/// Methods take the number of starts as an argument, because callers give it as a constant where it is 1. In all of
/// them, `T` holds one number of each start: it is `R` for a single start, and otherwise a register. In `T`, products
/// are not fused with sums, because single numbers would be rounded differently from registers.
impl Band {
    pub(super) fn new(size: usize, beside: usize) -> Self {
        Self {
            size,
            beside,
            blocks: size.div_ceil(BLOCK),
            tiles: 1 + beside.div_ceil(BLOCK),
        }
    }

    /// How many numbers the matrix has for one start, with zeros.
    pub(super) fn len(self) -> usize {
        self.blocks * BLOCK * self.stride()
    }

    /// The number of numbers of a right-hand side, for one start. The last block is filled up.
    pub(super) fn len_of_side(self) -> usize {
        self.blocks * BLOCK
    }

    /// The distance from the beginning of a row to that of the next one, in numbers of one start.
    #[inline(always)]
    fn stride(self) -> usize {
        self.tiles * BLOCK
    }

    /// The index of an entry at or after the diagonal, in numbers of one start.
    #[inline(always)]
    pub(super) fn index(self, row: usize, column: usize) -> usize {
        row * self.stride() + column - row / BLOCK * BLOCK
    }

    /// Replaces all numbers of a matrix by zeros, and the rows after the last one by those of the unit matrix.
    #[inline(always)]
    pub(super) fn clear<R: Real>(self, starts: usize, matrix: &mut [R]) {
        matrix.fill(R::zero());
        for row in self.size..self.blocks * BLOCK {
            matrix[self.index(row, row) * starts..][..starts].fill(R::one());
        }
    }

    /// Replaces a row and its column by those of the unit matrix, for the start `s`.
    #[inline(always)]
    pub(super) fn set_unit<R: Real>(self, starts: usize, matrix: &mut [R], row: usize, s: usize) {
        for before in row.saturating_sub(self.beside)..row {
            matrix[self.index(before, row) * starts + s] = R::zero();
        }
        for column in row + 1..self.size.min(row + self.beside + 1) {
            matrix[self.index(row, column) * starts + s] = R::zero();
        }
        matrix[self.index(row, row) * starts + s] = R::one();
    }

    /// The number of numbers of the blocks of rows that elimination still needs, for one start.
    pub(super) fn len_of_recent(self) -> usize {
        self.tiles * BLOCK * self.stride()
    }

    /// Replaces the right-hand side `b` by the solution `x` of `A x = b`, with a symmetric positive definite matrix `A`.
    ///
    /// With the factor `A = U' D^-1 U`, where `D` is the diagonal of the triangle `U`, the matrix becomes `D^-1 U`, with
    /// `D^-1` as its diagonal. Rows of `U` are needed for a few blocks only; they are kept in `recent`, so that it stays in
    /// the cache.
    ///
    /// # Panics
    /// If one of the slices is too short.
    #[inline(always)]
    pub(super) fn solve<R: Real, L: Lane<R>, T: Lane<R>>(
        self,
        starts: usize,
        matrix: &mut [R],
        recent: &mut [R],
        b: &mut [R],
    ) {
        let matrix = &mut matrix[..self.len() * starts];
        let recent = &mut recent[..self.len_of_recent() * starts];
        let b = &mut b[..self.len_of_side() * starts];
        b[self.size * starts..].fill(R::zero());
        // SAFETY: the lengths were checked. `T` has room for all starts.
        unsafe {
            for block in 0..self.blocks {
                self.subtract_from_side::<R, L, T>(starts, recent, b, block);
                self.eliminate_diagonal::<R, L, T>(starts, matrix, recent, b, block);
                for tile in 1..self.tiles.min(self.blocks - block) {
                    self.eliminate_tile::<R, L, T>(starts, matrix, recent, [block, tile]);
                }
            }
            for block in (0..self.blocks).rev() {
                self.substitute_back::<R, T>(starts, matrix, b, block);
            }
        }
    }

    /// The index of a row in the rows of recent blocks, in numbers of one start.
    #[inline(always)]
    fn recent(self, block: usize, row: usize) -> usize {
        (block % self.tiles * BLOCK + row) * self.stride()
    }

    /// Subtracts the parts of all blocks before from a block of the right-hand side.
    ///
    /// # Safety
    /// The slices must be as long as in [`solve`](Self::solve).
    #[inline(always)]
    unsafe fn subtract_from_side<R: Real, L: Lane<R>, T: Lane<R>>(
        self,
        starts: usize,
        recent: &[R],
        b: &mut [R],
        block: usize,
    ) {
        let n = const { used::<R, L, T>() };
        for at in (0..BLOCK * starts).step_by(n) {
            let place = block * BLOCK * starts + at;
            // SAFETY: guaranteed by the caller.
            unsafe {
                let mut rest = L::load_n(b, place, n);
                for before in (1..=block.min(self.tiles - 1)).rev() {
                    let first = (before * BLOCK).saturating_sub(self.beside);
                    for j in first..BLOCK {
                        let known = self.recent(block - before, j) + before * BLOCK;
                        let factor: L = each_at(b, (block - before) * BLOCK + j, starts);
                        rest = (-factor).fma(L::load_n(recent, known * starts + at, n), rest);
                    }
                }
                rest.store_n(b, place, n);
            }
        }
    }

    /// Returns numbers of a tile minus the parts of all blocks before: a register for each row, which begins at the
    /// number `at` of the tile's row.
    ///
    /// # Safety
    /// The slices must be as long as in [`solve`](Self::solve).
    #[inline(always)]
    unsafe fn rest<R: Real, L: Lane<R>, T: Lane<R>>(
        self,
        starts: usize,
        matrix: &[R],
        recent: &[R],
        [block, tile]: [usize; 2],
        at: usize,
    ) -> [L; BLOCK] {
        let (stride, n) = (self.stride(), const { used::<R, L, T>() });
        let mut rest = [L::zero(); BLOCK];
        // SAFETY: guaranteed by the caller.
        unsafe {
            for r in 0..BLOCK {
                let row = (block * BLOCK + r) * stride + tile * BLOCK;
                rest[r] = L::load_n(matrix, row * starts + at, n);
            }
            for before in (1..=block.min(self.tiles - 1 - tile)).rev() {
                // The rows before do not reach the tile.
                let first = ((before + tile) * BLOCK).saturating_sub(self.beside);
                for j in first..BLOCK {
                    let known = self.recent(block - before, j) + (before + tile) * BLOCK;
                    let known = L::load_n(recent, known * starts + at, n);
                    let factors = ((block - before) * BLOCK + j) * stride + before * BLOCK;
                    let factors = matrix.get_unchecked(factors * starts..);
                    for r in 0..BLOCK {
                        let factor: L = each_at(factors, r, starts);
                        rest[r] = (-factor).fma(known, rest[r]);
                    }
                }
            }
        }
        rest
    }

    /// Eliminates the unknowns of a block within its rows and columns, and from the right-hand side.
    ///
    /// # Safety
    /// The slices must be as long as in [`solve`](Self::solve).
    #[inline(always)]
    unsafe fn eliminate_diagonal<R: Real, L: Lane<R>, T: Lane<R>>(
        self,
        starts: usize,
        matrix: &mut [R],
        recent: &mut [R],
        b: &mut [R],
        block: usize,
    ) {
        let n = const { used::<R, L, T>() };
        let (len, stride) = (BLOCK * starts, self.stride() * starts);
        // SAFETY: guaranteed by the caller.
        unsafe {
            for at in (0..len).step_by(n) {
                let rest = self.rest::<R, L, T>(starts, matrix, recent, [block, 0], at);
                for r in 0..BLOCK {
                    rest[r].store_n(recent, self.recent(block, r) * starts + at, n);
                }
            }
            let rows = recent.get_unchecked_mut(self.recent(block, 0) * starts..);
            let factors = matrix.get_unchecked_mut(block * BLOCK * stride..);
            let side = b.get_unchecked_mut(block * len..);
            let mut solved = [T::zero(); BLOCK];
            let mut next = T::load_n(rows, 0, starts).recip();
            let mut tile = Tile {
                starts,
                stride,
                rows,
                factors,
                side,
            };
            // One call for each unknown, because the compiler does not unroll nested loops.
            (solved[0], next) = tile.eliminate::<L, T, 0>(next);
            (solved[1], next) = tile.eliminate::<L, T, 1>(next);
            (solved[2], next) = tile.eliminate::<L, T, 2>(next);
            (solved[3], next) = tile.eliminate::<L, T, 3>(next);
            (solved[4], next) = tile.eliminate::<L, T, 4>(next);
            (solved[5], next) = tile.eliminate::<L, T, 5>(next);
            (solved[6], next) = tile.eliminate::<L, T, 6>(next);
            (solved[7], _) = tile.eliminate::<L, T, 7>(next);
            for p in 0..BLOCK {
                solved[p].store_n(side, p * starts, starts);
            }
        }
    }

    /// Eliminates the unknowns of a block from its rows of a tile after the diagonal.
    ///
    /// # Safety
    /// The slices must be as long as in [`solve`](Self::solve).
    #[inline(always)]
    unsafe fn eliminate_tile<R: Real, L: Lane<R>, T: Lane<R>>(
        self,
        starts: usize,
        matrix: &mut [R],
        recent: &mut [R],
        [block, tile]: [usize; 2],
    ) {
        let (stride, n) = (self.stride(), const { used::<R, L, T>() });
        for at in (0..BLOCK * starts).step_by(n) {
            // SAFETY: guaranteed by the caller.
            unsafe {
                let mut rest = self.rest::<R, L, T>(starts, matrix, recent, [block, tile], at);
                for p in 0..BLOCK {
                    let row = (block * BLOCK + p) * stride * starts;
                    let factors = matrix.get_unchecked_mut(row..);
                    for r in p + 1..BLOCK {
                        let factor: L = each_at(factors, r, starts);
                        rest[r] = (-factor).fma(rest[p], rest[r]);
                    }
                    let inverse: L = each_at(factors, p, starts);
                    (rest[p] * inverse).store_n(factors, tile * BLOCK * starts + at, n);
                    let known = self.recent(block, p) + tile * BLOCK;
                    rest[p].store_n(recent, known * starts + at, n);
                }
            }
        }
    }

    /// Replaces a block of the right-hand side by the solution, when all blocks after it are solved.
    ///
    /// # Safety
    /// The slices must be as long as in [`solve`](Self::solve).
    #[inline(always)]
    unsafe fn substitute_back<R: Real, T: Lane<R>>(
        self,
        starts: usize,
        matrix: &[R],
        b: &mut [R],
        block: usize,
    ) {
        let (first, stride) = (block * BLOCK, self.stride());
        let columns = stride.min(self.blocks * BLOCK - first);
        // SAFETY: guaranteed by the caller.
        unsafe {
            let matrix = matrix.get_unchecked(first * stride * starts..);
            let b = b.get_unchecked_mut(first * starts..);
            let mut x = [T::zero(); BLOCK];
            for r in 0..BLOCK {
                x[r] = T::load_n(b, r * starts, starts);
            }
            for c in (BLOCK..columns).rev() {
                let known = T::load_n(b, c * starts, starts);
                for r in 0..BLOCK {
                    x[r] -= known * T::load_n(matrix, (r * stride + c) * starts, starts);
                }
            }
            for c in (0..BLOCK).rev() {
                let known = x[c];
                for r in 0..BLOCK {
                    if r < c {
                        x[r] -= known * T::load_n(matrix, (r * stride + c) * starts, starts);
                    }
                }
                known.store_n(b, c * starts, starts);
            }
        }
    }
}

/// The number of lanes of `L` that are used: all, unless a row of a tile is shorter.
const fn used<R: Real, L: Lane<R>, T: Lane<R>>() -> usize {
    if T::N == 1 && L::N > BLOCK {
        BLOCK
    } else {
        L::N
    }
}

/// The tile with the diagonal of a block, while the unknowns of the block are eliminated.
struct Tile<'a, R> {
    starts: usize,
    /// The distance between rows.
    stride: usize,
    /// The rows of `U`.
    rows: &'a mut [R],
    /// The rows of `D^-1 U`, with `D^-1` as its diagonal.
    factors: &'a mut [R],
    /// The right-hand side. Its numbers up to the last eliminated unknown are meaningless.
    side: &'a mut [R],
}

impl<R: Real> Tile<'_, R> {
    /// Eliminates unknown `P` from the rows below and from the right-hand side, with the inverse of its number in the
    /// diagonal. Returns its number of `D^-1 U x` and the inverse for the next unknown.
    ///
    /// # Safety
    /// The slices must have the rows of the tile.
    #[inline(always)]
    unsafe fn eliminate<L: Lane<R>, T: Lane<R>, const P: usize>(&mut self, inverse: T) -> (T, T) {
        let Self {
            starts,
            stride,
            ref mut rows,
            ref mut factors,
            ref mut side,
        } = *self;
        let (n, len, row) = (const { used::<R, L, T>() }, BLOCK * starts, P * stride);
        // SAFETY: guaranteed by the caller.
        unsafe {
            let mut next = T::zero();
            if P + 1 < BLOCK {
                // The next inverse must not wait until this unknown is eliminated from all rows.
                let diagonal = row + (P + 1) * starts;
                let beside = T::load_n(rows, diagonal, starts);
                let diagonal = T::load_n(rows, diagonal + stride, starts);
                next = (diagonal - beside * inverse * beside).recip();
            }
            let solved = T::load_n(side, P * starts, starts) * inverse;
            let (each_inverse, each_solved): (L, L) =
                (spread(inverse, starts), spread(solved, starts));
            for at in (0..len).step_by(n) {
                let known = L::load_n(rows, row + at, n);
                (known * each_inverse).store_n(factors, row + at, n);
                let rest = L::load_n(side, at, n);
                (-each_solved).fma(known, rest).store_n(side, at, n);
            }
            for r in P + 1..BLOCK {
                let factor: L = each_at(factors.get_unchecked(row..), r, starts);
                // Numbers before the diagonal are not needed.
                for at in (r * starts / n * n..len).step_by(n) {
                    let known = L::load_n(rows, row + at, n);
                    let rest = L::load_n(rows, r * stride + at, n);
                    (-factor).fma(known, rest).store_n(rows, r * stride + at, n);
                }
            }
            inverse.store_n(factors, row + P * starts, starts);
            (solved, next)
        }
    }
}

/// Repeats the numbers of a register that holds one number of each start, to fill a register.
#[inline(always)]
fn spread<R: Real, T: Lane<R>, L: Lane<R>>(numbers: T, starts: usize) -> L {
    let mut all = [R::zero(); WIDEST];
    numbers.store(&mut all);
    each(&all, starts)
}

/// Loads number `k` of each start. The numbers repeat, to fill a register.
///
/// # Safety
/// The slice must have number `k` of each start.
#[inline(always)]
unsafe fn each_at<R: Real, L: Lane<R>>(numbers: &[R], k: usize, starts: usize) -> L {
    // SAFETY: guaranteed by the caller.
    each(
        unsafe { numbers.get_unchecked(k * starts..(k + 1) * starts) },
        starts,
    )
}
