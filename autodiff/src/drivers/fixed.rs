//! Gradients and Jacobians of functions of a few arguments, whose number is fixed. They use no memory from the system.

use crate::dual::Dual;
use crate::forward::seeded;
use crate::real::Real;

/// Returns the value and the gradient at `x`, by one forward pass that computes all derivatives together. Nothing is
/// allocated. Up to some twenty arguments this is the fastest way to a gradient.
///
/// ```
/// use autodiff::{Real, value_and_gradient_array};
///
/// let (value, gradient) = value_and_gradient_array(|&[x, y]| x * y.exp(), [2.0, 0.0]);
/// assert_eq!((value, gradient), (2.0, [1.0, 2.0]));
/// ```
#[inline]
pub fn value_and_gradient_array<R: Real, const N: usize>(
    function: impl FnOnce(&[Dual<R, N>; N]) -> Dual<R, N>,
    x: [R; N],
) -> (R, [R; N]) {
    let y = function(&seeded(x));
    (y.value, y.tangent)
}

/// Returns the values and the Jacobian at `x`, by one forward pass that computes all columns together. The Jacobian has
/// one row per value and one column per argument. Nothing is allocated.
///
/// ```
/// use autodiff::{Real, value_and_jacobian_array};
///
/// let (point, jacobian) =
///     value_and_jacobian_array(|&[r, angle]| [r * angle.cos(), r * angle.sin()], [2.0, 0.0]);
/// assert_eq!((point, jacobian), ([2.0, 0.0], [[1.0, 0.0], [0.0, 2.0]]));
/// ```
#[inline]
pub fn value_and_jacobian_array<R: Real, const N: usize, const M: usize>(
    function: impl FnOnce(&[Dual<R, N>; N]) -> [Dual<R, N>; M],
    x: [R; N],
) -> ([R; M], [[R; N]; M]) {
    let y = function(&seeded(x));
    (y.map(|y| y.value), y.map(|y| y.tangent))
}
