//! The value and the derivative of every elementary function, written once.
//!
//! A rule of one argument returns `(value, partial)`. A rule of two arguments returns `(value, [partial, partial])`,
//! with respect to the first and the second argument. Duals and the reverse tape call the same rules with their inner
//! number type for `R`, so forward, reverse and nested derivatives agree. Where a partial does not exist, the rule
//! follows the table in [`real`](crate::real). If the value is NaN, so is the partial.
//!
//! All modes multiply the partials by [`Real::chain`]. The rules use no closures, because a closure that is not inlined
//! would be compiled without the instruction set of the lanes. They are `#[track_caller]`, so that an inner mode names the
//! line of the caller too.

use crate::real::{Mask, Real};

/// The rule of `a * b`.
#[inline(always)]
#[track_caller]
pub fn mul<R: Real>(a: R, b: R) -> (R, [R; 2]) {
    (a * b, [b, a])
}

/// The rule of `a / b`. The value is computed by one division, so it is bit-identical to that of plain code. The
/// partial with respect to `b` is also computed by a division: the reciprocal of a subnormal `b` may overflow although
/// the quotient does not.
#[inline(always)]
#[track_caller]
pub fn div<R: Real>(a: R, b: R) -> (R, [R; 2]) {
    let quotient = a / b;
    (quotient, [b.recip(), -(quotient / b)])
}

/// The rule of `1 / x`.
#[inline(always)]
#[track_caller]
pub fn recip<R: Real>(x: R) -> (R, R) {
    let value = x.recip();
    (value, -(value * value))
}

/// The rule of the square root. The partial is infinite at 0 and at -0.
#[inline(always)]
#[track_caller]
pub fn sqrt<R: Real>(x: R) -> (R, R) {
    let value = x.sqrt();
    (value, R::lit(0.5) / unsigned_zero(value))
}

/// The rule of `1 / sqrt(x)`.
#[inline(always)]
#[track_caller]
pub fn rsqrt<R: Real>(x: R) -> (R, R) {
    let value = x.rsqrt();
    // At -0 the value is minus infinity. The partial must still be minus infinity, the limit from inside the domain.
    (value, R::lit(-0.5) * value * value * value.abs())
}

/// The rule of the exponential.
#[inline(always)]
#[track_caller]
pub fn exp<R: Real>(x: R) -> (R, R) {
    let value = x.exp();
    (value, value)
}

/// The rule of the natural logarithm. The partial is infinite at zero and NaN below.
#[inline(always)]
#[track_caller]
pub fn ln<R: Real>(x: R) -> (R, R) {
    let value = x.ln();
    let partial = unsigned_zero(x).recip();
    (value, R::select(x.less(R::zero()), value, partial))
}

/// The rule of the sine.
#[inline(always)]
#[track_caller]
pub fn sin<R: Real>(x: R) -> (R, R) {
    x.sin_cos()
}

/// The rule of the cosine.
#[inline(always)]
#[track_caller]
pub fn cos<R: Real>(x: R) -> (R, R) {
    let (sin, cos) = x.sin_cos();
    (cos, -sin)
}

/// The rule of the tangent.
#[inline(always)]
#[track_caller]
pub fn tan<R: Real>(x: R) -> (R, R) {
    let value = x.tan();
    (value, value * value + R::one())
}

/// The rule of the hyperbolic tangent. The partial is `4 e^-2x / (1 + e^-2x)^2`, because `1 - value^2` loses digits if
/// the value is close to 1.
#[inline(always)]
#[track_caller]
pub fn tanh<R: Real>(x: R) -> (R, R) {
    let (value, one) = (x.tanh(), R::one());
    let twice = x + x;
    let power = R::select(x.less(R::zero()), twice, -twice).exp();
    let share = R::lit(2.0) / (one + power);
    let small = x.abs().less(R::lit(0.5));
    let partial = R::select(small, one - value * value, power * share * share);
    (value, partial)
}

/// The rule of the hyperbolic tangent of a layer. The slope is `1 - value^2`, because a layer's reverse sweep knows
/// only the result.
#[inline(always)]
#[track_caller]
pub fn layer_tanh<R: Real>(x: R) -> (R, R) {
    let value = x.layer_tanh();
    (value, (-value).fma(value, R::one()))
}

