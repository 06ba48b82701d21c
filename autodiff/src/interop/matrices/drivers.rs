//! Drivers for functions of nalgebra's vectors.

use nalgebra::{DMatrix, DVector, Scalar};

use super::super::element::Element;
use super::rotation::vector;
use crate::drivers::{self, CHUNK, WIDE};
use crate::dual::Dual;
use crate::real::Real;
use crate::reverse::Var;

/// A vector of numbers of forward mode.
type Forward<R> = DVector<Element<Dual<R, WIDE>>>;

/// A vector of numbers of forward over reverse mode.
type Nested<R> = DVector<Element<Var<Dual<R, CHUNK>>>>;

/// Returns the value and the gradient of a function of a vector, by one reverse sweep.
///
/// ```
/// use nalgebra::DVector;
/// use autodiff::matrices::value_and_gradient;
///
/// let x = DVector::from(vec![3.0, 4.0]);
/// let (value, gradient) = value_and_gradient(|x| 0.5 * x.norm_squared(), &x);
/// assert_eq!((value, gradient), (12.5, x));
/// ```
#[track_caller]
pub fn value_and_gradient<R: Real + Scalar>(
    function: impl FnOnce(DVector<Element<Var<R>>>) -> Element<Var<R>>,
    x: &DVector<R>,
) -> (R, DVector<R>) {
    let (value, gradient) = drivers::value_and_gradient(|x| function(vector(x)).0, x.as_slice());
    (value, gradient.into())
}

/// Returns the values and the Jacobian of a function of a vector, with one row per value and one column per argument.
///
/// ```
/// use nalgebra::{DMatrix, DVector};
/// use autodiff::matrices::value_and_jacobian;
///
/// let x = DVector::from(vec![3.0, 4.0]);
/// let (values, jacobian) = value_and_jacobian(|x| x.component_mul(&x), &x);
/// assert_eq!(values, DVector::from(vec![9.0, 16.0]));
/// assert_eq!(jacobian, DMatrix::from_row_slice(2, 2, &[6.0, 0.0, 0.0, 8.0]));
/// ```
#[track_caller]
pub fn value_and_jacobian<R: Real + Scalar>(
    function: impl Fn(Forward<R>) -> Forward<R>,
    x: &DVector<R>,
) -> (DVector<R>, DMatrix<R>) {
    let numbers = |x: &[_]| function(vector(x)).iter().map(|y| y.0).collect();
    let (values, jacobian) = drivers::value_and_jacobian(numbers, x.as_slice());
    (values.into(), jacobian.into())
}

/// Returns the value, the gradient and the Hessian of a function of a vector.
///
/// ```
/// use nalgebra::DVector;
/// use autodiff::matrices::value_gradient_hessian;
///
/// let x = DVector::from(vec![1.0, 2.0]);
/// let (value, gradient, hessian) = value_gradient_hessian(|x| x[0] * x[0] * x[1], &x);
/// assert_eq!((value, gradient), (2.0, DVector::from(vec![4.0, 1.0])));
/// assert_eq!(hessian.as_slice(), [4.0, 2.0, 2.0, 0.0]);
/// ```
#[track_caller]
pub fn value_gradient_hessian<R: Real + Scalar>(
    function: impl Fn(Nested<R>) -> Element<Var<Dual<R, CHUNK>>>,
    x: &DVector<R>,
) -> (R, DVector<R>, DMatrix<R>) {
    let number = |x: &[_]| function(vector(x)).0;
    let (value, gradient, hessian) = drivers::value_gradient_hessian(number, x.as_slice());
    (value, gradient.into(), hessian.into())
}
