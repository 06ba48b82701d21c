//! Matrices times vectors, and outer products added up.

use autodiff::Real;
use autodiff::simd::Lane;

/// Steps whose outer products are added up as one matrix product.
pub(super) const BATCH: usize = 16;

/// A matrix by blocks of rows, and each block by columns: `V` registers of rows are multiplied at
/// once, in `C` sums that do not wait for one another, and of each the hyperbolic tangent taken if
/// that is wanted.
#[inline(always)]
pub(super) fn product<R: Real, L: Lane<R>, const V: usize, const C: usize, const TANH: bool>(
    weights: &[R],
    x: &[R],
    (start, out): (&[R], &mut [R]),
) {
    let rows = V * L::N;
    let blocks = weights.chunks_exact(rows * x.len());
    let places = start.chunks_exact(rows).zip(out.chunks_exact_mut(rows));
    for (weights, (start, out)) in blocks.zip(places) {
        let mut sums = [[L::zero(); V]; C];
        for v in 0..V {
            sums[0][v] = L::load(&start[v * L::N..]);
        }
        let (columns, xs) = (weights.chunks_exact(rows * C), x.chunks_exact(C));
        let rest = columns.remainder().chunks_exact(rows).zip(xs.remainder());
        for (columns, xs) in columns.zip(xs) {
            for c in 0..C {
                add::<R, L, V>(&mut sums[c], &columns[c * rows..][..rows], xs[c]);
            }
        }
        for (column, &x) in rest {
            add::<R, L, V>(&mut sums[0], column, x);
        }
        let mut all = sums[0];
        for sum in &sums[1..] {
            for v in 0..V {
                all[v] += sum[v];
            }
        }
        if TANH {
            all = L::tanh_each(all);
        }
        for v in 0..V {
            all[v].store(&mut out[v * L::N..]);
        }
    }
}

/// Adds a column's share of a product.
#[inline(always)]
fn add<R: Real, L: Lane<R>, const V: usize>(sum: &mut [L; V], column: &[R], x: R) {
    let x = L::splat(x);
    for v in 0..V {
        sum[v] = L::load(&column[v * L::N..]).fma(x, sum[v]);
    }
}

/// Pairs of vectors, one for each step of a batch.
pub(super) struct Pairs<'a, R> {
    /// Slices that begin with the first vector of one kind, and how far the next is from it.
    pub(super) rows: (&'a [R], usize),
    pub(super) columns: (&'a [R], usize),
    pub(super) steps: usize,
}

/// Adds outer products to a matrix of columns of a height: `V` registers of rows and `K` columns
/// at once.
#[inline(always)]
pub(super) fn outer<R: Real, L: Lane<R>, const V: usize, const K: usize>(
    (matrix, height): (&mut [R], usize),
    pairs: Pairs<R>,
) {
    let ((rows, row_stride), (columns, column_stride)) = (pairs.rows, pairs.columns);
    for (block, matrix) in matrix.chunks_exact_mut(K * height).enumerate() {
        for at in (0..height).step_by(V * L::N) {
            let mut sums = [[L::zero(); V]; K];
            for k in 0..K {
                for v in 0..V {
                    sums[k][v] = L::load(&matrix[k * height + at + v * L::N..]);
                }
            }
            for step in 0..pairs.steps {
                let row = &rows[step * row_stride + at..][..V * L::N];
                let column = &columns[step * column_stride + block * K..][..K];
                for k in 0..K {
                    add::<R, L, V>(&mut sums[k], row, column[k]);
                }
            }
            for k in 0..K {
                for v in 0..V {
                    sums[k][v].store(&mut matrix[k * height + at + v * L::N..]);
                }
            }
        }
    }
}
