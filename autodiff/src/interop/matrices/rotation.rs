//! Vectors and rotations of elements, and the angles between them.

use nalgebra::{DVector, Dim, Matrix, Quaternion, RawStorage, U1, UnitQuaternion, Vector3};

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
/// use nalgebra::Vector3;
/// use autodiff::matrices::{Element, rotation};
/// use autodiff::{Real, Var, gradient};
///
/// /// The height of a rotated point.
/// fn height(x: &[Var<f64>]) -> Var<f64> {
///     let point = Vector3::new(1.0, 2.0, 3.0).map(Element::<Var<f64>>::lit);
///     (rotation(&Vector3::new(x[0], x[1], x[2]).map(Element)) * point)[2].0
/// }
/// assert_eq!(gradient(height, &[0.0; 3]), [2.0, -1.0, 0.0]);
/// ```
#[track_caller]
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
#[track_caller]
fn series<R: Real>(square: R, odd: u8) -> R {
    (1..=12).rev().fold(R::one(), |rest, term| {
        let factor = f64::from(2 * term + odd);
        R::one() - square / R::lit(factor * (factor - 1.0)) * rest
    })
}

/// Returns the vector of a rotation: its axis, as long as its angle in radians, which is at most pi. It is the inverse
/// of [`rotation`]. Its derivatives of every order are correct, even at the identity. At a half turn it jumps to the
/// opposite vector.
///
/// ```
/// use nalgebra::Vector3;
/// use autodiff::matrices::{Element, rotation, rotation_vector};
///
/// let vector = Vector3::new(0.0, 0.5, 0.0).map(Element);
/// assert_eq!(rotation_vector(&rotation(&vector))[1].0, 0.5);
/// ```
#[track_caller]
pub fn rotation_vector<R: Real>(rotation: &UnitQuaternion<Element<R>>) -> Vector3<Element<R>> {
    let one = R::one();
    let coordinates = [0, 1, 2, 3].map(|k| rotation.coords[k].0);
    // A quaternion and its negative are the same rotation.
    let sign = R::select(coordinates[3].less(0.0), -one, one);
    let [i, j, k, cos] = coordinates.map(|x| x * sign);
    let square = i * i + j * j + k * k;
    let ratio = square / (cos * cos);
    // For small angles `atan(t) / t` is the series 1 - t^2/3 + t^4/5 - …, whose omitted terms are less than 1e-33.
    let small = ratio.less(0.0625);
    let ratio = R::select(small, ratio, R::zero());
    let series = (0..27).rev().fold(R::zero(), |rest, k| {
        R::lit(f64::from(2 * k + 1)).recip() - ratio * rest
    });
    let sin = R::select(small, one, square).sqrt();
    let by_series = series / R::select(small, cos, one);
    let factor = R::select(small, by_series, sin.atan2(cos) / sin) * R::lit(2.0);
    let [i, j, k] = [i, j, k].map(|x| Element(factor * x));
    Vector3::new(i, j, k)
}

/// Returns the angle between two vectors of equal length, in radians. Small angles and angles near pi keep their digits
/// (W. Kahan, "Miscalculating area and angles of a needle-like triangle", 2014). The slope is 0 where the vectors are
/// parallel, where the angle has a kink, and where one of them is 0.
///
/// ```
/// use nalgebra::Vector2;
/// use autodiff::matrices::{Element, angle};
///
/// let [a, b] = [[1.0, 0.0], [1.0, 1e-9]].map(|x| Vector2::from(x).map(Element));
/// assert_eq!(angle(&a, &b).0, 1e-9);
/// ```
///
/// # Panics
/// If the vectors differ in length.
#[track_caller]
pub fn angle<R: Real, D: Dim>(
    a: &Matrix<Element<R>, D, U1, impl RawStorage<Element<R>, D, U1>>,
    b: &Matrix<Element<R>, D, U1, impl RawStorage<Element<R>, D, U1>>,
) -> Element<R> {
    assert_eq!(a.len(), b.len(), "angle: the vectors differ in length");
    let numbers = |x: &mut dyn Iterator<Item = &Element<R>>| x.map(|x| x.0).collect::<Vec<R>>();
    let [a, b] = [numbers(&mut a.iter()), numbers(&mut b.iter())];
    // Both vectors become as long as their product, so that they are the sides of a rhombus.
    let [of_a, of_b] = [R::norm(&a), R::norm(&b)];
    let sides = || a.iter().zip(&b).map(|(&a, &b)| (a * of_b, b * of_a));
    let difference: Vec<R> = sides().map(|(a, b)| a - b).collect();
    let sum: Vec<R> = sides().map(|(a, b)| a + b).collect();
    Element(R::norm(&difference).atan2(R::norm(&sum)) * R::lit(2.0))
}
