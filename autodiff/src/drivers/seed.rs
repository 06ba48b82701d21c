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
#[track_caller]
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
pub(crate) fn variables_from<R: Real, const N: usize>(x: &[R], first: usize) -> Vec<Dual<R, N>> {
    let seed = |(j, &value): (usize, &R)| {
        if (first..first + N).contains(&j) {
            Dual::variable(value, j - first)
        } else {
            Dual::constant(value)
        }
    };
    x.iter().enumerate().map(seed).collect()
}

/// The passes of forward mode over the arguments, [`WIDE`] directions at a time. There is at least one, because the first
/// pass also computes the values. This is not a closure over the passes, which would hide the line of the caller from panics.
pub(super) struct Passes<R> {
    /// The arguments of the current pass.
    pub(super) x: SmallVec<[Dual<R, WIDE>; 16]>,
    /// The first argument of the next pass.
    next: usize,
}

impl<R: Real> Passes<R> {
    pub(super) fn new(x: &[R]) -> Self {
        let x = x.iter().map(|&value| Dual::constant(value)).collect();
        Self { x, next: 0 }
    }

    /// Begins the next pass and returns the first argument that it moves.
    pub(super) fn next(&mut self) -> Option<usize> {
        let (first, len) = (self.next, self.x.len());
        if first >= len.max(1) {
            return None;
        }
        for j in first.saturating_sub(WIDE)..first {
            self.x[j].tangent[j % WIDE] = R::zero();
        }
        for j in first..len.min(first + WIDE) {
            self.x[j].tangent[j % WIDE] = R::one();
        }
        self.next = first + WIDE;
        Some(first)
    }
}
