//! Measures the computation of a sparse Jacobian. The functions are Broyden's tridiagonal equations. Patterns, colours and
//! tapes are found before the clock starts.

use crate::task::{Task, Way, kept};

/// The number of equations and unknowns.
const SIZE: usize = 1000;

pub(crate) fn task() -> Task {
    let x = kept((0..SIZE).map(|i| -0.5 + 0.1 * (i as f64).sin()));
    Task {
        title: format!("Tridiagonal Jacobian of {SIZE} equations"),
        source: include_str!("sparse.rs"),
        // The tolerance is for a few roundings in each entry.
        tolerance: 1e-14,
        ways: vec![
            Way::new("by hand", "", || hand::jacobian(x)),
            Way::new("ours", "`sparse_jacobian`, pattern kept", ours::jacobian(x)),
            Way::new("echidna", "tape and pattern kept", echidna::jacobian(x)),
        ],
    }
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

/// The equations as a function for any driver. The pattern is kept, as in Newton's method.
mod ours {
    use autodiff::sparse::{Pattern, sparse_jacobian};
    use autodiff::{Real, lit};

    fn broyden<R: Real>(x: &[R]) -> Vec<R> {
        let at = |i: usize| x.get(i).copied().unwrap_or(R::zero());
        let row = |i: usize| {
            (lit(3.0) - lit(2.0) * x[i]) * x[i] - at(i.wrapping_sub(1)) - lit(2.0) * at(i + 1)
                + lit(1.0)
        };
        (0..x.len()).map(row).collect()
    }

    pub(super) fn jacobian(x: &[f64]) -> impl Fn() -> Vec<f64> {
        let pattern = Pattern::traced(broyden, x);
        move || sparse_jacobian(broyden, x, &pattern)
    }
}

/// The equations, generic over the trait of echidna. The tape and the pattern are kept, as in Newton's method.
mod echidna {
    use echidna::Scalar;
    use echidna::sparse::column_coloring;

    fn broyden<T: Scalar<Float = f64>>(x: &[T]) -> Vec<T> {
        let at = |i: usize| x.get(i).copied().unwrap_or(T::zero());
        let row = |i: usize| {
            (T::from_f(3.0) - T::from_f(2.0) * x[i]) * x[i]
                - at(i.wrapping_sub(1))
                - T::from_f(2.0) * at(i + 1)
                + T::from_f(1.0)
        };
        (0..x.len()).map(row).collect()
    }

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
