//! Dense layers. The reverse tape records a layer as one call, with an entry for each output, however many operations the
//! layer does.

use crate::parts::SumByParts;
use crate::product::{Cotangents, Product, Strided, Transpose};
use crate::real::{Fused, Real};

/// Returns the outputs of a dense layer, `weights * x + biases`. On the tape each output is one entry. `weights` is a
/// matrix, row by row.
///
/// ```
/// use autodiff::{Var, fused::dense, gradient};
///
/// let weights = [1.0, 2.0, 3.0, 4.0];
/// let by_x = gradient(
///     |x: &[Var<f64>]| {
///         let y = dense(&weights.map(Var::constant), x, &[Var::constant(0.5); 2]);
///         y[0] * y[1]
///     },
///     &[1.0, -1.0],
/// );
/// assert_eq!(by_x, [-2.0, -3.0]); // y = (-0.5, -0.5) times the columns' sums (4, 6)
/// ```
///
/// # Panics
/// If the number of weights is not `biases.len() * x.len()`.
#[track_caller]
pub fn dense<R: Real>(weights: &[R], x: &[R], biases: &[R]) -> Vec<R> {
    assert_eq!(
        weights.len(),
        x.len() * biases.len(),
        "the number of weights of `dense` must be `biases.len() * x.len()`"
    );
    R::fused(Dense { vectors: 1 }, &[weights, x, biases])
}

/// Applies a [`dense`] layer to each vector of a mini-batch. On the tape this is one call, with an entry for each output.
/// `x` holds the input vectors one after the other, and the outputs are in the same order. The forward and the reverse
/// computation are matrix products.
///
/// ```
/// use autodiff::fused::{dense, dense_batch};
///
/// let (weights, biases) = ([1.0, 2.0, 3.0, 4.0], [0.5, -0.5]);
/// let y = dense_batch(&weights, &[1.0, -1.0, 2.0, 0.0], &biases);
/// assert_eq!(y[..2], dense(&weights, &[1.0, -1.0], &biases));
/// assert_eq!(y[2..], dense(&weights, &[2.0, 0.0], &biases));
/// ```
///
/// # Panics
/// If there is no bias, if the number of weights is not a multiple of the biases, or if `x` is not a whole number
/// of vectors.
#[track_caller]
pub fn dense_batch<R: Real>(weights: &[R], x: &[R], biases: &[R]) -> Vec<R> {
    let columns = weights.len().checked_div(biases.len()).unwrap_or(0);
    assert!(
        columns > 0 && weights.len() == columns * biases.len() && x.len().is_multiple_of(columns),
        "`dense_batch` cannot split {} weights, {} numbers in `x` and {} biases into a layer and its input \
         vectors: it needs `biases.len() * n` weights, where `n` is the length of a vector, and a multiple \
         of `n` numbers in `x`",
        weights.len(),
        x.len(),
        biases.len()
    );
    let vectors = x.len() / columns;
    R::fused(Dense { vectors }, &[weights, x, biases])
}

/// The fused function of [`dense`] and [`dense_batch`]. Its input slices are the weights, `x` and the biases.
struct Dense {
    vectors: usize,
}

/// The smallest number of vectors for which it pays to transpose the weights.
const FEW: usize = 4;

impl Fused for Dense {
    /// The weights and the inputs `x`.
    type Saved<R: Real> = [Vec<R>; 2];

    fn eval<R: Real>(&self, inputs: &[&[R]]) -> Vec<R> {
        let &[weights, x, biases] = inputs else {
            unreachable!("a dense layer has three input slices")
        };
        let (rows, vectors) = (biases.len(), self.vectors);
        if weights.is_empty() {
            return biases.repeat(vectors);
        }
        let columns = weights.len() / rows;
        let mut y = Vec::with_capacity(vectors * rows);
        if vectors < FEW {
            for x in x.chunks_exact(columns) {
                let rows = weights.chunks_exact(columns).zip(biases);
                y.extend(rows.map(|(row, &bias)| R::dot(row, x) + bias));
            }
            return y;
        }
        let mut transposed = vec![R::zero(); weights.len()];
        R::vectorize(Transpose {
            from: weights,
            from_row: columns,
            rows,
            columns,
            to: &mut transposed,
            to_row: rows,
        });
        for _ in 0..vectors {
            y.extend_from_slice(biases);
        }
        let product = Product {
            a: Strided::by_rows(x, columns),
            b: &transposed,
            b_row: rows,
            to: &mut y,
            to_row: rows,
            rows: vectors,
            depth: columns,
            columns: rows,
        };
        product.add();
        y
    }

    fn record<R: Real>(&self, inputs: &[&[R]]) -> (Vec<R>, [Vec<R>; 2]) {
        (self.eval(inputs), [inputs[0].to_vec(), inputs[1].to_vec()])
    }

    fn reverse<R: Real>(
        &self,
        [weights, x]: &mut [Vec<R>; 2],
        y_bar: &[R],
        wanted: &[bool],
    ) -> Vec<Vec<R>> {
        let vectors = self.vectors;
        let (rows, columns) = (y_bar.len() / vectors.max(1), x.len() / vectors.max(1));
        let [weights_size, x_size] = [[rows, columns], [vectors, columns]];
        let zeros = |numbers: usize| vec![R::zero(); numbers];
        let [mut weights_bar, mut x_bar] = [Vec::new(), Vec::new()];
        let y_bars = Strided::by_rows(y_bar, rows);
        if wanted[0] {
            weights_bar = zeros(weights.len());
            let product = Product {
                a: y_bars.transposed(),
                b: x,
                b_row: columns,
                to: &mut weights_bar,
                to_row: columns,
                rows,
                depth: vectors,
                columns,
            };
            let finite = Strided::by_rows(x, columns).all_finite(x_size);
            product.add_chained(Cotangents::A, finite);
        }
        if wanted[1] {
            x_bar = zeros(x.len());
            let product = Product {
                a: y_bars,
                b: weights,
                b_row: columns,
                to: &mut x_bar,
                to_row: columns,
                rows: vectors,
                depth: rows,
                columns,
            };
            let finite = Strided::by_rows(weights, columns).all_finite(weights_size);
            product.add_chained(Cotangents::A, finite);
        }
        let mut biases_bar = SumByParts::new(rows);
        for y_bar in y_bar.chunks_exact(rows.max(1)) {
            biases_bar.add(y_bar);
        }
        vec![weights_bar, x_bar, biases_bar.total()]
    }
}
