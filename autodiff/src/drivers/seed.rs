//! Makes the arguments of forward passes: dual numbers with tangents.

use smallvec::SmallVec;

use crate::dual::Dual;
use crate::real::Real;

/// The number of columns that one pass of a Hessian or of a sparse Jacobian computes. They share the work of computing
/// the values.
pub(crate) const CHUNK: usize = 4;

/// The number of columns that one forward pass of a gradient or a dense Jacobian computes. There are few enough of them
/// for the tangents to stay in registers.
pub(crate) const WIDE: usize = 8;

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

/// Returns `x` as dual numbers. The `N` arguments from index `first` on are variables, each with its own direction; all
/// other arguments are constants.
pub(crate) fn seeded<R: Real, const N: usize>(x: &[R], first: usize) -> Vec<Dual<R, N>> {
    let seed = |(j, &value): (usize, &R)| {
        if (first..first + N).contains(&j) {
            Dual::variable(value, j - first)
        } else {
            Dual::constant(value)
        }
    };
    x.iter().enumerate().map(seed).collect()
}

/// Calls `pass` for the first, the second, ... [`WIDE`] arguments. It gets the index of the first of them, and `x` as
/// dual numbers like those of [`seeded`]. They are made only once, and up to 16 of them need no memory from the system.
/// Without arguments there is one pass, in which a function says how many values it has.
pub(super) fn each_pass<R: Real>(x: &[R], mut pass: impl FnMut(usize, &[Dual<R, WIDE>])) {
    let constants = x.iter().map(|&value| Dual::constant(value));
    let mut duals: SmallVec<[_; 16]> = constants.collect();
    for first in (0..x.len().max(1)).step_by(WIDE) {
        let last = x.len().min(first + WIDE);
        for j in first..last {
            duals[j].tangent[j - first] = R::one();
        }
        pass(first, &duals);
        for j in first..last {
            duals[j].tangent[j - first] = R::zero();
        }
    }
}
