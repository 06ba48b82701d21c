//! Arguments that move: the input of forward passes.

use crate::dual::Dual;
use crate::real::Real;

/// How many columns a forward pass of a Jacobian or a Hessian carries at once: enough to
/// share the primal's work, few enough to stay in registers.
pub(crate) const CHUNK: usize = 4;

/// `x` moving along a direction.
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

/// `x` as duals: the [`CHUNK`] arguments from place `first` on move, each along another direction.
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
