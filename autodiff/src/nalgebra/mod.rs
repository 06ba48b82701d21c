//! Differentiation through nalgebra (feature `nalgebra`).
//!
//! [`Element`] makes any [`Real`] an element of `SVector`, `DMatrix` and the rest, factorisations
//! included: it implements `RealField`. A wrapper rather than an implementation for each type, so
//! that code which is generic over `R: Real` can use nalgebra too, and every driver can run it.
//!
//! ```
//! use ::nalgebra::{Matrix2, Vector2};
//! use autodiff::nalgebra::Element;
//! use autodiff::{Function, Real, gradient};
//!
//! /// The energy of a load on springs: half the load times what it does, `K^-1 load`.
//! struct Compliance;
//! impl Function for Compliance {
//!     fn eval<R: Real>(&self, x: &[R]) -> R {
//!         let [a, b, load] = [0, 1, 2].map(|i| Element(x[i]));
//!         let stiffness = Matrix2::new(a + b, -b, -b, b);
//!         let force = Vector2::new(Element::lit(0.0), load);
//!         let factors = stiffness.cholesky().expect("springs that pull");
//!         (force.dot(&factors.solve(&force)) * Element::lit(0.5)).0
//!     }
//! }
//!
//! // Springs in a row: load^2 / 2 (1/a + 1/b).
//! let by = gradient(&Compliance, &[2.0, 4.0, 3.0]);
//! let expected = [-9.0 / 8.0, -9.0 / 32.0, 2.25];
//! assert!(by.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14));
//! ```
//!
//! # What to know
//!
//! - Decisions of an algorithm (pivots, convergence) look at primals; where lanes disagree about
//!   one it panics. The derivative is that of the branch taken.
//! - Iterative factorisations (SVD, eigenvalues) are differentiated through their iterations, and
//!   stop when the primal has converged; degenerate singular values have no derivative.
//! - An element does not convert to a float: `try_convert` returns `None` and the unchecked
//!   conversions panic, where a cast would lose the derivative silently. Take `.0` and its primal.
//!   For the same reason there is no `ToPrimitive`, and so no `num_traits::Float`; `Num`,
//!   `NumAssign`, `Signed` and `FromPrimitive` are there.
//! - Rounding functions are constants between their steps: `floor(x)` has derivative 0, `x % m`
//!   that of `x`.

mod field;
mod functions;
mod number;

use ::nalgebra::DVector;

use crate::real::Real;

/// A [`Real`] as an element of nalgebra's matrices. See the [module](self).
#[derive(Clone, Copy, Debug)]
pub struct Element<R>(
    /// The number itself.
    pub R,
);

impl<R: Real> Element<R> {
    /// A constant.
    #[inline]
    pub fn lit(value: f64) -> Self {
        Self(R::lit(value))
    }
}

impl<R: Real> From<R> for Element<R> {
    #[inline]
    fn from(number: R) -> Self {
        Self(number)
    }
}

/// A slice of numbers as a vector.
pub fn vector<R: Real>(numbers: &[R]) -> DVector<Element<R>> {
    DVector::from_iterator(numbers.len(), numbers.iter().copied().map(Element))
}
