//! The trait [`Real`]: what generic numerical code may ask of a number.
//!
//! Code written over `R: Real` runs unchanged as plain floating point, as dual numbers, on the
//! reverse tape and in SIMD lanes. Because one source serves lanes too, it must not branch on a
//! value with `if`; it computes a mask and [`select`](Real::select)s.
//!
//! # Conventions at kinks
//!
//! Where a function has no derivative, every mode of this crate takes the value below. "Bound"
//! means the other operand, which passes its own derivative. `tests/kinks.rs` has a test per row.
//!
//! | function | where | derivative by the argument |
//! | --- | --- | --- |
//! | `abs(x)` | `x = 0` | 0 |
//! | `signum(x)` | everywhere | 0, and `signum(0) = 0` |
//! | `x.max(bound)` | `x = bound` | 0: the value and the derivative are the bound's |
//! | `x.min(bound)` | `x = bound` | 0: the value and the derivative are the bound's |
//! | `x.clamp(lo, hi)` | at and beyond a bound | 0: the value and the derivative are the bound's |
//! | `select(m, a, b)` | everywhere | that of the chosen operand; the other passes nothing |
//! | `sqrt(x)`, `rsqrt(x)`, `ln(x)`, `1/x` | `x = 0` | infinite: the limit from inside the domain, also at -0 (but `rsqrt(-0)` is -infinity itself) |
//! | `sqrt(x)`, `rsqrt(x)`, `ln(x)` | `x < 0` | NaN, as the value is |
//! | [`Elementary`] functions | at an end of the domain; `cbrt` at 0 | infinite: the limit from inside |
//! | [`Elementary`] functions | outside the domain | NaN, as the value is |
//! | any function | forward: the tangent is exactly 0 | 0, even where the partial is infinite or NaN |
//! | any function | reverse: the cotangent is 0 because of a *choice* | 0, even where the partial is infinite or NaN |
//! | any function | reverse on the tape: the cotangent was *computed* and is 0 | NaN where the partial is infinite or NaN, unless a partial of 0 further back stops it |
//! | `hypot(x, y)` | `x = y = 0` | 0 by both |
//! | `hypot(x, y)` | either is infinite | NaN by an infinite one, 0 by the other |
//! | `powi(x, 0)` | everywhere | 0 |
//! | `powf(x, y)` | `x = 0` | by `x`: the limit of `y x^(y-1)`; by `y`: 0 |
//! | `atan2(y, x)` | `x = y = 0`, and where either is infinite | 0 by both |
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
//! A cotangent is 0 because of a choice in four cases: `select`, `max`, `min`, `clamp` or an `if` took
//! another operand; the number passes through `abs` at 0 or `powi(x, 0)`; it is multiplied by a constant
//! factor of 0, such as a mask that `select` made; or the caller gives 0. Any other zero was computed: a
//! number underflowed, a partial is 0, or terms cancelled. A computed zero times an infinite partial is
//! unknown, so the tape returns NaN, as forward mode does: `1 / (1 / x)` at 0 has the slope 1, but its
//! partials are infinity and 0 and do not determine it. A partial of 0 further back stops the NaN, as it
//! stops a tangent: `sqrt(x * x)^2` at 0 has the slope 0.
//!
//! The order of zero and infinity still matters. The slope of `0 * sqrt(x)` at 0 is 0 in reverse
//! mode and NaN in forward mode. For `sqrt(x * x)` it is the other way round.
//!
//! Sweeps over lanes do not tell the two zeros apart. In a [`Program`](crate::Program), in
//! [`data`](crate::data), in [emitted](crate::emit) code and on tapes of lanes, both zeros stop an infinity.
//! A slope of 0 may then hide an overflow, also between [`Fused`] functions. In these cases forward mode
//! disagrees: [`check_gradient`](crate::check::check_gradient) reports the gradient as wrong, and
//! [`first_non_finite`](crate::trace::first_non_finite) names the operation. A kernel without an emitted
//! [`vjp`](crate::Kernel::vjp) uses forward mode for its cotangents and follows the rules of forward mode. In
//! the matrix products of a program, a zero cotangent times an infinite number is NaN.
//!
//! # Second derivatives at kinks
//!
//! Second derivatives differentiate the rows of the table above literally, in all four nestings of modes:
//! the derivative of a chosen 0 is 0. So a smooth function of a kink may have a wrong second derivative.
//! Write the smooth function directly instead: `x * x + y * y`. `tests/kinks.rs` has a test per row.
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

