//! The trait [`Real`]: the number type that generic code is written against.
//!
//! Code over `R: Real` runs unchanged on plain floats, on dual numbers, on the reverse tape and in SIMD lanes. In
//! lanes, an `if` cannot decide differently for each lane. So the code must not branch on a value: it computes a mask
//! and calls [`select`](Real::select).
//!
#![doc = include_str!("kinks.md")]

mod composed;
pub(crate) mod gamma;

use std::any::Any;
use std::fmt::Debug;
use std::iter::{Product, Sum};
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use num_traits::{One, Zero};

use crate::dual::Dual;
use crate::elementary::{Elementary, elementary_methods, functions};
pub use crate::literal::{Accepts, Literal};
pub use crate::mask::Mask;

/// The real numbers of generic code. The [module](self) describes the derivatives at kinks.
///
/// Constants are made by [`lit`](crate::lit). They carry no derivative and are not recorded. Where a method
/// [accepts](Accepts) a second number, a float will do: `x.max(0.0)`, `x.powf(2.5)`, `x.less(1.0)`. These comparisons
/// only use the primal.
///
/// `is_zero` of the supertrait `Zero` tells whether the number is the additive identity, so that work on it can be
/// skipped. For lanes it is true if all of them are zero. For a number that carries a derivative it is false, even if
/// the primal is zero. The same holds for `is_one` and for `==` with a constant. So do not branch on a value with
/// `if x.is_zero()`, although it compiles. The [pitfalls](crate::guide#pitfalls) show what to write instead.
///
/// Other crates may implement the trait for their own numbers. Within a major version, new methods have defaults. A
/// new function is a new variant of [`Elementary`], whose [`value`](Elementary::value) works for any number.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a number type that can be differentiated: it does not implement `Real`",
    note = "write `1.0`, not `1`; for two constants `lit(2.0 * 3.0)`; for an `Element` its field `.0`"
)]
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
    + Accepts<Self>
    + Accepts<f64>
    + Accepts<Literal>
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
    /// If lanes differ, and in a kernel whose derivatives are emitted by `autodiff_programs`.
    fn primal(self) -> f64;

    // Comparison.

    /// Compares: `self < other`. The result is false if either number is NaN.
    fn less<T>(self, other: T) -> Self::Mask
    where
        Self: Accepts<T>;
    /// Compares: `self <= other`. The result is false if either number is NaN.
    fn less_equal<T>(self, other: T) -> Self::Mask
    where
        Self: Accepts<T>;
    /// Returns whether the primal is neither infinite nor NaN.
    #[inline(always)]
    #[track_caller]
    fn finite(self) -> Self::Mask {
        self.abs().less(f64::INFINITY)
    }
    /// Returns `if_true` where the mask is true, and `if_false` elsewhere. The operand that is not chosen passes no
    /// derivative, even if its partials are infinite.
    fn select(mask: Self::Mask, if_true: Self, if_false: Self) -> Self;

    // Elementary functions.

    /// Returns `self * factor + term`. Scalars round the product and the sum. SIMD lanes round only once if the instruction
    /// set has a fused multiply-add.
    #[inline(always)]
    #[track_caller]
    fn fma(self, factor: Self, term: Self) -> Self {
        self * factor + term
    }
    /// Returns `self * factor`, where the factor is a constant.
    #[inline(always)]
    #[track_caller]
    fn scale(self, factor: f64) -> Self {
        self * Self::lit(factor)
    }
    /// `1 / self`.
    #[inline(always)]
    #[track_caller]
    fn recip(self) -> Self {
        Self::one() / self
    }
    /// Returns the square root.
    fn sqrt(self) -> Self;
    /// Returns `1 / sqrt(self)`, computed by a square root and a division. The result has the same bits on every
    /// instruction set, because the processor's approximate instruction is not used.
    #[inline(always)]
    #[track_caller]
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
    #[track_caller]
    fn sin_cos(self) -> (Self, Self) {
        (self.sin(), self.cos())
    }
    /// Returns the tangent of an angle in radians.
    #[inline(always)]
    #[track_caller]
    fn tan(self) -> Self {
        self.sin() / self.cos()
    }
    /// Returns the hyperbolic tangent.
    fn tanh(self) -> Self;
    /// Returns the same value `y` as [`tanh`](Real::tanh), with the slope `1 - y^2`. Layers of programs, recorded by
    /// `dense_tanh`, have this slope, because their reverse sweep knows only `y`. For arguments beyond 10 it loses digits,
    /// and beyond 19 it is 0.
    #[inline(always)]
    #[track_caller]
    fn layer_tanh(self) -> Self {
        self.tanh()
    }
    /// Returns the angle of the point `(x, self)`, in radians: the inverse tangent of `self / x` in the point's
    /// quadrant.
    fn atan2<T>(self, x: T) -> Self
    where
        Self: Accepts<T>;
    /// Returns the power with an integer exponent.
    fn powi(self, exponent: i32) -> Self;
    /// Returns the power with a real exponent. The base must not be negative.
    fn powf<T>(self, exponent: T) -> Self
    where
        Self: Accepts<T>;
    /// Returns the value of an [`Elementary`] function. There is also a separate method for each of these functions.
    fn elementary(self, function: Elementary) -> Self;
    /// Returns the inverse tangent, which is between `-pi/2` and `pi/2`.
    #[inline(always)]
    #[track_caller]
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
    fn max<T>(self, bound: T) -> Self
    where
        Self: Accepts<T>,
    {
        let bound = Self::accept(bound);
        Self::select(self.less_equal(bound), bound, self)
    }
    /// Returns the smaller one of `self` and `bound`. If they are equal, returns the bound.
    #[inline(always)]
    fn min<T>(self, bound: T) -> Self
    where
        Self: Accepts<T>,
    {
        let bound = Self::accept(bound);
        Self::select(bound.less_equal(self), bound, self)
    }
    /// Limits `self` to `[lo, hi]`. At a bound and beyond, the result is the bound itself. If `lo > hi`, the result is
    /// `hi`.
    #[inline(always)]
    fn clamp<L, H>(self, lo: L, hi: H) -> Self
    where
        Self: Accepts<L> + Accepts<H>,
    {
        self.max(lo).min(hi)
    }
    /// Returns `sqrt(self^2 + other^2)`. Before they are squared, both numbers are divided by the larger magnitude, so
    /// that the squares neither overflow nor underflow.
    #[inline(always)]
    #[track_caller]
    fn hypot<T>(self, other: T) -> Self
    where
        Self: Accepts<T>,
    {
        let (zero, x, y) = (Self::zero(), self.abs(), Self::accept(other).abs());
        let scale = x.max(y);
        let (a, b) = (x / scale, y / scale);
        let length = scale * (a * a + b * b).sqrt();
        // At the origin and at infinity `length` is NaN. The sum of the magnitudes is the right result there, and it is
        // NaN if either number is.
        let divides = zero.less(scale) & scale.finite();
        Self::select(divides, length, x + y)
    }

    /// Returns `self * ln(y)`, a term of an entropy, and 0 where `self` is 0 unless `y` is NaN.
    #[inline(always)]
    #[track_caller]
    fn xlogy<T>(self, y: T) -> Self
    where
        Self: Accepts<T>,
    {
        let (y, zero) = (Self::accept(y), Self::zero());
        let plain = self * y.ln();
        let held = y.detach();
        let inside = zero.less(held) & held.finite() & held.recip().finite();
        let at_end = !inside & held.less_equal(held) & self.detach().abs().less_equal(zero);
        if Self::Mask::IS_SINGLE && !at_end.any() {
            return plain;
        }
        Self::select(at_end, zero.straight_through(self * held.ln()), plain)
    }

    /// Returns the logarithm of the beta function of two positive numbers `a` and `b`, which is
    /// `ln_gamma(a) + ln_gamma(b) - ln_gamma(a + b)`. That formula loses its digits if a number is large, and this
    /// method does not (A. R. DiDonato and A. H. Morris, "Algorithm 708", ACM Transactions on Mathematical Software
    /// 18, 1992). It is infinite if a number is 0, and NaN if one is negative.
    #[inline(always)]
    #[track_caller]
    fn ln_beta<T>(self, b: T) -> Self
    where
        Self: Accepts<T>,
    {
        composed::ln_beta(self, Self::accept(b))
    }

    // Derivatives.

    /// Returns the same value as a constant, without derivatives.
    fn detach(self) -> Self;
    /// Returns the value of `self` with the derivative of `soft`. This is the straight-through estimator; the module
    /// [`custom`](crate::custom) has an example.
    fn straight_through(self, soft: Self) -> Self;
    /// Returns `partial * cotangent`, or zero if the cotangent is exactly zero, even if the partial is infinite. In
    /// forward mode the second factor is a tangent. Every chain rule of this crate uses this product.
    fn chain(partial: Self, cotangent: Self) -> Self;
    /// Returns `term + chain(partial, cotangent)`. It is rounded like [`fma`](Real::fma).
    #[inline(always)]
    #[track_caller]
    fn chain_add(partial: Self, cotangent: Self, term: Self) -> Self {
        term + Self::chain(partial, cotangent)
    }

    // Functions of slices. The default implementations are loops, because closures might be compiled without the
    // instruction set of the lanes.

    /// Returns the sum of `a_i b_i`, added from first to last. It is one entry on the reverse tape. `b` may be a slice
    /// of floats.
    ///
    /// The rounding error grows with the number `n` of terms: it is at most `n` times half the distance from 1 to the
    /// next number (6e-8 in `f32`, 1.1e-16 in `f64`), relative to the sum of all `|a_i b_i|`. A million equal terms may
    /// be 1 % off in `f32`. For long slices of `f32` give the products to [`sum_of`](Real::sum_of).
    #[inline(always)]
    #[track_caller]
    fn dot<T: Copy>(a: &[Self], b: &[T]) -> Self
    where
        Self: Accepts<T>,
    {
        assert_eq!(a.len(), b.len(), "dot: the slices differ in length");
        let mut sum = Self::zero();
        for i in 0..a.len() {
            sum = a[i].fma(Self::accept(b[i]), sum);
        }
        sum
    }
    /// Returns the sum of a slice. It is one entry on the reverse tape, while the `sum` of an iterator makes one entry
    /// for each term. Up to 128 terms are added from first to last. More are added by sixteens, and so are the sums, so
    /// that the rounding error hardly grows with the number of terms.
    #[inline(always)]
    #[track_caller]
    fn sum_of(terms: &[Self]) -> Self {
        composed::sum_of(terms)
    }
    /// Returns the Euclidean length of a slice. Squares of long and short slices neither overflow nor underflow. More than
    /// 128 squares are added by parts, as in [`sum_of`](Real::sum_of).
    #[inline(always)]
    #[track_caller]
    fn norm(x: &[Self]) -> Self {
        composed::norm(x)
    }
    /// Returns the logarithm of the sum of `e^x_i`, without overflow. Its slopes are the softmax of the slice. More than
    /// 128 powers are added by parts, as in [`sum_of`](Real::sum_of).
    ///
    /// ```
    /// use autodiff::{Real, Var, gradient};
    ///
    /// assert_eq!(gradient(Var::logsumexp, &[900.0, 900.0, -900.0]), [0.5, 0.5, 0.0]);
    /// ```
    #[inline(always)]
    #[track_caller]
    fn logsumexp(x: &[Self]) -> Self {
        composed::logsumexp(x)
    }
    /// Evaluates a [`Fused`] function. The reverse tape records one call of it, with an entry for each output.
    #[track_caller]
    fn fused<F: Fused>(function: F, inputs: &[&[Self]]) -> Vec<Self> {
        function.eval(inputs)
    }
    /// Runs `work` with the widest lanes that this machine has for this number type. For floats these are SIMD
    /// registers. For any other type the lane is the number itself.
    #[inline(always)]
    fn vectorize<V: Vectorized<Self>>(work: V) -> V::Output {
        work.run::<Self>()
    }
    /// Whether kernels of programs are compiled for this number type in SIMD lanes only. On a processor without these
    /// lanes, programs replay recordings of the kernels.
    #[doc(hidden)]
    const KERNELS_NEED_LANES: bool = false;
    /// Whether this number type is `f64` or `f32`.
    #[doc(hidden)]
    const IS_FLOAT: bool = false;
}

