//! Multiplies matrices that are stored in slices. The result is computed in tiles that stay in registers.
#![allow(unsafe_code)] // Unchecked loads: see `Unchecked::load_at`.

use crate::real::Real;
use crate::simd::{Lane, Unchecked, Vectorized, WIDEST};

/// A matrix in a slice. Its rows and columns need not be adjacent.
#[derive(Clone, Copy)]
pub struct Strided<'a, R> {
    /// The slice, from the first number of the matrix on.
    pub numbers: &'a [R],
    /// The distance in the slice from a number to the number below it.
    pub row: usize,
    /// The distance in the slice from a number to the next number in its row.
    pub column: usize,
}

impl<'a, R: Real> Strided<'a, R> {
    /// Creates a matrix whose rows are contiguous. `row` is the distance from one row to the next.
    #[inline(always)]
    pub fn by_rows(numbers: &'a [R], row: usize) -> Self {
        Self {
            numbers,
            row,
            column: 1,
        }
    }

    /// Returns the transpose of the matrix, in the same slice.
    #[inline(always)]
    pub fn transposed(self) -> Self {
        Self {
            row: self.column,
            column: self.row,
            ..self
        }
    }

    /// Returns whether all numbers in the first `size[0]` rows and `size[1]` columns are finite, including the
    /// derivatives that they carry. The numbers of a row must be adjacent.
    pub fn all_finite(self, size: [usize; 2]) -> bool {
        debug_assert_eq!(self.column, 1);
        R::vectorize(AllFinite(self, size))
    }
}

/// A product of matrices that is added to a result: `to += a b`. The numbers in the rows of `b` and `to` are adjacent.
pub struct Product<'a, R> {
    /// The first factor.
    pub a: Strided<'a, R>,
    /// The second factor.
    pub b: &'a [R],
    /// The distance in the slice from one row of `b` to the next.
    pub b_row: usize,
    /// The result.
    pub to: &'a mut [R],
    /// The distance in the slice from one row of the result to the next.
    pub to_row: usize,
    /// The number of rows of `a` and of the result.
    pub rows: usize,
    /// The number of columns of `a`, which is the number of rows of `b`.
    pub depth: usize,
    /// The number of columns of `b` and of the result.
    pub columns: usize,
}

/// The factor of a product that holds the cotangents: `a` or `b`. The other factor holds the partials.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Cotangents {
    /// The first factor.
    A,
    /// The second factor.
    B,
}

/// The number of rows in a tile.
const TILE: usize = 6;

impl<R: Real> Product<'_, R> {
    /// Adds the product to the result. Each number of the product is summed in a register, from first to last term.
    pub fn add(self) {
        R::vectorize(self);
    }

    /// Adds a product of cotangents and partials to the result. The terms are computed by [`Real::chain`], in which a
    /// zero cotangent stops an infinite partial. If all partials are `finite`, a plain product is enough.
    pub fn add_chained(self, cotangents: Cotangents, finite: bool) {
        if finite {
            return self.add();
        }
        for row in 0..self.rows {
            let to = &mut self.to[row * self.to_row..][..self.columns];
            for k in 0..self.depth {
                let a = self.a.numbers[row * self.a.row + k * self.a.column];
                for (to, &b) in to.iter_mut().zip(&self.b[k * self.b_row..]) {
                    *to = match cotangents {
                        Cotangents::A => R::chain_add(b, a, *to),
                        Cotangents::B => R::chain_add(a, b, *to),
                    };
                }
            }
        }
    }

    /// # Panics
    /// If a slice is too short for its matrix.
    #[inline(always)]
    fn check(&self) {
        let [row, k] = [self.rows - 1, self.depth - 1];
        let fits = row * self.a.row + k * self.a.column < self.a.numbers.len()
            && k * self.b_row + self.columns <= self.b.len()
            && row * self.to_row + self.columns <= self.to.len();
        assert!(
            fits,
            "a matrix of a product reaches past the end of its slice"
        );
    }

    /// Computes the columns of the product that fit into `H` registers, from column `column` on, for all rows. Adds
    /// them to the result. Only the first `last` lanes of the last register are used.
    ///
    /// # Safety
    /// The slices were checked and have these columns.
    #[inline(always)]
    unsafe fn add_columns<L: Lane<R>, const H: usize>(&mut self, column: usize, last: usize) {
        let mut row = 0;
        // SAFETY: the caller's promise, and the rows are within the matrix.
        unsafe {
            if const { fits_registers::<R, L>() } {
                while row + TILE <= self.rows {
                    self.add_tile::<L, TILE, H>(row, column, last);
                    row += TILE;
                }
                if row + 3 <= self.rows {
                    self.add_tile::<L, 3, H>(row, column, last);
                    row += 3;
                }
            }
            while row < self.rows {
                self.add_tile::<L, 1, H>(row, column, last);
                row += 1;
            }
        }
    }

    /// Computes the columns of the product that fit into `H` registers, for `T` rows. Adds them to the result.
    ///
    /// # Safety
    /// Like [`add_columns`](Self::add_columns), and the matrix must have these rows.
    #[inline(always)]
    unsafe fn add_tile<L: Lane<R>, const T: usize, const H: usize>(
        &mut self,
        row: usize,
        column: usize,
        last: usize,
    ) {
        // SAFETY, here and below: the caller's promise.
        let [sums] = unsafe {
            let factors = Factors {
                a: Strided {
                    numbers: self.a.numbers.get_unchecked(row * self.a.row..),
                    ..self.a
                },
                b: self.b.get_unchecked(column..),
                b_row: self.b_row,
                depth: self.depth,
            };
            factors.sums::<L, 1, T, H>(last)
        };
        for t in 0..T {
            for h in 0..H {
                let n = if h + 1 == H { last } else { L::N };
                let at = (row + t) * self.to_row + column + h * L::N;
                unsafe {
                    let sum = L::load_n(self.to, at, n) + sums[t][h];
                    sum.store_n(self.to, at, n);
                }
            }
        }
    }
}