/// A method for each [`Elementary`] function.
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

/// A real number as generic code sees it. See the [module](self) for the conventions at kinks.
///
/// Constants enter through [`lit`](crate::lit); they carry no derivative and are not recorded. Comparisons look at
/// the primal alone.
///
/// `is_zero`, of the supertrait `Zero`, is no comparison: it asks whether the number is the additive
/// identity, so that work on it may be left out. Lanes are if all of them are zero; a number that
/// carries a derivative is not, whatever its primal. `if x.is_zero()` compiles and is wrong; the
/// pitfalls of the [crate](crate#pitfalls) show what to write in its place.
///
/// Other crates may implement the trait for numbers of their own. Within a major version a new method
/// comes with a default, and a new function is one more name in [`Elementary`], whose
/// [`value`](Elementary::value) serves any number.
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
    /// What a comparison returns.
    type Mask: Mask;

    /// A constant.
    fn lit(value: f64) -> Self;
    /// Constants, as the unknowns that a solver returns are for
    /// [`implicit::root`](crate::implicit::root).
    fn lits(values: &[f64]) -> Vec<Self> {
        values.iter().map(|&value| Self::lit(value)).collect()
    }
    /// The primal as a float, for code that is not differentiated: a solver whose solution enters by
    /// [`implicit::root`](crate::implicit::root), a table, a message. Nothing of a derivative is left in
    /// it.
    ///
    /// # Panics
    /// If lanes differ, and in a kernel whose derivatives are [emitted](crate::emit).
    fn primal(self) -> f64;

    // Comparison.

    /// `self < other`, false where either is NaN.
    fn less(self, other: Self) -> Self::Mask;
    /// `self <= other`, false where either is NaN.
    fn less_equal(self, other: Self) -> Self::Mask;
    /// Whether the primal is neither infinite nor NaN.
    fn finite(self) -> Self::Mask {
        self.abs().less(Self::lit(f64::INFINITY))
    }
    /// `if_true` where the mask holds, else `if_false`. The operand that is not chosen passes no
    /// derivative, whatever its own partials are.
    fn select(mask: Self::Mask, if_true: Self, if_false: Self) -> Self;

    // Elementary functions.

    /// `self * factor + term`; one rounding where the instruction set in use has it.
    #[inline(always)]
    fn fma(self, factor: Self, term: Self) -> Self {
        self * factor + term
    }
    /// `self * factor`, by a constant, of which no derivative is asked.
    #[inline(always)]
    fn scale(self, factor: f64) -> Self {
        self * Self::lit(factor)
    }
    /// `1 / self`.
    #[inline(always)]
    fn recip(self) -> Self {
        Self::one() / self
    }
    /// Square root.
    fn sqrt(self) -> Self;
    /// `1 / sqrt(self)`, by a root and a division, not by a processor's estimate: the same bits at every
    /// instruction set.
    #[inline(always)]
    fn rsqrt(self) -> Self {
        self.sqrt().recip()
    }
    /// Exponential.
    fn exp(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// Sine of an angle in radians.
    fn sin(self) -> Self;
    /// Cosine of an angle in radians.
    fn cos(self) -> Self;
    /// Tangent of an angle in radians.
    #[inline(always)]
    fn tan(self) -> Self {
        self.sin() / self.cos()
    }
    /// Hyperbolic tangent.
    fn tanh(self) -> Self;
    /// The hyperbolic tangent of [`Program::dense_tanh`](crate::Program::dense_tanh): the value of
    /// [`tanh`](Real::tanh) with the slope `1 - y^2`, where `y` is the result. A reverse sweep over a
    /// layer knows only `y`. For arguments beyond 10 the slope loses digits; beyond 19 it is 0.
    #[inline(always)]
    fn layer_tanh(self) -> Self {
        self.tanh()
    }
    /// Inverse tangent of `self / x`, in the quadrant of the point `(x, self)`.
    fn atan2(self, x: Self) -> Self;
    /// Integer power.
    fn powi(self, exponent: i32) -> Self;
    /// Real power of a non-negative base.
    fn powf(self, exponent: Self) -> Self;
    /// One of the [`Elementary`] functions by its name; each has a method too.
    fn elementary(self, function: Elementary) -> Self;
    /// Inverse tangent, between `-pi/2` and `pi/2`.
    #[inline(always)]
    fn atan(self) -> Self {
        self.atan2(Self::one())
    }
    functions!(elementary_methods);
    /// Absolute value.
    fn abs(self) -> Self;
    /// -1, 0 or 1: unlike `f64::signum`, zero at zero.
    #[inline(always)]
    fn signum(self) -> Self {
        let (zero, one) = (Self::zero(), Self::one());
        let negative = Self::select(self.less(zero), -one, self.detach() * zero);
        Self::select(zero.less(self), one, negative)
    }
    /// The larger of `self` and `bound`; at a tie the bound.
    #[inline(always)]
    fn max(self, bound: Self) -> Self {
        Self::select(self.less_equal(bound), bound, self)
    }
    /// The smaller of `self` and `bound`; at a tie the bound.
    #[inline(always)]
    fn min(self, bound: Self) -> Self {
        Self::select(bound.less_equal(self), bound, self)
    }
    /// `self` within `[lo, hi]`; at and beyond a bound the bound. Where `lo > hi` it is `hi`.
    #[inline(always)]
    fn clamp(self, lo: Self, hi: Self) -> Self {
        self.max(lo).min(hi)
    }
    /// `sqrt(self^2 + other^2)`. Divided by the larger magnitude first, so that the squares neither
    /// overflow nor vanish.
    #[inline(always)]
    fn hypot(self, other: Self) -> Self {
        let (zero, x, y) = (Self::zero(), self.abs(), other.abs());
        let scale = x.max(y);
        let (a, b) = (x / scale, y / scale);
        let length = scale * (a * a + b * b).sqrt();
        // At the origin and at infinity that is NaN; the sum is right there, and NaN for NaN.
        let divides = zero.less(scale) & scale.finite();
        Self::select(divides, length, x + y)
    }

    // Derivatives.

    /// The same primal without any derivative: a constant from here on.
    fn detach(self) -> Self;
    /// The value of `self` with the derivative of `soft` (straight-through).
    ///
    /// ```
    /// use autodiff::{Dual, Real};
    ///
    /// /// 1 above zero, else 0; it learns like a sigmoid.
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
    /// `partial * cotangent`, where an exactly zero cotangent (or tangent) gives zero even if the
    /// partial is infinite. Every chain rule of this crate multiplies with it.
    fn chain(partial: Self, cotangent: Self) -> Self;
    /// `term + chain(partial, cotangent)`; one rounding where the instruction set in use has it.
    #[inline(always)]
    fn chain_add(partial: Self, cotangent: Self, term: Self) -> Self {
        term + Self::chain(partial, cotangent)
    }

    // Slices: one fused operation where the mode has one.

    // The defaults are loops, not closures: lanes keep their instruction set in them.

    /// `sum of a_i b_i`, from first to last.
    #[inline(always)]
    fn dot(a: &[Self], b: &[Self]) -> Self {
        assert_eq!(a.len(), b.len(), "dot: the slices differ in length");
        let mut sum = Self::zero();
        for i in 0..a.len() {
            sum = a[i].fma(b[i], sum);
        }
        sum
    }
    /// The sum of a slice, from first to last: on the reverse tape one entry, where the `sum` of an
    /// iterator makes one for each term.
    #[inline(always)]
    fn sum_of(terms: &[Self]) -> Self {
        let mut sum = Self::zero();
        for &term in terms {
            sum += term;
        }
        sum
    }
    /// Evaluates a [`Fused`] function; on the reverse tape it becomes one entry.
    fn fused<F: Fused>(function: F, inputs: &[&[Self]]) -> Vec<Self> {
        function.eval(inputs)
    }
    /// Runs `work` with the widest lanes that this machine has for this type: floats in SIMD
    /// registers; for any other type the lane is the number itself.
    #[inline(always)]
    fn vectorize<V: Vectorized<Self>>(work: V) -> V::Output {
        work.run::<Self>()
    }
    /// Calls the method of `work` that is for this type.
    #[inline(always)]
    fn by_type<W: ByType>(work: W, of: W::Of<Self>) -> W::Output<Self> {
        work.other(of)
    }
}

