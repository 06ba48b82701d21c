//! The trait [`Real`]: the number type that generic code is written against.
//!
//! Code over `R: Real` runs unchanged on plain floats, on dual numbers, on the reverse tape and in SIMD lanes. In
//! lanes, an `if` cannot decide differently for each lane. So the code must not branch on a value: it computes a mask
//! and calls [`select`](Real::select).
//!
//! # Conventions at kinks
//!
//! Where a function has no derivative, every mode of this crate uses the value in this table. "Bound" means the
//! other operand, which passes its own derivative. `tests/kinks.rs` has a test for each row.
//!
//! | function | where | derivative with respect to the argument |
//! | --- | --- | --- |
//! | `abs(x)` | `x = 0` | 0 |
//! | `signum(x)` | everywhere | 0, and `signum(0) = 0` |
//! | `x.max(bound)` | `x = bound` | 0: the value and the derivative are those of the bound |
//! | `x.min(bound)` | `x = bound` | 0: the value and the derivative are those of the bound |
//! | `x.clamp(lo, hi)` | at and beyond a bound | 0: the value and the derivative are those of the bound |
//! | `select(m, a, b)` | everywhere | the derivative of the chosen operand; the other operand passes nothing |
//! | `sqrt(x)`, `rsqrt(x)`, `ln(x)`, `1/x` | `x = 0` | infinite: the limit from inside the domain, also at -0 (but `rsqrt(-0)` is -infinity itself) |
//! | `sqrt(x)`, `rsqrt(x)`, `ln(x)` | `x < 0` | NaN, like the value |
//! | [`Elementary`] functions | at an end of the domain; `cbrt` at 0 | infinite: the limit from inside |
//! | [`Elementary`] functions | outside the domain | NaN, like the value |
//! | any function | forward: the tangent is exactly 0 | 0, even where the partial is infinite or NaN |
//! | any function | reverse: the cotangent is 0 because of a *choice* | 0, even where the partial is infinite or NaN |
//! | any function | reverse on the tape: the cotangent was *computed* and is 0 | NaN where the partial is infinite or NaN, unless a partial of 0 further back stops it |
//! | `hypot(x, y)` | `x = y = 0` | 0 with respect to both |
//! | `hypot(x, y)` | either is infinite | NaN with respect to an infinite one, 0 with respect to a finite one |
//! | `powi(x, 0)` | everywhere | 0 |
//! | `powf(x, y)` | `x = 0` | with respect to `x`: the limit of `y x^(y-1)`; with respect to `y`: 0 |
//! | `atan2(y, x)` | `x = y = 0`, and where either is infinite | 0 with respect to both |
//! | any function but `powi(x, 0)`, `powf(x, 0)` and `powf(1, y)`, which are 1 | the argument is NaN | NaN, like the value |
//! | sums, differences, products with a constant, `select` | the argument is NaN | the constant slope of the linear function; the value is NaN |
//! | `x.max(bound)`, `x.min(bound)`, `x.clamp(lo, hi)`, `powi(x, 1)` in lanes, as in a kernel | `x` is NaN | 1; the value is NaN |
//! | `max`, `min`, `clamp` | a bound is NaN | the bound is ignored: a bound is taken to be a number |
//!
//! Second derivatives of `powf` where `x = 0` follow from these rows one by one, and depend on the order
//! in which they are taken.
//!
//! # Zero times infinity
//!
//! A cotangent is 0 because of a choice in four cases: `select`, `max`, `min`, `clamp` or an `if` chose another
//! operand; the number passes through `abs` at 0 or `powi(x, 0)`; the number is multiplied by a constant factor of 0,
//! such as a mask from `select`; or the caller passes 0. Any other zero was computed: a number underflowed, a partial
//! is 0, or terms cancelled. A computed zero times an infinite partial is unknown, so the tape returns NaN, as forward
//! mode does. For example `1 / (1 / x)` at 0 has the slope 1, but its partials are infinity and 0 and do not determine
//! the slope. A partial of 0 further back stops the NaN, as it stops a tangent: `sqrt(x * x)^2` at 0 has the slope 0.
//!
//! It still matters which a mode meets first, the zero or the infinity. The slope of `0 * sqrt(x)` at 0 is 0 in reverse
//! mode and NaN in forward mode. For `sqrt(x * x)` it is the other way round.
//!
//! Sweeps over lanes do not distinguish chosen and computed zeros. In a [`Program`](crate::Program), in
//! [`data`](crate::data), in [emitted](crate::emit) code and on tapes of lanes, both zeros stop an infinity. A slope of
//! 0 may then hide an overflow, also between [`Fused`] functions. Forward mode gives another result in these cases:
//! [`check_gradient`](crate::check::check_gradient) reports the gradient as wrong, and
//! [`first_non_finite`](crate::trace::first_non_finite) names the operation. A kernel without an emitted
//! [`vjp`](crate::Kernel::vjp) uses forward mode for its cotangents and follows the rules of forward mode. In the
//! matrix products of a program, a zero cotangent times an infinite number is NaN.
//!
//! # Second derivatives at kinks
//!
//! A second derivative is the derivative of the first derivative in the table above, in all four nestings of modes.
//! Where the table says 0, the second derivative is 0 too. So if a smooth function is composed of functions with kinks,
//! its second derivative may be wrong. Write the smooth function directly instead: `x * x + y * y`. `tests/kinks.rs`
//! has a test per row.
//!
//! | function | where | second derivative |
//! | --- | --- | --- |
//! | `abs(x)^2`, `hypot(x, y)^2` | at 0 | 0; the correct value is 2 |
//! | `x.max(0)^2`, `x.min(0)^2` | at 0 | 0, the second derivative of the bound |
//! | `sqrt(x * x)^2`, `sqrt(x * x + y * y)^2` | at 0 | NaN; the correct value is 2 |

