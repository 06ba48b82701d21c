//! The drivers that use several threads must give results that are bit-identical to those of the serial drivers.

use autodiff::sparse::{Pattern, sparse_jacobian};
use autodiff::{Dense, Dual, Real, gradient, hessian, jacobian, jacobian_reverse, parallel};

/// A vector function with the given number of values. Each value depends on all arguments.
struct Waves {
    values: usize,
}

impl Waves {
    fn values<R: Real>(&self, x: &[R]) -> Vec<R> {
        let term = |(j, &x): (usize, &R), i: usize| (x * R::lit((1 + i * j) as f64)).sin();
        let value = |i| {
            x.iter()
                .enumerate()
                .map(|x| term(x, i))
                .fold(R::one(), |a, b| a + b)
        };
        (0..self.values).map(value).collect()
    }
}

impl Waves {
    /// Returns the length of the vector of values.
    fn length<R: Real>(&self, x: &[R]) -> R {
        let y = self.values(x);
        R::dot(&y, &y).sqrt()
    }
}

fn point(len: usize) -> Vec<f64> {
    (0..len).map(|i| ((i * i) as f64 * 0.37).sin()).collect()
}

/// Runs a check in thread pools of several sizes.
fn in_pools(check: impl Fn() + Sync) {
    for threads in [1, 2, 5] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().expect("a pool of threads").install(&check);
    }
}

#[test]
#[cfg_attr(target_family = "wasm", ignore = "no threads")]
fn every_driver_gives_the_serial_bits_with_any_number_of_threads() {
    in_pools(|| {
        for (values, arguments) in [(30, 7), (7, 30), (1, 1), (0, 3)] {
            let (function, x) = (Waves { values }, point(arguments));
            assert_eq!(
                parallel::jacobian(|x| function.values(x), &x),
                jacobian(|x| function.values(x), &x)
            );
            assert_eq!(
                parallel::jacobian_reverse(|x| function.values(x), &x),
                jacobian_reverse(|x| function.values(x), &x)
            );
            if values > 0 {
                assert_eq!(
                    parallel::hessian(|x| function.length(x), &x),
                    hessian(|x| function.length(x), &x)
                );
            }
        }
    });
}

#[test]
#[cfg_attr(target_family = "wasm", ignore = "no threads")]
fn sparse_jacobians_too() {
    fn pairs<R: Real>(x: &[R]) -> Vec<R> {
        let spread = |i: usize| (i.saturating_sub(4)..(i + 5).min(x.len())).map(|j| x[j]);
        let value = |i| spread(i).fold(x[i], |a, b| (a * b).sin() + a);
        (0..x.len()).map(value).collect()
    }
    let (pattern, x) = (Pattern::banded(50, 4, 4), point(50));
    let serial = sparse_jacobian(pairs, &x, &pattern);
    in_pools(|| assert_eq!(parallel::sparse_jacobian(pairs, &x, &pattern), serial));
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn nested_duals_go_through_and_an_outer_tape_is_refused() {
    let (function, x) = (Waves { values: 12 }, point(9));
    let moving: Vec<_> = x.iter().map(|&x| Dual::<f64, 1>::variable(x, 0)).collect();
    let tangents = |matrix: Dense<Dual<f64, 1>>| -> Vec<[f64; 1]> {
        matrix
            .as_slice()
            .iter()
            .map(|entry| entry.tangent)
            .collect()
    };
    let serial = tangents(jacobian(|x| function.values(x), &moving));
    assert_eq!(
        tangents(parallel::jacobian(|x| function.values(x), &moving)),
        serial
    );

    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(2)
        .build()
        .expect("a pool");
    let outer = || {
        gradient(
            |x| pool.install(|| parallel::hessian(|x| function.length(x), x)[0][0]),
            &x,
        )
    };
    assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(outer)).is_err());
}
