//! Solves Bratu's equation, -u_xx - u_yy = 2 e^u, on 60 x 60 points by Newton's method.
use autodiff::sparse::{Pattern, sparse_jacobian};
use autodiff::{Real, lit};
use nalgebra::DVector;
use nalgebra_sparse::{CscMatrix, CsrMatrix, factorization::CscCholesky};

const N: usize = 60;

/// Returns the residual of the equation on the unit square, with `u = 0` on the boundary.
fn bratu<R: Real>(u: &[R]) -> Vec<R> {
    let at = |inside, i: usize| if inside { u[i] } else { R::zero() };
    let equation = |i: usize| {
        let beside = at(!i.is_multiple_of(N), i.wrapping_sub(1)) + at(i % N < N - 1, i + 1);
        let around = beside + at(i >= N, i.wrapping_sub(N)) + at(i < N * N - N, i + N);
        lit(4.0) * u[i] - around - lit(2.0 / 61f64.powi(2)) * u[i].exp()
    };
    (0..N * N).map(equation).collect()
}

fn main() {
    let mut u = DVector::zeros(N * N);
    let pattern = Pattern::traced(bratu, u.as_slice());
    let (rows, columns) = (pattern.row_starts(), pattern.column_indices());
    println!("{} entries, {} colours", columns.len(), pattern.colors());
    let residual = |u: &DVector<f64>| DVector::from(bratu(u.as_slice()));
    for _ in 0..4 {
        println!("highest {}, residual {}", u.max(), residual(&u).norm());
        let (rows, columns) = (rows.to_vec(), columns.to_vec());
        let entries = sparse_jacobian(bratu, u.as_slice(), &pattern);
        let j = CsrMatrix::try_from_csr_data(N * N, N * N, rows, columns, entries).unwrap();
        let factors = CscCholesky::factor(&CscMatrix::from(&j)).unwrap();
        u -= factors.solve(&residual(&u));
    }
    assert!(residual(&u).norm() < 1e-13);
}
