//! Makes the arguments of forward passes: dual numbers with tangents.

use crate::dual::Dual;
use crate::real::Real;

/// The number of columns that one forward pass of a Jacobian or a Hessian computes. They share the work of computing
/// the values. There are few enough of them for the tangents to stay in registers.
pub(crate) const CHUNK: usize = 4;

/// Returns `x` as dual numbers whose tangents are the entries of `direction`.
pub(crate) fn along<R: Real>(x: &[R], direction: &[R]) -> Vec<Dual<R, 1>> {
    assert_eq!(
        x.len(),
        direction.len(),
        "the direction needs one entry per argument"
    );
    let pairs = x.iter().zip(direction);
    let dual = |(&value, &tangent)| Dual {
        value,
        tangent: [tangent],
    };
    pairs.map(dual).collect()
}

/// Returns `x` as dual numbers. The [`CHUNK`] arguments from index `first` on are variables, each with its own
/// direction; all other arguments are constants.
pub(crate) fn seeded<R: Real>(x: &[R], first: usize) -> Vec<Dual<R, CHUNK>> {
    let seed = |(j, &value): (usize, &R)| {
        if (first..first + CHUNK).contains(&j) {
            Dual::variable(value, j - first)
        } else {
            Dual::constant(value)
        }
    };
    x.iter().enumerate().map(seed).collect()
}
