//! The dual number type of forward mode. Its arithmetic is in the module `forward`.

use crate::operators::by_primal;

/// A value, with its derivatives (tangents) along `N` directions.
///
/// Duals nest: `Dual<Dual<f64, 1>, 1>` carries second derivatives. `<` and [`Real::less`](crate::Real::less) compare
/// primals. [`Zero::is_zero`](num_traits::Zero::is_zero) is false unless all tangents are zero too, and a number with
/// a tangent never `==` a constant ([pitfalls](crate::guide#pitfalls)).
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
    /// The value without its tangents. It may carry derivatives of an inner mode.
    pub value: R,
    /// The tangents, one for each direction.
    pub tangent: [R; N],
}

by_primal! { [, const N: usize] Dual<R, N>, |x| !x.tangent.iter().all(R::is_zero) }
