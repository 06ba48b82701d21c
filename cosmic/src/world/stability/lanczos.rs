//! The largest eigenvalue of a large symmetric matrix, computed from products of the matrix with vectors.
//!
//! C. Lanczos, "An iteration method for the solution of the eigenvalue problem of linear
//! differential and integral operators", Journal of Research of the National Bureau of Standards
//! 45 (1950) 255-282: in an orthogonal basis of the vectors `v, A v, A^2 v, ...` the matrix
//! is tridiagonal, and its extreme eigenvalues converge quickly to those of `A`.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Computes the largest eigenvalue of a matrix and its eigenvector; `None` if a product is not finite. `product`
/// multiplies the matrix by a vector. `start` must have a component along every eigenvector. The eigenvalue is accepted if
/// its residual is at most `accuracy` times as large; two eigenvalues that differ by more than this fraction are told apart.
/// The residual bounds the error of the eigenvalue and is added to it, so the result is never too small.
pub(super) fn largest_eigenpair(
    start: &DVector<f64>,
    accuracy: f64,
    product: impl Fn(&DVector<f64>) -> DVector<f64>,
) -> Option<(f64, DVector<f64>)> {
    let mut basis = vec![start.normalize()];
    let (mut diagonal, mut beside) = (Vec::new(), Vec::new());
    // The eigenvalues of the tridiagonal matrix are computed when the basis has this many vectors. The intervals
    // between these computations grow.
    let mut next_solve = 8;
    loop {
        let size = basis.len();
        let mut rest = product(&basis[size - 1]);
        diagonal.push(basis[size - 1].dot(&rest));
        // Orthogonalises twice: after a single pass, rounding errors would grow into copies of earlier vectors.
        for _ in 0..2 {
            for known in &basis {
                rest.axpy(-known.dot(&rest), known, 1.0);
            }
        }
        let length = rest.norm();
        if !length.is_finite() {
            return None;
        }
        let scale = diagonal
            .iter()
            .chain(&beside)
            .fold(0.0, |most: f64, x| most.max(x.abs()));
        let complete = size == start.len() || length <= f64::EPSILON * scale;
        if complete || size == next_solve {
            next_solve = size + size / 4 + 8;
            let projected = SymmetricEigen::new(tridiagonal(&diagonal, &beside));
            let (k, largest) = projected.eigenvalues.argmax();
            let shares = projected.eigenvectors.column(k);
            let residual = length * shares[size - 1].abs();
            if complete || residual <= accuracy * largest {
                let mut vector = DVector::zeros(start.len());
                for (known, &share) in basis.iter().zip(shares.iter()) {
                    vector.axpy(share, known, 1.0);
                }
                return Some((largest + residual, vector));
            }
        }
        beside.push(length);
        basis.push(rest / length);
    }
}

/// The symmetric tridiagonal matrix with the entries `diagonal` on the diagonal and the entries `beside` next to it.
fn tridiagonal(diagonal: &[f64], beside: &[f64]) -> DMatrix<f64> {
    DMatrix::from_fn(diagonal.len(), diagonal.len(), |row, column| {
        match row.abs_diff(column) {
            0 => diagonal[row],
            1 => beside[row.min(column)],
            _ => 0.0,
        }
    })
}