/// Returns `1 - x^2`. The value is accurate for `x` near 1. The derivative has no factor that is 0 at 1, because in
/// reverse mode its product with an infinite cotangent would be NaN.
#[inline(always)]
#[track_caller]
pub(crate) fn one_minus_square<R: Real>(x: R) -> R {
    let one = R::one();
    let (small, smooth) = (x.abs().less(R::lit(0.5)), one - x * x);
    R::select(small, smooth, (one - x) * (one + x)).straight_through(smooth)
}

/// The rule of the absolute value.
#[inline(always)]
#[track_caller]
pub fn abs<R: Real>(x: R) -> (R, R) {
    (x.abs(), x.signum())
}

/// The rule of an integer power.
#[inline(always)]
#[track_caller]
pub fn powi<R: Real>(x: R, exponent: i32) -> (R, R) {
    if exponent == 0 {
        return (x.powi(0), R::zero());
    }
    let value = x.powi(exponent);
    let one_less = match exponent.checked_sub(1) {
        // `x^0` would be 1 even for NaN. Lanes do not make this distinction.
        Some(0) if R::Mask::IS_SINGLE => R::select(x.less_equal(x), R::one(), x),
        Some(less) => x.powi(less),
        None => value / x,
    };
    (value, R::lit(f64::from(exponent)) * one_less)
}

/// The rule of a power with a real exponent. If the exponent is zero, the partial with respect to `x` is zero at any
/// `x`, because it is computed by `chain`.
///
/// The partial with respect to `x` has two forms. Its value is computed by the quotient, `exponent / x * value`, unless
/// an intermediate result over- or underflows: the power, `exponent * x^(exponent - 1)`, would multiply the rounding
/// error of `exponent - 1` by `ln x`. The derivative of the partial is computed by the power, where `exponent - 1` is a
/// factor: in the derivative of the quotient this factor is a difference whose terms cancel. If the exponent is near 0,
/// they do not cancel and the power may overflow, so there the quotient is differentiated.
#[inline(always)]
#[track_caller]
pub fn powf<R: Real>(x: R, exponent: R) -> (R, [R; 2]) {
    let (value, zero) = (x.powf(exponent), R::zero());
    let power = R::chain(x.powf(exponent - R::one()), exponent);
    let factor = exponent / x;
    let quotient = factor * value;
    let in_range = small::<R>().less(value) & factor.finite() & quotient.finite();
    let near_zero = exponent.abs().less(R::lit(0.5)) & (factor * quotient).finite();
    let moves = R::select(in_range & near_zero, quotient, power);
    let by_x = R::select(in_range, quotient, power).straight_through(moves);
    // Where the power itself is zero, the partial is zero too: the product would be NaN if the logarithm is infinite.
    let at_zero = x.abs().less_equal(zero) | value.abs().less_equal(zero);
    let by_exponent = R::select(at_zero, zero, value * x.ln());
    // If the value is NaN, both partials are NaN. Without this, a NaN would be lost in the zeros above and in `NaN^0`,
    // which is 1.
    let number = value.less_equal(value);
    let by_x = R::select(number, by_x, value);
    (value, [by_x, R::select(number, by_exponent, value)])
}

/// The rule of `atan2(y, x)`. The partials are with respect to `y` and to `x`, and are zero at the origin and at
/// infinity. Both arguments are first divided by the larger magnitude, which counts as a constant, so that the squares
/// neither overflow nor underflow. The derivatives of the partials use the finite inverse of that magnitude.
#[inline(always)]
#[track_caller]
pub fn atan2<R: Real>(y: R, x: R) -> (R, [R; 2]) {
    let (value, zero) = (y.atan2(x), R::zero());
    let scale = y.abs().max(x.abs()).detach();
    let divides = zero.less(scale) & scale.finite();
    let (y, x) = (divided(y, scale), divided(x, scale));
    let (square, inverse) = (x * x + y * y, inverse(scale));
    let denominator = square.detach() * scale;
    // This is 0, or NaN if the value is NaN.
    let flat = value.detach() * zero;
    let by_y = (x.detach() / denominator).straight_through(x / square * inverse);
    let by_x = -(y.detach() / denominator).straight_through(y / square * inverse);
    let by_y = R::select(divides, by_y, flat);
    let by_x = R::select(divides, by_x, flat);
    (value, [by_y, by_x])
}

