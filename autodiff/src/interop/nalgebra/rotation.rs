//! Makes vectors and rotations of elements from slices and vectors of numbers.

use ::nalgebra::{DVector, Quaternion, UnitQuaternion, Vector3};

use super::super::element::Element;
use crate::real::Real;

/// Converts a slice of numbers to a vector of elements.
pub fn vector<R: Real>(numbers: &[R]) -> DVector<Element<R>> {
    DVector::from_iterator(numbers.len(), numbers.iter().copied().map(Element))
}

/// Returns the rotation about the axis `vector`. The angle in radians is the length of `vector`. Its derivatives of every
/// order are correct, even at the zero vector.
///
/// ```
/// use ::nalgebra::Vector3;
/// use autodiff::nalgebra::{Element, rotation};
/// use autodiff::{Real, Var, gradient};
///
/// /// The height of a rotated point.
/// fn height(x: &[Var<f64>]) -> Var<f64> {
///     let point = Vector3::new(1.0, 2.0, 3.0).map(Element::<Var<f64>>::lit);
///     (rotation(&Vector3::new(x[0], x[1], x[2]).map(Element)) * point)[2].0
/// }
/// assert_eq!(gradient(height, &[0.0; 3]), [2.0, -1.0, 0.0]);
/// ```
pub fn rotation<R: Real>(vector: &Vector3<Element<R>>) -> UnitQuaternion<Element<R>> {
    let half = [0, 1, 2].map(|axis| vector[axis].0 * R::lit(0.5));
    let square = half[0] * half[0] + half[1] * half[1] + half[2] * half[2];
    // For half angles below 1/4 rad, the terms that the series omits are less than 1e-38.
    let small = square.less(R::lit(0.0625));
    let angle = R::select(small, R::one(), square).sqrt();
    let cos = R::select(small, series(square, 0), angle.cos());
    let sinc = R::select(small, series(square, 1), angle.sin() / angle);
    let [i, j, k] = [0, 1, 2].map(|axis| Element(sinc * half[axis]));
    UnitQuaternion::new_unchecked(Quaternion::new(Element(cos), i, j, k))
}

/// Returns `cos(x)` if `odd` is 0, or `sin(x) / x` if `odd` is 1. `square` is `x^2`. The result is the sum of the first
/// terms of the power series.
fn series<R: Real>(square: R, odd: u8) -> R {
    (1..=12).rev().fold(R::one(), |rest, term| {
        let factor = f64::from(2 * term + odd);
        R::one() - square / R::lit(factor * (factor - 1.0)) * rest
    })
}
