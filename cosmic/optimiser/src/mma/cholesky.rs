//! A solver for small symmetric linear systems.
//!
//! nalgebra's Cholesky decomposition is not used, because it refuses singular matrices, and flat directions of the dual
//! make the matrix singular. It also sums in another order, which would change the bits of runs with three or more
//! constraints.

/// Solves `matrix x = right` by Cholesky decomposition, and writes `x` to `right`. The matrix is row-major, symmetric,
/// and positive semidefinite except for rounding. A pivot that is smaller than its rounding error is raised to that
/// error.
pub(super) fn solve_positive(matrix: &mut [f64], right: &mut [f64]) {
    let size = right.len();
    for column in 0..size {
        let diagonal = matrix[column * size + column];
        for row in column..size {
            let reduction: f64 = (0..column)
                .map(|k| matrix[row * size + k] * matrix[column * size + k])
                .sum();
            let entry = matrix[row * size + column] - reduction;
            matrix[row * size + column] = if row == column {
                entry
                    .max(f64::EPSILON * diagonal)
                    .max(f64::MIN_POSITIVE)
                    .sqrt()
            } else {
                entry / matrix[column * size + column]
            };
        }
    }
    for row in 0..size {
        let known: f64 = (0..row).map(|k| matrix[row * size + k] * right[k]).sum();
        right[row] = (right[row] - known) / matrix[row * size + row];
    }
    for row in (0..size).rev() {
        let known: f64 = (row + 1..size)
            .map(|k| matrix[k * size + row] * right[k])
            .sum();
        right[row] = (right[row] - known) / matrix[row * size + row];
    }
}
