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
//! - Solutions by LU, QR and Cholesky and the inverse are right at every regular matrix, also with zeros on the
//!   diagonal, defective, or with repeated eigenvalues. At a singular matrix, [`solve`] and [`inverse`] return `None`.
//! - [`determinant`] and [`log_determinant`] are right everywhere, [`symmetric_eigen`] and [`singular_values`]
//!   wherever the values are distinct, [`symmetric_eigen_groups`] also where eigenvalues are repeated. [`rotation`],
//!   its inverse [`rotation_vector`] and [`angle`] are right at the identity too. Write other results of SVD, Schur
//!   and the pseudo-inverse as a root ([`implicit`](crate::implicit)) or by a custom rule.
//! - A conversion of an element to a float panics, because it would lose the derivative. So does nalgebra's matrix
//!   exponential, which converts norms: use [`exp`].
//!
//! # Where nalgebra asks for zero
//!
//! An element that carries a derivative is never zero, and never equal to a constant. These calls of nalgebra 0.35.0 and
//! simba 0.10.2 ask. The last column is the result where the answer would be yes for a float. A zero that is a constant
//! is left out, as with floats.
//!
//! | call | asks about | result |
//! | --- | --- | --- |
//! | `axpy`, `axcpy`, `gemv*`, `gemm*`, `sygemv`, `hegemv`, `ger*`, `syger`, `quadform*`, `cmpy`, `cdpy`, `lerp` | the factor of what is overwritten | right |
//! | `Reflection` | the bias | right |
//! | `Rotation3::from_axis_angle`, `UnitComplex::slerp` | the angle | right |
//! | `GivensRotation::cancel_x`, `cancel_y` | a component | right; NaN if both are zero |
//! | `Transform::transform_point`, `Point::from_homogeneous`, `Scale::try_inverse`, `Similarity` | a divisor | infinite or NaN; no `None`, no panic |
//! | `try_inverse`, `solve`, `solve_*_triangular`, `udu` | a pivot | infinite or NaN; no `None`. Use [`solve`], [`inverse`] |
//! | `is_invertible` | a pivot | true |
//! | `determinant` from 4 x 4 on, and by `lu`, `full_piv_lu`, `lblt` | a pivot | right or NaN. Use [`determinant`] |
//! | `qr`, `col_piv_qr`, `hessenberg`, `bidiagonalize`, `symmetric_tridiagonalize` | the length of a column or row | NaN or a panic on a tape; see below |
//! | `svd`, `symmetric_eigen`, `schur`, `eigenvalues` | the largest entry, entries beside the diagonal, the length of a column | NaN or a panic on a tape; see below. Use [`symmetric_eigen`], [`singular_values`] |
//! | `Matrix::angle`, `balance_parlett_reinsch` | the length of a vector | NaN on a tape. Use [`angle`] |
//! | `sinc`, `sinhc`, `cosc`, `coshc`, `signum` of a complex number | the number | infinite or NaN |
//!
//! # What nalgebra loses
//!
//! In these calls nalgebra returns a wrong derivative, which is finite. The element cannot prevent it.
//!
//! - **Rotations at the identity**, whose length or angle is compared with a tolerance. The derivative is zero for
//!   `new`, `from_scaled_axis`, `scaled_axis`, `ln`, `powf`, `slerp`, `rotation_between`, `scaled_rotation_between` and
//!   `from_matrix` of a `UnitQuaternion`; for `scaled_axis`, `powf`, `slerp`, `rotation_between` and `from_matrix` of a
//!   `Rotation3`, and in forward mode for its `new`; for `from_matrix` of a `Rotation2`; for `exp` and `sinh` of a
//!   `Quaternion` whose imaginary part is zero; for `new` and `lerp_slerp` of an `Isometry3`, `new` of a `Similarity3`,
//!   and `sclerp` of a `UnitDualQuaternion`. Use [`rotation`] and [`rotation_vector`].
//! - **`slerp` of two equal vectors**, and `GivensRotation::new` of two zeros, which is the identity.
//! - **Pivots of zero in forward mode**, along a direction in which the pivot does not move: `lu` of a singular matrix,
//!   with its `determinant` and `solve`.
//! - **Columns of zeros in forward mode**, as in a diagonal, triangular or block matrix: their squared length has no
//!   tangent, so that it counts as a constant zero, and a reflection is left out. First derivatives by entries that are
//!   zero are lost by `eigenvalues` and `schur` of a triangular matrix; by the vectors of `symmetric_eigen`, by
//!   `symmetric_tridiagonalize`, `bidiagonalize`, `svd().solve` and `pseudo_inverse` of a diagonal matrix; and by `qr`
//!   and `col_piv_qr` of a singular matrix.

mod determinant;
mod eigen;
mod exponential;
mod field;
mod linear;
mod parameters;
mod rotation;
mod drivers;

pub use super::element::Element;
pub use determinant::{determinant, log_determinant};
pub use drivers::{value_and_gradient, value_and_jacobian, value_gradient_hessian};
pub use eigen::{
    EigenGroup, EigenPair, NoDerivative, singular_values, symmetric_eigen, symmetric_eigen_groups,
};
pub use exponential::exp;
pub use linear::{inverse, solve};
pub use rotation::{angle, rotation, rotation_vector, vector};
