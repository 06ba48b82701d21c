//! The exponential of a matrix.

use nalgebra::DMatrix;

use super::super::element::Element;
use crate::real::Real;

/// The coefficients of the Padé approximation of the exponential with degrees 13 and 13.
const PADE: [f64; 14] = [
    64764752532480000.0,
    32382376266240000.0,
    7771770303897600.0,
    1187353796428800.0,
    129060195264000.0,
    10559470521600.0,
    670442572800.0,
    33522128640.0,
    1323241920.0,
    40840800.0,
    960960.0,
    16380.0,
    182.0,
    1.0,
];

/// Returns the exponential of a square matrix, by scaling and squaring (N. J. Higham, "The scaling and squaring method
/// for the matrix exponential revisited", SIAM Journal on Matrix Analysis and Applications 26, 2005). nalgebra's own
/// `exp` converts norms to floats, which an [`Element`] refuses.
///
/// ```
/// use nalgebra::DMatrix;
/// use autodiff::matrices::{Element, exp};
/// use autodiff::{Var, gradient};
///
/// // The exponential of an angle times [[0, -1], [1, 0]] is a rotation.
/// let sine = |x: &[Var<f64>]| {
///     let (angle, zero) = (Element(x[0]), Element::lit(0.0));
///     exp(&DMatrix::from_row_slice(2, 2, &[zero, -angle, angle, zero]))[(1, 0)].0
/// };
/// assert!((gradient(sine, &[0.5])[0] - 0.5_f64.cos()).abs() < 1e-15);
/// ```
///
/// # Panics
/// If the matrix is not square, has an infinite or NaN entry, or if the SIMD lanes of its norm differ.
#[track_caller]
pub fn exp<R: Real>(matrix: &DMatrix<Element<R>>) -> DMatrix<Element<R>> {
    let (n, columns) = matrix.shape();
    assert!(
        n == columns,
        "the exponential needs a square matrix, found {n} x {columns}"
    );
    let entries: Vec<R> = matrix.iter().map(|x| x.0.detach()).collect();
    let norm = R::norm(&entries).primal();
    assert!(
        norm.is_finite(),
        "the exponential needs finite entries; the norm is {norm}"
    );
    // For a norm of at most 1 the approximation has 31 digits.
    let halvings = norm.max(1.0).log2().ceil() as i32;
    let a = matrix * Element::lit(2f64.powi(-halvings));
    let [even, odd] = [0, 1].map(|first| polynomial(&(&a * &a), first));
    let odd = a * odd;
    let quotient = (&even - &odd).lu().solve(&(even + odd));
    let mut power = quotient.expect("the denominator is invertible for norms of at most 1");
    for _ in 0..halvings {
        power = &power * &power;
    }
    power
}

/// Returns the polynomial in `square` whose coefficients are every second number of [`PADE`], from `first` on.
#[track_caller]
fn polynomial<R: Real>(square: &DMatrix<Element<R>>, first: usize) -> DMatrix<Element<R>> {
    let n = square.nrows();
    let mut sum = DMatrix::zeros(n, n);
    for &coefficient in PADE[first..].iter().step_by(2).rev() {
        sum = square * sum + DMatrix::from_diagonal_element(n, n, Element::lit(coefficient));
    }
    sum
}
