//! A constant in generic code.

/// A constant for either side of an operator in code over any [`Real`](crate::Real), made by
/// [`lit`](crate::lit).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Literal(pub(crate) f64);
