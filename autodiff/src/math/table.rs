//! The longer formulas for the table of [`functions`]. Differentiating an accurate formula for a value can give an
//! inaccurate derivative, so each function has a separate formula for its derivative (the partial). Higher derivatives
//! come from differentiating the partial.

use super::digamma::digamma_of_float;
use super::{msun, special};
use crate::elementary::{Elementary, functions};
use crate::real::{Mask, Real};
use crate::rule;

/// How floats and lanes compute an [`Elementary`] function.
pub(crate) enum OnFloats<R> {
    /// By its formula, which has this value.
    Formula(R),
    /// By a function of f64.
    Function(fn(f64) -> f64),
}

macro_rules! on_floats {
    ($formula:expr) => {
        OnFloats::Formula($formula)
    };
    ($formula:expr, $of_f64:path) => {
        OnFloats::Function($of_f64)
    };
}

macro_rules! values_and_partials {
    (
        basic { $($_basic:tt)* }
        composed {
            $($_method:ident $Function:ident $_about:literal $(= $of_f64:path)?: |$x:ident| $value:expr, |$of:ident, $y:ident| $partial:expr;)*
        }
    ) => {
        impl Elementary {
            /// Returns the value, computed with methods of [`Real`]. Implementations of [`Real::elementary`] call this
            /// if they have no better formula.
            #[inline(always)]
            #[track_caller]
            pub fn value<R: Real>(self, x: R) -> R {
                match self {
                    $(Self::$Function => {
                        let $x = x;
                        $value
                    })*
                }
            }

            /// Returns how floats and lanes compute the value at `x`. They do not compile the formula of a function that
            /// they never use it for.
            #[inline(always)]
            #[track_caller]
            pub(crate) fn on_floats<R: Real>(self, x: R) -> OnFloats<R> {
                match self {
                    $(Self::$Function => on_floats!({
                        let $x = x;
                        $value
                    } $(, $of_f64)?),)*
                }
            }

            /// Returns the value and the partial, like the rules of other functions.
            #[inline(always)]
            #[track_caller]
            pub fn rule<R: Real>(self, x: R) -> (R, R) {
                let value = x.elementary(self);
                if R::Mask::IS_SINGLE {
                    (value, self.shared_partial(x, value))
                } else {
                    (value, self.partial(x, value))
                }
            }

            /// Like [`partial`](Self::partial), but compiled only once for each number type. Lanes need it inlined
            /// instead.
            #[inline(never)]
            #[track_caller]
            fn shared_partial<R: Real>(self, x: R, y: R) -> R {
                self.partial(x, y)
            }

            /// Returns the partial at `x`, given the value `y` there.
            #[inline(always)]
            #[track_caller]
            #[allow(unused_variables)]
            fn partial<R: Real>(self, x: R, y: R) -> R {
                match self {
                    $(Self::$Function => {
                        let ($of, $y) = (x, y);
                        $partial
                    })*
                }
            }
        }
    };
}

functions!(values_and_partials);

/// Like [`Real::select`], but a single number evaluates only the operand that is chosen.
macro_rules! select {
    ($mask:expr, $if_true:expr, $if_false:expr) => {{
        let mask = $mask;
        if !R::Mask::IS_SINGLE {
            R::select(mask, $if_true, $if_false)
        } else if mask.any() {
            $if_true
        } else {
            $if_false
        }
    }};
}

/// Returns the value of an odd function at `x`, given its value at `|x|`. A zero `x` keeps its sign.
#[inline(always)]
#[track_caller]
fn odd<R: Real>(x: R, of_size: R) -> R {
    let signed = R::select(x.less(R::zero()), -of_size, of_size);
    R::select(x.abs().less_equal(R::zero()), x, signed)
}

/// Computes `e^x - 1`. For small `x` it uses `2 t / (1 - t)` with `t = tanh(x/2)`, in which nothing cancels. If `x / 2`
/// is inexact, as for subnormal numbers, it returns `x`.
#[inline(always)]
#[track_caller]
fn exp_m1<R: Real>(x: R) -> R {
    let one = R::one();
    let half = x * R::lit(0.5);
    let halved = (half + half).less_equal(x) & x.less_equal(half + half);
    select!(
        x.abs().less(one),
        {
            let t = half.tanh();
            R::select(halved, (t + t) / (one - t), x)
        },
        x.exp() - one
    )
}

/// Computes `ln(1 + x)` by W. Kahan's formula. The factor `x / (u - 1)` compensates for the rounding of `u = 1 + x`.
#[inline(always)]
#[track_caller]
fn ln_1p<R: Real>(x: R) -> R {
    let one = R::one();
    let u = one + x;
    let rounded = u - one;
    let vanishes = rounded.abs().less_equal(R::zero());
    let corrected = R::select(rounded.finite(), u.ln() * (x / rounded), u.ln());
    R::select(vanishes, x, corrected)
}

/// Computes `e^x / 2` from `e^(x/2)`, so that the result is finite for slightly larger `x` than `e^x`.
#[inline(always)]
#[track_caller]
fn half_exp<R: Real>(x: R) -> R {
    let half = R::lit(0.5);
    let root = (half * x).exp();
    half * root * root
}