/// Work that plain floats have a function of their own for; see [`Real::by_type`]. The choice is made
/// at compile time: for a float the generic code is not compiled.
pub trait ByType {
    /// The argument, for a number type.
    type Of<R: Real>;
    /// What the work returns.
    type Output<R: Real>;
    /// Does the work for `f64`.
    fn f64(self, of: Self::Of<f64>) -> Self::Output<f64>;
    /// Does the work for `f32`.
    fn f32(self, of: Self::Of<f32>) -> Self::Output<f32>;
    /// Does the work for any other type.
    fn other<R: Real>(self, of: Self::Of<R>) -> Self::Output<R>;
}

/// A function of several slices that is differentiated as a whole.
///
/// Plain numbers call [`eval`](Fused::eval), duals [`forward`](Fused::forward). The reverse tape
/// calls [`record`](Fused::record) and, once in each reverse sweep that reaches it,
/// [`reverse`](Fused::reverse), with its inner number type for `R`. All of them must describe the
/// same function. A function with one output and known partials is shorter as a
/// [`Rule`](crate::custom::Rule).
///
/// Where derivatives nest, `R` carries a derivative itself. A function whose derivative is not that of
/// its `eval` must hand its own rule on to that layer: its `forward` and `record` take the outputs
/// from [`Real::fused`] of a copy of itself, called on the numbers inside.
pub trait Fused: Send + 'static {
    /// What `record` keeps for `reverse`.
    type Saved<R: Real>: Send;

    /// The outputs alone.
    fn eval<R: Real>(&self, inputs: &[&[R]]) -> Vec<R>;

    /// The outputs with their tangents; by default, `eval` on duals. Override it where the function's
    /// derivative is not the derivative of `eval`'s code.
    fn forward<R: Real, const N: usize>(&self, inputs: &[&[Dual<R, N>]]) -> Vec<Dual<R, N>> {
        self.eval(inputs)
    }

    /// The outputs, and the numbers that [`reverse`](Fused::reverse) will need.
    fn record<R: Real>(&self, inputs: &[&[R]]) -> (Vec<R>, Self::Saved<R>);

    /// The cotangents of the inputs, given the outputs' cotangents `y_bar`: one vector per input slice, in
    /// their order. Where `wanted` is false the slice is constant and its vector may be left empty.
    fn reverse<R: Real>(
        &self,
        saved: &mut Self::Saved<R>,
        y_bar: &[R],
        wanted: &[bool],
    ) -> Vec<Vec<R>>;
}