/// Returns that of two functions for `f64` and for `f32` which has the type `T`. If generic code calls it where
/// [`IS_FLOAT`](Real::IS_FLOAT) is true, its crate compiles the two functions, and not each crate that uses the code.
#[doc(hidden)]
#[inline(always)]
pub fn of_floats<T: Copy + 'static>(double: impl Any, single: impl Any) -> T {
    let both: [&dyn Any; 2] = [&double, &single];
    let found = both
        .into_iter()
        .find_map(|function| function.downcast_ref());
    *found.expect("one of the functions has the type")
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

    /// The folder of the sources of the function's crate. A [trace](crate::trace) gives operations there the line of the
    /// call. Nothing for a function of a user.
    #[doc(hidden)]
    const SOURCES: &'static str = "";

    /// Returns the outputs.
    #[track_caller]
    fn eval<R: Real>(&self, inputs: &[&[R]]) -> Vec<R>;

    /// Returns the outputs with their tangents. The default calls `eval` on duals. Override it if the function's
    /// derivative is not the derivative of the code of `eval`.
    #[track_caller]
    fn forward<R: Real, const N: usize>(&self, inputs: &[&[Dual<R, N>]]) -> Vec<Dual<R, N>> {
        self.eval(inputs)
    }

    /// Returns the outputs, and the numbers that [`reverse`](Fused::reverse) needs.
    #[track_caller]
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
    /// Loads the first `N` scalars of a slice. Panics if it is shorter.
    #[track_caller]
    fn load(from: &[S]) -> Self;
    /// Writes all lanes to the first `N` entries of a slice. Panics if it is shorter.
    #[track_caller]
    fn store(self, to: &mut [S]);
    /// Loads a slice that is shorter than `N` into the first lanes. The other lanes are zero. Panics if it is longer.
    #[track_caller]
    fn load_part(from: &[S]) -> Self;
    /// Writes the first lanes to a slice that is shorter than `N`. Panics if it is longer.
    #[track_caller]
    fn store_part(self, to: &mut [S]);
    /// Returns the mask that is true in lane `k` where bit `k` is set.
    fn mask(bits: u16) -> Self::Mask;
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
/// use autodiff::simd::{Lane, Vectorized, kernel};
/// use autodiff::{Dual, Real};
///
/// /// The slopes of `x^3` at many points.
/// struct Slopes<'a>(&'a [f64]);
///
/// #[kernel]
/// impl Vectorized<f64> for Slopes<'_> {
///     type Output = Vec<f64>;
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
    #[doc(hidden)]
    const USE_THE_ATTRIBUTE_KERNEL: ();
    /// The type of the result.
    type Output;
    /// Whether the work is also compiled for scalars where a number type [has lanes](Real::KERNELS_NEED_LANES).
    #[doc(hidden)]
    const HAS_SCALARS: bool = true;
    /// Whether the work is also compiled for registers of 512 bits (AVX-512 on x86-64), where optimised builds have them.
    #[doc(hidden)]
    const HAS_512: bool = true;
    /// Does the work in lanes of type `L`. Mark all functions that it calls with the attribute
    /// [`kernel`](macro@crate::simd::kernel), which the implementation needs too.
    fn run<L: Lane<S>>(self) -> Self::Output;
}
