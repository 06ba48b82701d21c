//! Numbers of this crate in the generic code of other crates.
//!
//! [`Element`] wraps any [`Real`](crate::Real). It implements num-traits' `Float`, `Num`, `NumAssign`, `Signed` and
//! `FromPrimitive`, and with the feature `nalgebra` also nalgebra's `RealField`. One wrapper serves all number types.
//! So code over `R: Real` can call code over `Float`, and every driver can run it.
//!
//! ```
//! use autodiff::{Element, hessian};
//! use num_traits::Float;
//!
//! /// Code that knows nothing of derivatives.
//! fn logistic<T: Float>(x: T) -> T {
//!     T::one() / (T::one() + (-x).exp())
//! }
//!
//! assert_eq!(hessian(|x| logistic(Element(x[0])).0, &[0.0]), [[0.0]]); // its point of inflection
//! ```
//!
//! # Complex numbers
//!
//! A complex number over elements has derivatives with respect to real numbers. The type is that of num-complex, which
//! nalgebra re-exports; its `exp`, `sqrt`, `norm` and other functions work too. The derivative of an analytic function
//! with respect to its complex argument is the derivative of the result with respect to the real part of the argument.
//!
//! ```
//! use nalgebra::Complex;
//! use autodiff::{Element, Real, gradient};
//!
//! /// The current through a resistor, an inductor and a capacitor in series at 1 volt, by frequency and capacity.
//! fn current<R: Real>(x: &[R]) -> R {
//!     let [frequency, capacity, one] = [Element(x[0]), Element(x[1]), Element::lit(1.0)];
//!     let reactance = frequency * Element::lit(0.5) - one / (frequency * capacity);
//!     Complex::new(one, reactance).inv().norm().0
//! }
//!
//! // At resonance the current is largest.
//! assert_eq!((current(&[2.0, 0.5]), gradient(current, &[2.0, 0.5])), (1.0, vec![0.0, 0.0]));
//! assert!(gradient(current, &[3.0, 0.5])[0] < -0.1);
//! ```
//!
//! Slopes and second derivatives are right off the axes, on both axes, and on both sides of a cut. There, the side is
//! that whose value the function returns, by the sign of a zero. At a branch point they are infinite or NaN, and so are
//! those of `norm` and `arg` at 0. At a pole the value itself is. `powf`, and nalgebra's
//! `powi`, are NaN at 0 even where the slope is finite; num-complex's `powi` is right there. num-complex 0.4.6 loses
//! derivatives, and returns a slope of 0 that should be infinite, in two cases:
//!
//! - `powc` of a base of 0 returns a constant. Use `powf`.
//! - `sqrt` and `cbrt` of a number `i x` at `x = 0`, whose real part is a constant 0 or does not move along the
//!   direction of forward mode. They take `abs` of the imaginary part, which is flat there. The inverse functions
//!   contain such a root at their branch points.
//!
//! # What to know
//!
//! - Comparisons on which code branches (`<`, `is_nan`, the choice of pivots) look at primals. They panic if lanes
//!   disagree. The derivative is that of the branch that was taken.
//! - An element that carries a derivative is not zero, not one, and not equal to a constant, whatever its value
//!   ([pitfalls](crate::guide#pitfalls)). Code of other crates that takes a shortcut at an exact value takes the general
//!   path instead. So num-complex's roots, which treat the axes separately, keep the slopes across the axes. The general
//!   path may divide by zero: then the result is infinite or NaN.
//! - An element does not convert to a primitive number, because that would lose the derivative silently:
//!   `ToPrimitive` returns `None` and `integer_decode` panics. To get only the value, take the primal of the field
//!   `.0`. Constants convert to elements by `T::from`.
//! - Rounding functions have the derivative 0, because they are constant between their steps. `x % m` has the
//!   derivative of `x - q m`, where the integer quotient `q` is constant.
//! - `mul_add` rounds twice for scalars, as [`Real::fma`](crate::Real::fma) does.
//! - `max`, `min` and `clamp` follow the table in [`real`](crate::real). Unlike the methods of floats they pass on a
//!   NaN of `self`, as in `Element(f64::NAN).max(Element(1.0))`. They ignore a bound that is NaN.

mod element;
mod functions;
mod number;
mod constants;
mod float;
#[cfg(feature = "nalgebra")]
pub mod matrices;

pub use element::Element;