use std::fmt::Debug;
use std::iter::{Product, Sum};
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use num_traits::{One, Zero};

use crate::dual::Dual;
use crate::elementary::{Elementary, functions};
pub use crate::literal::Literal;
pub use crate::mask::Mask;

/// Defines a method for each [`Elementary`] function.
macro_rules! elementary_methods {
    (
        basic { $($_basic:tt)* }
        composed {
            $($method:ident $Function:ident $about:literal: |$_x:ident| $_value:expr, |$_of:ident, $_y:ident| $_partial:expr;)*
        }
    ) => {
        $(
            #[doc = $about]
            #[inline(always)]
            fn $method(self) -> Self {
                self.elementary(Elementary::$Function)
            }
        )*
    };
}

/// The real numbers of generic code. The [module](self) describes the derivatives at kinks.
///
/// Constants are made by [`lit`](crate::lit). They carry no derivative and are not recorded. Comparisons only use the
/// primal.
///
/// `is_zero` of the supertrait `Zero` is not a comparison. It tells whether the number is the additive identity, so
/// that work on it can be skipped. For lanes it is true if all of them are zero. For a number that carries a derivative
/// it is false, even if the primal is zero. So do not branch on a value with `if x.is_zero()`, although it compiles.
/// The pitfalls of the [crate](crate#pitfalls) show what to write instead.
///
/// Other crates may implement the trait for their own numbers. Within a major version, new methods have defaults. A
/// new function is a new variant of [`Elementary`], whose [`value`](Elementary::value) works for any number.
pub trait Real:
    Copy
    + Debug
    + Send
    + Sync
    + 'static
    + Zero
    + One
    + Sub<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + DivAssign
    + Add<Literal, Output = Self>
    + Sub<Literal, Output = Self>
    + Mul<Literal, Output = Self>
    + Div<Literal, Output = Self>
    + AddAssign<Literal>
    + SubAssign<Literal>
    + MulAssign<Literal>
    + DivAssign<Literal>
    + Sum
    + Product
    + for<'a> Sum<&'a Self>
    + for<'a> Product<&'a Self>
{
    /// The type of the result of a comparison.
    type Mask: Mask;

    /// Makes a constant.
    fn lit(value: f64) -> Self;
    /// Makes constants, for example from the solution that a solver returns to
    /// [`implicit::root`](crate::implicit::root).
    fn lits(values: &[f64]) -> Vec<Self> {
        values.iter().map(|&value| Self::lit(value)).collect()
    }
    /// Returns the primal as a float. Use it in code that is not differentiated, for example in a solver whose solution
    /// goes to [`implicit::root`](crate::implicit::root), to look up a table, or to write a message.
    ///
    /// # Panics
    /// If lanes differ, and in a kernel whose derivatives are [emitted](crate::emit).
    fn primal(self) -> f64;

    // Comparison.

    /// Compares: `self < other`. The result is false if either number is NaN.
    fn less(self, other: Self) -> Self::Mask;
    /// Compares: `self <= other`. The result is false if either number is NaN.
    fn less_equal(self, other: Self) -> Self::Mask;
    /// Returns whether the primal is neither infinite nor NaN.
    fn finite(self) -> Self::Mask {
        self.abs().less(Self::lit(f64::INFINITY))
    }
    /// Returns `if_true` where the mask is true, and `if_false` elsewhere. The operand that is not chosen passes no
    /// derivative, even if its partials are infinite.
    fn select(mask: Self::Mask, if_true: Self, if_false: Self) -> Self;

    // Elementary functions.

    /// Returns `self * factor + term`. It is rounded only once if the instruction set has a fused multiply-add.
    #[inline(always)]
    fn fma(self, factor: Self, term: Self) -> Self {
        self * factor + term
    }
    /// Returns `self * factor`, where the factor is a constant.
    #[inline(always)]
    fn scale(self, factor: f64) -> Self {
        self * Self::lit(factor)
    }
    /// `1 / self`.
    #[inline(always)]
    fn recip(self) -> Self {
        Self::one() / self
    }
    /// Returns the square root.
    fn sqrt(self) -> Self;
    /// Returns `1 / sqrt(self)`, computed by a square root and a division. The result has the same bits on every
    /// instruction set, because the processor's approximate instruction is not used.
    #[inline(always)]
    fn rsqrt(self) -> Self {
        self.sqrt().recip()
    }
    /// Returns the exponential.
    fn exp(self) -> Self;
    /// Returns the natural logarithm.
    fn ln(self) -> Self;
    /// Returns the sine of an angle in radians.
    fn sin(self) -> Self;
    /// Returns the cosine of an angle in radians.
    fn cos(self) -> Self;
    /// Returns the sine and the cosine. On floats this takes as long as one of them.
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        (self.sin(), self.cos())
    }
    /// Returns the tangent of an angle in radians.
    #[inline(always)]
    fn tan(self) -> Self {
        self.sin() / self.cos()
    }
    /// Returns the hyperbolic tangent.
    fn tanh(self) -> Self;
    /// Returns the hyperbolic tangent with the derivative that it has in
    /// [`Program::dense_tanh`](crate::Program::dense_tanh). The value `y` is that of [`tanh`](Real::tanh). The slope is
    /// computed as `1 - y^2`, because a reverse sweep over a layer knows only `y`. For arguments beyond 10 this slope
    /// loses digits, and beyond 19 it is 0.
    #[inline(always)]
    fn layer_tanh(self) -> Self {
        self.tanh()
    }
    /// Returns the angle of the point `(x, self)`, in radians: the inverse tangent of `self / x` in the point's
    /// quadrant.
    fn atan2(self, x: Self) -> Self;
    /// Returns the power with an integer exponent.
    fn powi(self, exponent: i32) -> Self;
    /// Returns the power with a real exponent. The base must not be negative.
    fn powf(self, exponent: Self) -> Self;
    /// Returns the value of an [`Elementary`] function. There is also a separate method for each of these functions.
    fn elementary(self, function: Elementary) -> Self;
    /// Returns the inverse tangent, which is between `-pi/2` and `pi/2`.
    #[inline(always)]
    fn atan(self) -> Self {
        self.atan2(Self::one())
    }
    functions!(elementary_methods);
    /// Returns the absolute value.
    fn abs(self) -> Self;
    /// Returns the sign: -1, 0 or 1. Unlike `f64::signum` it is 0 at 0.
    #[inline(always)]
    fn signum(self) -> Self {
        let (zero, one) = (Self::zero(), Self::one());
        let negative = Self::select(self.less(zero), -one, self.detach() * zero);
        Self::select(zero.less(self), one, negative)
    }
    /// Returns the larger one of `self` and `bound`. If they are equal, returns the bound.
    #[inline(always)]
    fn max(self, bound: Self) -> Self {
        Self::select(self.less_equal(bound), bound, self)
    }
    /// Returns the smaller one of `self` and `bound`. If they are equal, returns the bound.
    #[inline(always)]
    fn min(self, bound: Self) -> Self {
        Self::select(bound.less_equal(self), bound, self)
    }
    /// Limits `self` to `[lo, hi]`. At a bound and beyond, the result is the bound itself. If `lo > hi`, the result is
    /// `hi`.
    #[inline(always)]
    fn clamp(self, lo: Self, hi: Self) -> Self {
        self.max(lo).min(hi)
    }
    /// Returns `sqrt(self^2 + other^2)`. Before they are squared, both numbers are divided by the larger magnitude, so
    /// that the squares neither overflow nor underflow.
    #[inline(always)]
    fn hypot(self, other: Self) -> Self {
        let (zero, x, y) = (Self::zero(), self.abs(), other.abs());
        let scale = x.max(y);
        let (a, b) = (x / scale, y / scale);
        let length = scale * (a * a + b * b).sqrt();
        // At the origin and at infinity `length` is NaN. The sum of the magnitudes is the right result there, and it is
        // NaN if either number is.
        let divides = zero.less(scale) & scale.finite();
        Self::select(divides, length, x + y)
    }

    // Derivatives.

    /// Returns the same value as a constant, without derivatives.
    fn detach(self) -> Self;
    /// Returns the value of `self` with the derivative of `soft`. This is the straight-through estimator.
    ///
    /// ```
    /// use autodiff::{Dual, Real};
    ///
    /// /// 1 above zero and otherwise 0, with the derivative of a sigmoid.
    /// fn gate<R: Real>(x: R) -> R {
    ///     let hard = R::select(R::zero().less(x), R::one(), R::zero());
    ///     let soft = (R::one() + (-x).exp()).recip();
    ///     hard.straight_through(soft)
    /// }
    ///
    /// let y = gate(Dual::<f64, 1>::variable(0.0, 0));
    /// assert_eq!((y.value, y.tangent), (0.0, [0.25]));
    /// ```
    fn straight_through(self, soft: Self) -> Self;
    /// Returns `partial * cotangent`, or zero if the cotangent is exactly zero, even if the partial is infinite. In
    /// forward mode the second factor is a tangent. Every chain rule of this crate uses this product.
    fn chain(partial: Self, cotangent: Self) -> Self;
    /// Returns `term + chain(partial, cotangent)`. It is rounded only once if the instruction set has a fused
    /// multiply-add.
    #[inline(always)]
    fn chain_add(partial: Self, cotangent: Self, term: Self) -> Self {
        term + Self::chain(partial, cotangent)
    }

    // Functions of slices. The default implementations are loops, because closures might be compiled without the
    // instruction set of the lanes.

    /// Returns the sum of `a_i b_i`, added from first to last. It is one entry on the reverse tape.
    #[inline(always)]
    fn dot(a: &[Self], b: &[Self]) -> Self {
        assert_eq!(a.len(), b.len(), "dot: the slices differ in length");
        let mut sum = Self::zero();
        for i in 0..a.len() {
            sum = a[i].fma(b[i], sum);
        }
        sum
    }
    /// Returns the sum of a slice, added from first to last. It is one entry on the reverse tape, while the `sum` of an
    /// iterator makes one entry for each term.
    #[inline(always)]
    fn sum_of(terms: &[Self]) -> Self {
        let mut sum = Self::zero();
        for &term in terms {
            sum += term;
        }
        sum
    }
    /// Evaluates a [`Fused`] function. It is one entry on the reverse tape.
    fn fused<F: Fused>(function: F, inputs: &[&[Self]]) -> Vec<Self> {
        function.eval(inputs)
    }
    /// Runs `work` with the widest lanes that this machine has for this number type. For floats these are SIMD
    /// registers. For any other type the lane is the number itself.
    #[inline(always)]
    fn vectorize<V: Vectorized<Self>>(work: V) -> V::Output {
        work.run::<Self>()
    }
    /// Calls the method of `work` that belongs to this number type.
    #[inline(always)]
    fn by_type<W: ByType>(work: W, of: W::Of<Self>) -> W::Output<Self> {
        work.other(of)
    }
}

