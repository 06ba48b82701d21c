//! The type of a constant that [`lit`](crate::lit) makes in generic code, and the arguments that methods accept.

/// A constant that [`lit`](crate::lit) makes. It can stand on either side of an operator in code over any
/// [`Real`](crate::Real).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Literal(#[doc(hidden)] pub f64);

mod sealed {
    /// The types of arguments: numbers and literals.
    pub trait Argument {}

    /// The supertrait that seals [`Accepts`](super::Accepts). A bound on `T` there would have to be repeated in every
    /// method that accepts a `T`.
    pub trait Takes<T> {}

    impl<N, T: Argument> Takes<T> for N {}
}

pub(crate) use sealed::Argument;
use sealed::Takes;

impl Argument for Literal {}

/// Number types whose methods accept an argument of type `T`.
///
/// Every [`Real`](crate::Real) accepts its own type, a float, and a [`Literal`]. So a constant needs no conversion:
///
/// ```
/// use autodiff::{Real, gradient};
///
/// fn penalty<R: Real>(x: &[R]) -> R {
///     x[0].max(0.0).powf(1.5) + x[1].clamp(-1.0, 1.0) + R::dot(x, &[2.0, 3.0])
/// }
/// assert_eq!(gradient(penalty, &[4.0, 5.0]), [5.0, 3.0]);
/// ```
///
/// A number type of another crate implements this trait only for `f64`. The trait is sealed: an argument is a number or a
/// literal.
///
/// ```compile_fail
/// use autodiff::Var;
/// use autodiff::real::Accepts;
///
/// struct Degrees(f64);
/// impl Accepts<Degrees> for Var<f64> {
///     fn accept(angle: Degrees) -> Self {
///         Var::constant(angle.0.to_radians())
///     }
/// }
/// ```
#[diagnostic::on_unimplemented(
    message = "a method of `{Self}` does not accept an argument of type `{T}`",
    label = "not accepted as an argument",
    note = "it accepts another `{Self}`, a float such as `2.0`, or `lit(2.0)`"
)]
pub trait Accepts<T>: Takes<T> {
    /// Converts an argument to this number type.
    fn accept(argument: T) -> Self;
}