/// The rule of `sqrt(x^2 + y^2)`. The partials are the cosine and the sine of the direction of `(x, y)`. Their
/// derivatives are those of the unit vector in this direction.
#[inline(always)]
#[track_caller]
pub fn hypot<R: Real>(x: R, y: R) -> (R, [R; 2]) {
    let (value, zero, [cosine, sine]) = (x.hypot(y), R::zero(), direction(x, y));
    let (x, y, length) = (x.detach(), y.detach(), value.detach());
    // A subnormal length has few digits, so it is computed again on a larger scale.
    let (tiny, large) = (value.less(small::<R>()), small::<R>().recip());
    let (a, b) = (x * large, y * large);
    let length = R::select(tiny, (a * a + b * b).sqrt(), length);
    let by_x = (R::select(tiny, a, x) / length).straight_through(cosine);
    let by_y = (R::select(tiny, b, y) / length).straight_through(sine);
    let origin = value.less_equal(zero);
    let by_x = R::select(origin, zero, by_x);
    let by_y = R::select(origin, zero, by_y);
    (value, [by_x, by_y])
}

/// Returns the cosine and the sine of the angle of `(x, y)`, of which only the derivatives are used. They are computed
/// from the ratio of the shorter side to the longer side. The formula `x / sqrt(x^2 + y^2)` would lose digits: its
/// derivative along the longer side is a small difference.
#[inline(always)]
#[track_caller]
fn direction<R: Real>(x: R, y: R) -> [R; 2] {
    let (scale, one) = (x.abs().max(y.abs()).detach(), R::one());
    let (a, b) = (divided(x, scale), divided(y, scale));
    let flat = y.abs().less_equal(x.abs());
    let (longer, shorter) = (R::select(flat, a, b), R::select(flat, b, a));
    let ratio = shorter / longer;
    // After the division the longer side is 1 or -1.
    let of_longer = (one + ratio * ratio).rsqrt() * longer.detach();
    let of_shorter = ratio * of_longer;
    // The factor that is missing from the derivatives of [`divided`].
    let rest = (small::<R>() / scale).max(one);
    let (cosine, sine) = (
        R::select(flat, of_longer, of_shorter),
        R::select(flat, of_shorter, of_longer),
    );
    [cosine * rest, sine * rest]
}

/// Returns `x / scale` for a constant scale above 0. The derivative is always finite, so that a factor of zero makes it
/// zero and not NaN. To keep it finite, the derivative is `1 / small` if the scale is below [`small`].
#[inline(always)]
#[track_caller]
fn divided<R: Real>(x: R, scale: R) -> R {
    (x.detach() / scale).straight_through(x * inverse(scale))
}

/// Returns `1 / scale`, limited to `1 / small`.
#[inline(always)]
#[track_caller]
fn inverse<R: Real>(scale: R) -> R {
    scale.max(small::<R>()).recip()
}

/// Returns a power of two near the smallest normal number of the type. It is `2^-1000` or, for `f32`, `2^-120`.
#[inline(always)]
#[track_caller]
fn small<R: Real>() -> R {
    let small = R::lit(2f64.powi(-1000));
    R::select(R::zero().less(small), small, R::lit(2f64.powi(-120)))
}

/// Returns whether the primal is zero. The result is always false for lanes and for the symbols of recordings.
#[inline(always)]
pub(crate) fn vanishes<R: Real>(x: R) -> bool {
    R::Mask::IS_SINGLE && (x.less_equal(R::zero()) & R::zero().less_equal(x)).all()
}

/// Returns whether the primal is NaN. The result is always false for lanes and for the symbols of recordings.
#[inline(always)]
pub(crate) fn is_nan<R: Real>(x: R) -> bool {
    R::Mask::IS_SINGLE && !x.less_equal(x).any()
}

/// Returns the boolean of a mask if all lanes have the same, and otherwise `None`. Where both operands of a choice are
/// kept, it is always `None`.
#[inline(always)]
pub(crate) fn uniform<M: Mask>(mask: M) -> Option<bool> {
    if M::KEEPS_BOTH {
        return None;
    }
    match (mask.any(), mask.all()) {
        (_, true) => Some(true),
        (false, _) => Some(false),
        _ => None,
    }
}

/// Changes `-0` to `+0`. Limits at zero are taken from inside the domain, which is above zero.
#[inline(always)]
#[track_caller]
fn unsigned_zero<R: Real>(x: R) -> R {
    x + R::zero()
}