/// A number type that holds `N` scalars of type `S`, one a lane.
pub trait Lane<S>: Real {
    /// How many scalars.
    const N: usize;
    /// The same scalar in every lane.
    fn splat(value: S) -> Self;
    /// The first `N` scalars of a slice.
    fn load(from: &[S]) -> Self;
    /// Writes the lanes to the first `N` places of a slice.
    fn store(self, to: &mut [S]);
    /// All of a slice shorter than `N`, then zeros.
    fn load_part(from: &[S]) -> Self;
    /// Fills a slice shorter than `N`.
    fn store_part(self, to: &mut [S]);
    /// The mask that is true in lane `k` where bit `k` is set.
    fn mask(bits: u16) -> Self::Mask;
    /// Moves the first lanes, in order, to the places of the set bits; zeros elsewhere.
    fn expand(self, bits: u16) -> Self;
    /// Moves the lanes at the places of the set bits, in order, to the first places; then zeros.
    fn compress(self, bits: u16) -> Self;
    /// The lanes of both interleaved: `self[0], other[0], self[1], ...`, the first `N` and the last `N`.
    fn zip(self, other: Self) -> [Self; 2];

    /// The [`layer_tanh`](Real::layer_tanh) of each number. SIMD lanes compute them in parallel because
    /// they are independent.
    #[inline(always)]
    fn tanh_each<const K: usize>(mut x: [Self; K]) -> [Self; K] {
        for k in 0..K {
            x[k] = x[k].layer_tanh();
        }
        x
    }

    /// The first `N` scalars of a slice, or all of a shorter one, then zeros.
    #[inline(always)]
    fn load_up_to(from: &[S]) -> Self {
        if from.len() >= Self::N {
            Self::load(from)
        } else {
            Self::load_part(from)
        }
    }
    /// Writes the lanes, as many as the slice has places for.
    #[inline(always)]
    fn store_up_to(self, to: &mut [S]) {
        if to.len() >= Self::N {
            self.store(to)
        } else {
            self.store_part(to)
        }
    }
}

/// Work that is written for any lane width; see [`Real::vectorize`]. Lanes are numbers like any other,
/// also inside duals and on a tape:
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
    /// What the work returns.
    type Output;
    /// Does the work in lanes of type `L`. Mark implementations, and all that they call,
    /// `#[inline(always)]`: only then is the code compiled for the instruction set it is entered with.
    fn run<L: Lane<S>>(self) -> Self::Output;
}
