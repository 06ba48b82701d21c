//! The dual number of forward mode. Its arithmetic is in `forward`.

use crate::operators::by_primal;

/// A value and its tangents along `N` directions at once.
///
/// Duals nest: `Dual<Dual<f64, 1>, 1>` carries second derivatives. `==`, `<` and
/// [`Real::less`](crate::Real::less) compare primals. [`Zero::is_zero`](num_traits::Zero::is_zero) also looks
/// at the tangents.
///
/// ```
/// use autodiff::{Dual, Real};
///
/// let x = Dual::<f64, 1>::variable(2.0, 0);
/// let y = x * x.ln();
/// assert_eq!(y.tangent[0], 2.0_f64.ln() + 1.0);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Dual<R, const N: usize> {
    /// The primal: the value without derivatives.
    pub value: R,
    /// One tangent per direction.
    pub tangent: [R; N],
}

by_primal! { [, const N: usize] Dual<R, N> }