/// Work that has separate functions for plain floats; see [`Real::by_type`]. The choice is made at compile time, and
/// the generic function is not compiled for floats.
pub trait ByType {
    /// The type of the argument, for each number type.
    type Of<R: Real>;
    /// The type of the result, for each number type.
    type Output<R: Real>;
    /// Does the work for `f64`.
    fn f64(self, of: Self::Of<f64>) -> Self::Output<f64>;
    /// Does the work for `f32`.
    fn f32(self, of: Self::Of<f32>) -> Self::Output<f32>;
    /// Does the work for any other number type.
    fn other<R: Real>(self, of: Self::Of<R>) -> Self::Output<R>;
}

/// A function of several slices that is differentiated as a whole.
///
/// Plain numbers call [`eval`](Fused::eval) and duals call [`forward`](Fused::forward). The reverse tape calls
/// [`record`](Fused::record) when the function is recorded, and [`reverse`](Fused::reverse) once in each sweep that
/// reaches the function. In these calls `R` is the inner number type of the mode. All methods must describe the same
/// function. For a function with one output and known partials, a [`Rule`](crate::custom::Rule) is shorter.
///
/// In nested derivatives `R` itself carries a derivative, and the function's rule must be used for it too. This matters
/// if the function's derivative is not that of the code of `eval`. Then `forward` and `record` must compute the outputs
/// by [`Real::fused`] on the inner numbers, with a copy of the function.
pub trait Fused: Send + 'static {
    /// The type of the numbers that `record` saves for `reverse`.
    type Saved<R: Real>: Send;

    /// Returns the outputs.
    fn eval<R: Real>(&self, inputs: &[&[R]]) -> Vec<R>;

    /// Returns the outputs with their tangents. The default calls `eval` on duals. Override it if the function's
    /// derivative is not the derivative of the code of `eval`.
    fn forward<R: Real, const N: usize>(&self, inputs: &[&[Dual<R, N>]]) -> Vec<Dual<R, N>> {
        self.eval(inputs)
    }

    /// Returns the outputs, and the numbers that [`reverse`](Fused::reverse) needs.
    fn record<R: Real>(&self, inputs: &[&[R]]) -> (Vec<R>, Self::Saved<R>);

    /// Returns the cotangents of the inputs, given the cotangents `y_bar` of the outputs: one vector for each input
    /// slice, in order. If `wanted` is false for a slice, the slice is constant and its vector may be empty.
    fn reverse<R: Real>(
        &self,
        saved: &mut Self::Saved<R>,
        y_bar: &[R],
        wanted: &[bool],
    ) -> Vec<Vec<R>>;
}