/// Two matrices to be multiplied. The method [`sums`](Self::sums) is used by every product of matrices.
pub struct Factors<'a, R> {
    /// The first matrix.
    pub a: Strided<'a, R>,
    /// The second matrix. The numbers of each row are adjacent.
    pub b: &'a [R],
    /// The distance in the slice from one row of `b` to the next.
    pub b_row: usize,
    /// The number of columns of `a`, which is the number of rows of `b`.
    pub depth: usize,
}

impl<R: Real> Factors<'_, R> {
    /// Returns the product of `T` rows of `a` with the columns of `b` that fit into `H` registers. Only the first
    /// `last` lanes of the last register are used. Each number of the product is returned as `P` partial sums. Each
    /// partial sum adds every `P`-th term, so that consecutive additions do not wait for each other.
    ///
    /// # Safety
    /// The slices have these rows and columns.
    #[inline(always)]
    pub unsafe fn sums<L: Lane<R>, const P: usize, const T: usize, const H: usize>(
        &self,
        last: usize,
    ) -> [[[L; H]; T]; P] {
        let (mut sums, mut k) = ([[[L::zero(); H]; T]; P], 0);
        // SAFETY: the caller's promise, and the terms are within the depth.
        unsafe {
            if const { fits_registers::<R, L>() } {
                while k + P <= self.depth {
                    for p in 0..P {
                        self.add_term(k + p, last, &mut sums[p]);
                    }
                    k += P;
                }
                // With constant indices the sums stay in registers.
                for p in 0..P {
                    if k + p < self.depth {
                        self.add_term(k + p, last, &mut sums[p]);
                    }
                }
            } else {
                for k in 0..self.depth {
                    self.add_term(k, last, &mut sums[k % P]);
                }
            }
        }
        sums
    }

    /// # Safety
    /// The promises of [`sums`](Self::sums). Also, `k` must be less than the columns of `a` and the rows of `b`.
    #[inline(always)]
    unsafe fn add_term<L: Lane<R>, const T: usize, const H: usize>(
        &self,
        k: usize,
        last: usize,
        sums: &mut [[L; H]; T],
    ) {
        let mut b = [L::zero(); H];
        for h in 0..H {
            let n = if h + 1 == H { last } else { L::N };
            // SAFETY, here and below: the caller's promise.
            b[h] = unsafe { L::load_n(self.b, k * self.b_row + h * L::N, n) };
        }
        for t in 0..T {
            let at = t * self.a.row + k * self.a.column;
            let a = L::splat(unsafe { *self.a.numbers.get_unchecked(at) });
            for h in 0..H {
                sums[t][h] = b[h].fma(a, sums[t][h]);
            }
        }
    }
}

