//! The type [`Element`], which wraps a number for the generic code of other crates.

use crate::real::Real;

/// Wraps a [`Real`] and implements the traits that the generic code of other crates needs. See the [module](super).
#[derive(Clone, Copy, Debug)]
pub struct Element<R>(
    /// The wrapped number.
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