#[inline(always)]
#[track_caller]
fn sinh<R: Real>(x: R) -> R {
    let size = x.abs();
    let above = exp_m1(size);
    let value = R::lit(0.5) * (above + above / (R::one() + above));
    odd(x, select!(above.finite(), value, half_exp(size)))
}

#[inline(always)]
#[track_caller]
fn cosh<R: Real>(x: R) -> R {
    let size = x.abs();
    let power = size.exp();
    let value = R::lit(0.5) * (power + power.recip());
    select!(power.finite(), value, half_exp(size))
}

/// Computes `ln(2 x)`. For `x` so large that its square overflows, this is the value of `asinh` and `acosh`.
#[inline(always)]
#[track_caller]
fn ln_twice<R: Real>(x: R) -> R {
    x.ln() + R::lit(2.0).ln()
}

/// Computes `ln(x + sqrt(x^2 + 1))`. The formula is evaluated at `|x|`, so that nothing cancels, and the result gets
/// the sign of `x`.
#[inline(always)]
#[track_caller]
fn asinh<R: Real>(x: R) -> R {
    let (one, size) = (R::one(), x.abs());
    let square = size * size;
    let value = ln_1p(size + square / (one + (square + one).sqrt()));
    odd(x, R::select(square.finite(), value, ln_twice(size)))
}

#[inline(always)]
#[track_caller]
fn asinh_partial<R: Real>(x: R) -> R {
    let square = x * x;
    let partial = (R::one() + square).sqrt().recip();
    // The derivatives of this partial contain `x^4`, so it must be replaced where that overflows.
    R::select((square * square).finite(), partial, x.abs().recip())
}

/// Computes `ln(x + sqrt(x^2 - 1))`. The roots of `x - 1` and `x + 1` are taken separately: their product is also
/// positive below -1, where the function is not defined.
#[inline(always)]
#[track_caller]
fn acosh<R: Real>(x: R) -> R {
    let one = R::one();
    let above = x - one;
    let value = ln_1p(above + above.sqrt() * (x + one).sqrt());
    R::select((x * x).finite(), value, ln_twice(x))
}

/// Computes a power with the exponent 1/3, which is rounded, and corrects it by one step of Newton's method.
#[inline(always)]
#[track_caller]
fn cbrt<R: Real>(x: R) -> R {
    let (size, three) = (x.abs(), R::lit(3.0));
    let power = size.powf(three.recip());
    let root = power - (power - size / (power * power)) / three;
    // At zero and infinity the step is NaN, but the power is exact.
    odd(x, R::select(root.finite(), root, power))
}

/// Returns the logistic functions of `|x|` and of `-|x|`. They use `e^-|x|`, which does not overflow.
#[inline(always)]
#[track_caller]
fn sigmoids<R: Real>(x: R) -> [R; 2] {
    let power = R::select(x.less(R::zero()), x, -x).exp();
    let share = (R::one() + power).recip();
    [share, power * share]
}

#[inline(always)]
#[track_caller]
fn sigmoid<R: Real>(x: R) -> R {
    let [share, rest] = sigmoids(x);
    R::select(x.less(R::zero()), rest, share)
}

/// Returns the slope of the logistic function. Its derivatives are computed from the slope of `tanh(x/2)`, because terms
/// in the derivative of `rest * share` cancel near 0.
#[inline(always)]
#[track_caller]
fn sigmoid_partial<R: Real>(x: R) -> R {
    let [share, rest] = sigmoids(x);
    let moves = rule::tanh(x * R::lit(0.5)).1 * R::lit(0.25);
    (rest * share).detach().straight_through(moves)
}

#[inline(always)]
#[track_caller]
fn softplus<R: Real>(x: R) -> R {
    let negative = x.less(R::zero());
    let above = R::select(negative, R::zero(), x);
    above + ln_1p(R::select(negative, x, -x).exp())
}

/// Returns a quotient `value / x` like `sin(x) / x`, whose limit at `x = 0` is 1.
#[inline(always)]
#[track_caller]
fn cardinal<R: Real>(value: R, x: R) -> R {
    R::select(x.abs().less_equal(R::zero()), R::one(), value / x)
}

/// Returns the slope of `sin(x) / x` (for `sign` -1) or of `sinh(x) / x` (for `sign` 1). `of_quotient` is the slope
/// from the quotient rule, whose terms cancel for `|x| < 1`. There the slope is the series
/// `sign x/3 (1 + r/(2 5) (1 + r/(4 7) (…)))` with `r = sign x^2`. The last term is below 1e-34, which is accurate
/// enough for every type.
#[inline(always)]
#[track_caller]
fn cardinal_partial<R: Real>(of_quotient: R, x: R, sign: f64) -> R {
    let mut sum = R::one();
    for k in (1..15).rev() {
        let factor = R::lit(sign / 2.0) / R::lit(f64::from(k * (2 * k + 3)));
        sum = R::one() + x * x * factor * sum;
    }
    let series = R::lit(sign) * x / R::lit(3.0) * sum;
    R::select(x.abs().less(R::one()), series, of_quotient)
}