/// Implements those methods of [`Real`] that follow from the rules, for a number type over `R` with a field `value`:
///
/// ```text
/// by_rule! {
///     #[inline]
///     |x, name, rule| x.apply(rule),
///     |x, y, name, rule| x.apply2(y, rule),
/// }
/// ```
///
/// The first closure returns the result of an operation with one operand, and the second that of an operation with two. They
/// get the operands, the name of the operation, and what its rule returned. Every method is `#[track_caller]`.
macro_rules! by_rule {
    (
        #[$attribute:meta]
        |$x:ident, $name:pat_param, $rule:ident| $of_one:expr,
        |$y:ident, $z:ident, $name_of_two:pat_param, $rule_of_two:ident| $of_two:expr $(,)?
    ) => {
        $crate::rule::by_rule! {
            @methods #[$attribute]
            |$x, $name, $rule| $of_one,
            |$y, $z, $name_of_two, $rule_of_two| $of_two,
            [recip sqrt rsqrt exp ln sin cos tan tanh layer_tanh] [atan2 powf hypot]
        }
        #[$attribute]
        #[track_caller]
        fn powi(self, exponent: i32) -> Self {
            if exponent == 0 && <R::Mask as $crate::real::Mask>::IS_SINGLE {
                return <Self as num_traits::One>::one();
            }
            let ($x, $name) = (self, "powi");
            let $rule = $crate::rule::powi(self.value, exponent);
            $of_one
        }
        #[$attribute]
        #[track_caller]
        fn elementary(self, function: $crate::elementary::Elementary) -> Self {
            let ($x, $name) = (self, function.name());
            let $rule = function.rule(self.value);
            $of_one
        }
        #[$attribute]
        #[track_caller]
        fn lit(value: f64) -> Self {
            Self::constant(R::lit(value))
        }
        #[$attribute]
        #[track_caller]
        fn primal(self) -> f64 {
            self.value.primal()
        }
        #[$attribute]
        #[track_caller]
        fn less<T>(self, other: T) -> R::Mask
        where
            Self: $crate::real::Accepts<T>,
        {
            self.value.less(Self::accept(other).value)
        }
        #[$attribute]
        #[track_caller]
        fn less_equal<T>(self, other: T) -> R::Mask
        where
            Self: $crate::real::Accepts<T>,
        {
            self.value.less_equal(Self::accept(other).value)
        }
        #[$attribute]
        #[track_caller]
        fn finite(self) -> R::Mask {
            self.value.finite()
        }
    };
    (
        @methods #[$attribute:meta]
        |$x:ident, $name:pat_param, $rule:ident| $of_one:expr,
        |$y:ident, $z:ident, $name_of_two:pat_param, $rule_of_two:ident| $of_two:expr,
        [$($method:ident)*] [$($method_of_two:ident)*]
    ) => {
        $(
            #[$attribute]
            #[track_caller]
            fn $method(self) -> Self {
                let ($x, $name) = (self, stringify!($method));
                let $rule = $crate::rule::$method(self.value);
                $of_one
            }
        )*
        $(
            #[$attribute]
            #[track_caller]
            fn $method_of_two<T>(self, other: T) -> Self
            where
                Self: $crate::real::Accepts<T>,
            {
                let ($y, $z, $name_of_two) =
                    (self, Self::accept(other), stringify!($method_of_two));
                let $rule_of_two = $crate::rule::$method_of_two($y.value, $z.value);
                $of_two
            }
        )*
    };
}

/// Implements those methods of [`Real`] whose result is one of the operands or a constant, for a number type over `R` with
/// a field `value` and a method `apply`. Where a number is NaN, so is the slope of its `max` and `min`.
macro_rules! by_choice {
    (#[$attribute:meta]) => {
        #[$attribute]
        fn max<T>(self, bound: T) -> Self
        where
            Self: $crate::real::Accepts<T>,
        {
            let bound = Self::accept(bound);
            if $crate::rule::is_nan(self.value) {
                return self.apply((self.value.max(bound.value), self.value));
            }
            Self::select(self.less_equal::<Self>(bound), bound, self)
        }
        #[$attribute]
        fn min<T>(self, bound: T) -> Self
        where
            Self: $crate::real::Accepts<T>,
        {
            let bound = Self::accept(bound);
            if $crate::rule::is_nan(self.value) {
                return self.apply((self.value.min(bound.value), self.value));
            }
            Self::select(bound.less_equal::<Self>(self), bound, self)
        }
        #[$attribute]
        fn signum(self) -> Self {
            Self::constant(self.value.signum().detach())
        }
        #[$attribute]
        fn detach(self) -> Self {
            Self::constant(self.value.detach())
        }
    };
}

pub(crate) use {by_choice, by_rule};
