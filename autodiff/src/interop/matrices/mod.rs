//! Differentiation through nalgebra (feature `nalgebra`).
//!
//! [`Element`] makes any [`Real`](crate::Real) an element of nalgebra's vectors and matrices, with their
//! factorisations. It implements `RealField`.
//!
//! ```
//! use nalgebra::{Matrix2, Vector2};
//! use autodiff::matrices::Element;
//! use autodiff::{Real, gradient};
//!
//! /// The energy of a load on springs: half the load times the displacement `K^-1 load`.
//! fn compliance<R: Real>(x: &[R]) -> R {
//!     let [a, b, load] = [0, 1, 2].map(|i| Element(x[i]));
//!     let stiffness = Matrix2::new(a + b, -b, -b, b);
//!     let force = Vector2::new(Element::lit(0.0), load);
//!     let factors = stiffness.cholesky().expect("springs that pull");
//!     (0.5 * force.dot(&factors.solve(&force))).0
//! }
//!
//! // Springs in a row: load^2 / 2 (1/a + 1/b).
//! let by = gradient(compliance, &[2.0, 4.0, 3.0]);
//! let expected = [-9.0 / 8.0, -9.0 / 32.0, 2.25];
//! assert!(by.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14));
//! ```
//!
//! [`value_and_gradient`], [`value_and_jacobian`] and [`value_gradient_hessian`] take functions of vectors, so that no
//! element is wrapped by hand: `value_and_gradient(|x| 0.5 * x.norm_squared(), &x)`.
//!
//! # What to know
//!
//! - The rules of [`interop`](crate::interop) for every [`Element`] hold here too.
//! - The branches of an algorithm (the choice of pivots, the test for convergence) depend only on primals.
//! - Iterative factorisations (SVD, eigenvalues) are differentiated through their iterations, which stop when the
//!   primal has converged. Degenerate singular values have no derivative.
//! - **Iterative factorisations skip entries that are zero and lose the derivatives with respect to them**, for example
//!   in a diagonal, triangular or block matrix. `symmetric_eigenvalues` of a diagonal matrix has a Hessian of zeros.
//!   The element type cannot prevent this: nalgebra uses the same test for zero to see whether an iteration has
//!   converged. For a symmetric matrix use [`symmetric_eigen`], which is right everywhere, and
//!   [`symmetric_eigen_groups`] if eigenvalues are repeated. Write other results of SVD,
//!   Schur and the pseudo-inverse as a root ([`implicit`](crate::implicit)) or by a custom rule.
//! - Solutions by LU, QR and Cholesky and the inverse are right at every regular matrix, also with zeros on the
//!   diagonal, defective, or with repeated eigenvalues. At a singular matrix they are `None`.
//! - **nalgebra's elimination skips a column whose pivot is zero, and loses its derivatives.** So the derivatives of
//!   `lu().determinant()` and `full_piv_lu().determinant()` of a singular matrix are wrong, and so are those of
//!   `determinant()` from 4 x 4 on. [`determinant`] and [`log_determinant`] are right everywhere.
//! - **Geometry branches at the identity, and its derivative there is wrong.** It is zero for a
//!   `UnitQuaternion`, `Rotation3` or `Isometry3` of a rotation vector of zero, for `scaled_axis` of the identity
//!   and for `rotation_between` parallel vectors. [`rotation`], its inverse [`rotation_vector`] and [`angle`] are right
//!   everywhere.
//! - A conversion of an element to a float panics, because it would lose the derivative. So does nalgebra's matrix
//!   exponential, which converts norms: use [`exp`].

mod determinant;
mod eigen;
mod exponential;
mod field;
mod parameters;
mod rotation;
mod drivers;

pub use super::element::Element;
pub use determinant::{determinant, log_determinant};
pub use drivers::{value_and_gradient, value_and_jacobian, value_gradient_hessian};
pub use eigen::{EigenGroup, EigenPair, symmetric_eigen, symmetric_eigen_groups};
pub use exponential::exp;
pub use rotation::{angle, rotation, rotation_vector, vector};
