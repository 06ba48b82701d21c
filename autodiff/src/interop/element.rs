//! The wrapper of numbers for other crates.

use crate::real::Real;

/// A [`Real`] with the traits that other crates need. See the [module](super).
#[derive(Clone, Copy, Debug)]
pub struct Element<R>(
    /// The number itself.
    pub R,
);

impl<R: Real> Element<R> {
    /// Makes a constant.
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