/// Returns whether a lane type fits into one register. Unrolled loops over larger ones only take longer to compile.
pub const fn fits_registers<R, L: Lane<R>>() -> bool {
    L::N > 1 || size_of::<R>() <= size_of::<f64>()
}

impl<R: Real> Vectorized<R> for Product<'_, R> {
    const USE_THE_ATTRIBUTE_KERNEL: () = ();
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(mut self) {
        if self.rows == 0 || self.depth == 0 {
            return;
        }
        self.check();
        let (columns, mut column) = (self.columns, 0);
        // SAFETY: the slices were checked, and the registers are within the columns.
        // If the registers are the widest (64 bytes), four columns of registers are computed at once: processors have
        // 32 of these registers, but only 16 narrower ones.
        unsafe {
            while const { size_of::<L>() == 64 } && column + 4 * L::N <= columns {
                self.add_columns::<L, 4>(column, L::N);
                column += 4 * L::N;
            }
            while column + 2 * L::N <= columns {
                self.add_columns::<L, 2>(column, L::N);
                column += 2 * L::N;
            }
            while column < columns {
                self.add_columns::<L, 1>(column, L::N.min(columns - column));
                column += L::N;
            }
        }
    }
}

/// Computes [`Strided::all_finite`] for the given matrix and size.
struct AllFinite<'a, R>(Strided<'a, R>, [usize; 2]);

impl<R: Real> Vectorized<R> for AllFinite<'_, R> {
    const USE_THE_ATTRIBUTE_KERNEL: () = ();
    type Output = bool;
    #[inline(always)]
    fn run<L: Lane<R>>(self) -> bool {
        let Self(matrix, [rows, columns]) = self;
        for row in 0..rows {
            let mut sum = L::zero();
            for part in matrix.numbers[row * matrix.row..][..columns].chunks(L::N) {
                let x = L::load_up_to(part);
                let same = x;
                // The difference is 0 unless a part of the number is infinite or NaN.
                sum += x - same;
            }
            if !sum.is_zero() {
                return false;
            }
        }
        true
    }
}

/// Writes the transpose of a matrix whose rows are contiguous.
pub struct Transpose<'a, R> {
    /// The matrix.
    pub from: &'a [R],
    /// The distance in the slice from one row to the next.
    pub from_row: usize,
    /// The number of rows of the matrix.
    pub rows: usize,
    /// The number of columns of the matrix.
    pub columns: usize,
    /// The transpose.
    pub to: &'a mut [R],
    /// The distance in the slice from one row of the transpose to the next.
    pub to_row: usize,
}

impl<R: Real> Vectorized<R> for Transpose<'_, R> {
    const USE_THE_ATTRIBUTE_KERNEL: () = ();
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        let Self {
            from,
            from_row,
            to,
            to_row,
            ..
        } = self;
        let whole = self.columns / L::N * L::N;
        for row in (0..self.rows).step_by(L::N) {
            let rows = L::N.min(self.rows - row);
            for column in (0..whole).step_by(L::N) {
                let mut lanes = [L::zero(); WIDEST];
                for i in 0..rows {
                    lanes[i] = L::load(&from[(row + i) * from_row + column..]);
                }
                let lanes = transposed(lanes);
                for j in 0..L::N {
                    lanes[j].store_up_to(&mut to[(column + j) * to_row + row..][..rows]);
                }
            }
            for column in whole..self.columns {
                for i in row..row + rows {
                    to[column * to_row + i] = from[i * from_row + column];
                }
            }
        }
    }
}

/// Transposes a square matrix in the first `N` registers: lane `j` of register `i` becomes lane `i` of register `j`.
#[inline(always)]
fn transposed<R: Real, L: Lane<R>>(mut lanes: [L; WIDEST]) -> [L; WIDEST] {
    // Each round is a perfect shuffle, which rotates the bits of the index `i N + j` by one. After log2 N rounds
    // the bits of `i` and `j` have changed places.
    for _ in 0..L::N.trailing_zeros() {
        let before = lanes;
        for k in 0..L::N / 2 {
            [lanes[2 * k], lanes[2 * k + 1]] = before[k].zip(before[k + L::N / 2]);
        }
    }
    lanes
}