/// A number type that holds `N` scalars of type `S`, one in each lane.
pub trait Lane<S>: Real {
    /// The number of lanes.
    const N: usize;
    /// Returns the same scalar in every lane.
    fn splat(value: S) -> Self;
    /// Loads the first `N` scalars of a slice.
    fn load(from: &[S]) -> Self;
    /// Writes all lanes to the first `N` entries of a slice.
    fn store(self, to: &mut [S]);
    /// Loads a slice that is shorter than `N` into the first lanes. The other lanes are zero.
    fn load_part(from: &[S]) -> Self;
    /// Writes the first lanes to a slice that is shorter than `N`.
    fn store_part(self, to: &mut [S]);
    /// Returns the mask that is true in lane `k` where bit `k` is set.
    fn mask(bits: u16) -> Self::Mask;
    /// Moves the first lanes, in order, to the lanes whose bits are set. The other lanes become zero.
    fn expand(self, bits: u16) -> Self;
    /// Moves the lanes whose bits are set, in order, to the first lanes. The other lanes become zero.
    fn compress(self, bits: u16) -> Self;
    /// Interleaves the lanes of two registers: `self[0], other[0], self[1], ...`. The result is two registers with the
    /// first half and the second half of these lanes.
    fn zip(self, other: Self) -> [Self; 2];

