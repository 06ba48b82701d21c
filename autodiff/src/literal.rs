//! The type of a constant that [`lit`](crate::lit) makes in generic code.

/// A constant that [`lit`](crate::lit) makes. It can stand on either side of an operator in code over any
/// [`Real`](crate::Real).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Literal(pub(crate) f64);
