//! Measures the computation of a sparse Jacobian. The functions are Broyden's tridiagonal equations.

use crate::task::{Task, Way, kept};

/// The number of equations and unknowns.
const SIZE: usize = 1000;

pub(crate) fn task() -> Task {
    let x = kept((0..SIZE).map(|i| -0.5 + 0.1 * (i as f64).sin()));
    Task {
        title: format!("Tridiagonal Jacobian of {SIZE} equations"),
        about: "Broyden's tridiagonal equations. A kept pattern and its colours were found before the clock started, \
                as in Newton's method. So was a kept tape.",
        source: include_str!("sparse.rs"),
        // The tolerance is for a few roundings in each entry.
        tolerance: 1e-14,
        ways: vec![
            Way::new("by hand", "", &["hand"], || hand::jacobian(x)),
            Way::new(
                "ours",
                "`sparse_jacobian`, pattern kept",
                &["ours", "ours_kept"],
                ours_kept::jacobian(x),
            ),
            Way::new(
                "ours",
                "`sparse_jacobian`, traced each time",
                &["ours", "ours_traced"],
                || ours_traced::jacobian(x),
            ),
            Way::new("ours", "`jacobian`, dense", &["ours", "ours_dense"], || {
                tridiagonal(&ours_dense::jacobian(x))
            }),
            Way::new(
                "echidna",
                "tape and pattern kept",
                &["echidna", "echidna_kept"],
                echidna_kept::jacobian(x),
            ),
        ],
    }
}

/// Returns the entries of a dense matrix on its three diagonals, row by row. These are compared.
fn tridiagonal(rows: &[f64]) -> Vec<f64> {
    let columns = |i: usize| i.saturating_sub(1)..(i + 2).min(SIZE);
    (0..SIZE)
        .flat_map(|i| columns(i).map(move |j| rows[i * SIZE + j]))
        .collect()
}

/// The Jacobian by formulas for its three diagonals.
mod hand {
    use super::SIZE;

    pub(super) fn jacobian(x: &[f64]) -> Vec<f64> {
        let mut entries = Vec::with_capacity(3 * SIZE - 2);
        for i in 0..SIZE {
            if i > 0 {
                entries.push(-1.0);
            }
            entries.push(3.0 - 4.0 * x[i]);
            if i + 1 < SIZE {
                entries.push(-2.0);
            }
        }
        entries
    }
}

/// The equations as a function for any driver.
mod ours {
    use autodiff::{Real, lit};

    pub(super) fn broyden<R: Real>(x: &[R]) -> Vec<R> {
        let at = |i: usize| x.get(i).copied().unwrap_or(R::zero());
        let row = |i: usize| {
            (lit(3.0) - lit(2.0) * x[i]) * x[i] - at(i.wrapping_sub(1)) - lit(2.0) * at(i + 1)
                + lit(1.0)
        };
        (0..x.len()).map(row).collect()
    }
}

/// A sparse Jacobian whose pattern is kept, as in Newton's method.
mod ours_kept {
    use autodiff::sparse::{Pattern, sparse_jacobian};

    use super::ours::broyden;

    pub(super) fn jacobian(x: &[f64]) -> impl Fn() -> Vec<f64> {
        let pattern = Pattern::traced(broyden, x);
        move || sparse_jacobian(broyden, x, &pattern)
    }
}

/// A sparse Jacobian whose pattern is traced each time. This takes one line of code.
mod ours_traced {
    use autodiff::sparse::{Pattern, sparse_jacobian};

    use super::ours::broyden;

    pub(super) fn jacobian(x: &[f64]) -> Vec<f64> {
        sparse_jacobian(broyden, x, &Pattern::traced(broyden, x))
    }
}

/// A dense Jacobian. Each pass computes four columns.
mod ours_dense {
    use super::ours::broyden;

    pub(super) fn jacobian(x: &[f64]) -> Vec<f64> {
        autodiff::jacobian(broyden, x).into_vec()
    }
}

/// The equations, generic over the trait of echidna.
mod echidna {
    use echidna::Scalar;

    pub(super) fn broyden<T: Scalar<Float = f64>>(x: &[T]) -> Vec<T> {
        let at = |i: usize| x.get(i).copied().unwrap_or(T::zero());
        let row = |i: usize| {
            (T::from_f(3.0) - T::from_f(2.0) * x[i]) * x[i]
                - at(i.wrapping_sub(1))
                - T::from_f(2.0) * at(i + 1)
                + T::from_f(1.0)
        };
        (0..x.len()).map(row).collect()
    }
}

/// A sparse Jacobian by echidna. The tape and the pattern are kept, as in Newton's method.
mod echidna_kept {
    use echidna::sparse::column_coloring;

    use super::echidna::broyden;

    pub(super) fn jacobian(x: &[f64]) -> impl FnMut() -> Vec<f64> {
        let (mut tape, _) = echidna::record_multi(broyden, x);
        let pattern = tape.detect_jacobian_sparsity();
        let (colors, count) = column_coloring(&pattern);
        move || {
            tape.sparse_jacobian_with_pattern(x, &pattern, &colors, count, true)
                .1
        }
    }
}
