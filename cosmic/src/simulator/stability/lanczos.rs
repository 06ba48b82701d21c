//! The largest eigenvalue of a large symmetric matrix, computed from products of the matrix with vectors.
//!
//! C. Lanczos, "An iteration method for the solution of the eigenvalue problem of linear
//! differential and integral operators", Journal of Research of the National Bureau of Standards
//! 45 (1950) 255-282: in an orthogonal basis of the vectors `v, A v, A^2 v, ...` the matrix
//! is tridiagonal, and its extreme eigenvalues converge quickly to those of `A`.

/// The relative accuracy: an eigenvalue is accepted if its residual is at most this fraction of it. Two eigenvalues
/// that differ by more than this fraction are told apart.
const ACCURACY: f64 = 1e-12;

/// Computes the largest eigenvalue of a matrix and its eigenvector; `None` if a product is not finite. `product`
/// multiplies the matrix by a vector. `start` must have a component along every eigenvector. The residual bounds the
/// error of the eigenvalue and is added to it, so the result is never too small.
pub(super) fn largest_eigenpair(
    start: &[f64],
    product: impl Fn(&[f64]) -> Vec<f64>,
) -> Option<(f64, Vec<f64>)> {
    let mut basis = vec![divided(start, norm(start))];
    let (mut diagonal, mut beside) = (Vec::new(), Vec::new());
    // The eigenvalues of the tridiagonal matrix are computed when the basis has this many vectors. The intervals
    // between these computations grow.
    let mut next_solve = 8;
    loop {
        let size = basis.len();
        let mut rest = product(&basis[size - 1]);
        diagonal.push(dot(&basis[size - 1], &rest));
        // Orthogonalises twice: after a single pass, rounding errors would grow into copies of earlier vectors.
        for _ in 0..2 {
            for known in &basis {
                let share = dot(known, &rest);
                add(&mut rest, -share, known);
            }
        }
        let length = norm(&rest);
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
            let (largest, shares) = largest_of_tridiagonal(&diagonal, &beside);
            let residual = length * shares[size - 1].abs();
            if complete || residual <= ACCURACY * largest {
                let mut vector = vec![0.0; start.len()];
                for (known, share) in basis.iter().zip(shares) {
                    add(&mut vector, share, known);
                }
                return Some((largest + residual, vector));
            }
        }
        beside.push(length);
        basis.push(divided(&rest, length));
    }
}

/// The largest eigenvalue and its unit eigenvector of the symmetric tridiagonal matrix `T` with the entries `diagonal`
/// on the diagonal and the positive entries `beside` next to it.
///
/// The pivots of `x - T` are all positive if and only if `x` is above all eigenvalues: bisection finds the smallest such
/// number. There, two inverse iterations find the eigenvector. They only add positive numbers, so that even its tiny
/// components are accurate.
fn largest_of_tridiagonal(diagonal: &[f64], beside: &[f64]) -> (f64, Vec<f64>) {
    let size = diagonal.len();
    let pivots = |x: f64| {
        let mut pivots = vec![x - diagonal[0]];
        for k in 1..size {
            pivots.push(x - diagonal[k] - beside[k - 1].powi(2) / pivots[k - 1]);
        }
        pivots
    };
    let largest = |list: &[f64]| list.iter().copied().fold(f64::MIN, f64::max);
    let mut below = largest(diagonal);
    let reach = 2.0 * largest(beside).max(0.0) + f64::EPSILON * below.abs();
    let mut above = below + reach + f64::MIN_POSITIVE;
    loop {
        let middle = below + 0.5 * (above - below);
        if middle <= below || middle >= above {
            break;
        }
        match pivots(middle).iter().all(|&pivot| pivot > 0.0) {
            true => above = middle,
            false => below = middle,
        }
    }
    let pivots = pivots(above);
    let mut vector = vec![1.0; size];
    for _ in 0..2 {
        for k in 1..size {
            vector[k] += beside[k - 1] / pivots[k - 1] * vector[k - 1];
        }
        for k in (0..size).rev() {
            vector[k] /= pivots[k];
            if k + 1 < size {
                vector[k] += beside[k] / pivots[k] * vector[k + 1];
            }
        }
        // Without the first division, squares could overflow in the second.
        vector = divided(&vector, largest(&vector));
        vector = divided(&vector, norm(&vector));
    }
    (above, vector)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn norm(vector: &[f64]) -> f64 {
    dot(vector, vector).sqrt()
}

fn divided(vector: &[f64], by: f64) -> Vec<f64> {
    vector.iter().map(|x| x / by).collect()
}

/// Adds `factor * other` to `to`.
fn add(to: &mut [f64], factor: f64, other: &[f64]) {
    for (sum, x) in to.iter_mut().zip(other) {
        *sum += factor * x;
    }
}