    /// Returns the [`layer_tanh`](Real::layer_tanh) of each number. With SIMD lanes the computations overlap in the
    /// processor, because they do not depend on each other.
    #[inline(always)]
    fn tanh_each<const K: usize>(mut x: [Self; K]) -> [Self; K] {
        for k in 0..K {
            x[k] = x[k].layer_tanh();
        }
        x
    }

    /// Loads the first `N` scalars of a slice. If it is shorter, the other lanes are zero.
    #[inline(always)]
    fn load_up_to(from: &[S]) -> Self {
        if from.len() >= Self::N {
            Self::load(from)
        } else {
            Self::load_part(from)
        }
    }
    /// Writes the lanes to a slice. If it is shorter than `N`, only the first lanes are written.
    #[inline(always)]
    fn store_up_to(self, to: &mut [S]) {
        if to.len() >= Self::N {
            self.store(to)
        } else {
            self.store_part(to)
        }
    }
}

/// Work that can be done in lanes of any width; see [`Real::vectorize`]. Lanes are numbers like any other, also inside
/// duals and on a tape:
///
/// ```
/// use autodiff::simd::{Lane, Vectorized};
/// use autodiff::{Dual, Real};
///
/// /// The slopes of `x^3` at many points.
/// struct Slopes<'a>(&'a [f64]);
///
/// impl Vectorized<f64> for Slopes<'_> {
///     type Output = Vec<f64>;
///     #[inline(always)]
///     fn run<L: Lane<f64>>(self) -> Vec<f64> {
///         let mut slopes = vec![0.0; self.0.len()];
///         for (x, slope) in self.0.chunks(L::N).zip(slopes.chunks_mut(L::N)) {
///             let x = Dual::<L, 1>::variable(L::load_up_to(x), 0);
///             (x * x * x).tangent[0].store_up_to(slope);
///         }
///         slopes
///     }
/// }
///
/// let slopes = f64::vectorize(Slopes(&[0.0, 1.0, 2.0, 3.0, 4.0]));
/// assert_eq!(slopes, [0.0, 3.0, 12.0, 27.0, 48.0]);
/// ```
pub trait Vectorized<S: Real> {
    /// The type of the result.
    type Output;
    /// Does the work in lanes of type `L`. Mark implementations and all functions that they call
    /// `#[inline(always)]`. Otherwise the code is compiled without the instruction set of the lanes.
    fn run<L: Lane<S>>(self) -> Self::Output;
}
