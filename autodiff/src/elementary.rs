//! The table of the elementary functions of one number.

/// Passes the table of elementary functions to a macro. A composed function needs only its entry. A basic one also needs its
/// derivative and a method of every number type.
///
/// - *Basic* functions are implemented by every number type. An entry has the name of the method of
///   [`Real`](crate::Real) and the name of the variant of a recorded operation. The derivative is in the module `rule`,
///   in a function with the name of the method.
/// - *Composed* functions are computed from other methods of [`Real`](crate::Real). An entry has the name of the
///   method, the name of the variant of [`Elementary`] and the documentation. Then follow two closures: one returns the
///   value at `x`, and the other returns the partial at `x`, given the value `y`. Formulas must select and not branch,
///   so that they run in lanes. Constants must be small integers and halves, which every number type represents
///   exactly. Longer formulas are functions in `math/table.rs`. Behind `=`, an entry may have a function of f64 that is
///   more accurate or faster than the formula: floats and lanes take its value.
#[doc(hidden)]
#[macro_export]
macro_rules! functions {
    ($then:ident) => {
        $then! {
            basic {
                recip Recip, sqrt Sqrt, rsqrt Rsqrt, exp Exp, ln Ln, sin Sin, cos Cos, tan Tan, tanh Tanh,
                layer_tanh LayerTanh
            }
            composed {
                asin Asin "Inverse sine.":
                    |x| x.atan2(((R::one() - x) * (R::one() + x)).sqrt()),
                    |x, y| rule::one_minus_square(x).sqrt().recip();
                acos Acos "Inverse cosine.":
                    |x| ((R::one() - x) * (R::one() + x)).sqrt().atan2(x),
                    |x, y| -rule::one_minus_square(x).sqrt().recip();
                sinh Sinh "Hyperbolic sine.": |x| sinh(x), |x, y| x.cosh();
                cosh Cosh "Hyperbolic cosine.": |x| cosh(x), |x, y| x.sinh();
                asinh Asinh "Inverse hyperbolic sine.": |x| asinh(x), |x, y| asinh_partial(x);
                acosh Acosh "Inverse hyperbolic cosine.":
                    |x| acosh(x),
                    |x, y| ((x - R::one()).sqrt() * (x + R::one()).sqrt()).recip();
                atanh Atanh "Inverse hyperbolic tangent.":
                    |x| R::lit(0.5) * (ln_1p(x) - ln_1p(-x)),
                    |x, y| R::select(R::one().less(x.abs()), y, rule::one_minus_square(x).recip());
                exp_m1 ExpM1 "`e^x - 1`, accurate near 0.": |x| exp_m1(x), |x, y| x.exp();
                ln_1p Ln1p "`ln(1 + x)`, accurate near 0.": |x| ln_1p(x), |x, y| rule::ln(R::one() + x).1;
                log2 Log2 "Logarithm to base 2." = f64::log2:
                    |x| x.ln() / R::lit(2.0).ln(),
                    |x, y| rule::ln(x).1 / R::lit(2.0).ln();
                log10 Log10 "Logarithm to base 10." = f64::log10:
                    |x| x.ln() / R::lit(10.0).ln(),
                    |x, y| rule::ln(x).1 / R::lit(10.0).ln();
                cbrt Cbrt "Cubic root of either sign.": |x| cbrt(x), |x, y| (R::lit(3.0) * y * y).recip();
                sinc Sinc "`sin(x) / x`, and 1 at 0.":
                    |x| cardinal(x.sin(), x),
                    |x, y| cardinal_partial((x.cos() - y) / x, x, -1.0);
                sinhc Sinhc "`sinh(x) / x`, and 1 at 0.":
                    |x| cardinal(x.sinh(), x),
                    |x, y| cardinal_partial(y * (x.tanh().recip() - x.recip()), x, 1.0);
                sigmoid Sigmoid "The logistic function `1 / (1 + e^-x)`. It is correct everywhere, while the \
                    derivative of that formula is NaN when `e^-x` overflows.":
                    |x| sigmoid(x),
                    |x, y| sigmoid_partial(x);
                softplus Softplus "`ln(1 + e^x)`, a smooth `max(x, 0)` with the slope `sigmoid`. It is correct \
                    everywhere.":
                    |x| softplus(x),
                    |x, y| x.sigmoid();
                log_sigmoid LogSigmoid "`ln(sigmoid(x))`, a smooth `min(x, 0)`. It is correct everywhere, while the \
                    logarithm of `sigmoid` is infinite where `sigmoid` underflows.":
                    |x| -softplus(-x),
                    |x, y| (-x).sigmoid();
                xlogx Xlogx "`x ln(x)`, and 0 at 0.":
                    |x| R::select(x.abs().less_equal(0.0), R::zero(), x * x.ln()),
                    |x, y| R::one() + x.ln();
                erf Erf "The error function." = msun::erf: |x| special::erf(x), |x, y| special::erf_slope(x);
                erfc Erfc "`1 - erf(x)`, accurate where `erf(x)` is close to 1." = msun::erfc:
                    |x| special::erfc(x),
                    |x, y| -special::erf_slope(x);
                ln_erfc LnErfc "`ln(erfc(x))`, correct everywhere, while the logarithm of `erfc` is infinite where \
                    `erfc` underflows." = special::ln_erfc:
                    |x| special::ln_erfc(x),
                    |x, y| special::ln_erfc_slope(x);
                ln_gamma LnGamma "The logarithm of the absolute value of the gamma function." = msun::ln_gamma:
                    |x| special::ln_gamma(x),
                    |x, y| x.digamma();
                digamma Digamma "The digamma function, which is the slope of `ln_gamma`." = digamma_of_float:
                    |x| special::digamma(x),
                    |x, y| x.trigamma();
                trigamma Trigamma "The trigamma function, which is the slope of `digamma`." = special::trigamma:
                    |x| special::trigamma(x),
                    |x, y| special::tetragamma(x);
                cot_pi CotPi "The cotangent of `pi x`, and NaN at integers." = special::cot_pi:
                    |x| special::cot_pi(x),
                    |x, y| special::cot_pi_slope(y);
            }
        }
    };
}

/// Defines a method of [`Real`](crate::Real) for each [`Elementary`] function.
macro_rules! elementary_methods {
    (
        basic { $($_basic:tt)* }
        composed {
            $($method:ident $Function:ident $about:literal $(= $_of_f64:path)?: |$_x:ident| $_value:expr, |$_of:ident, $_y:ident| $_partial:expr;)*
        }
    ) => {
        $(
            #[doc = $about]
            #[inline(always)]
            #[track_caller]
            fn $method(self) -> Self {
                self.elementary(Elementary::$Function)
            }
        )*
    };
}

pub(crate) use {elementary_methods, functions};

macro_rules! define {
    (
        basic { $($_basic:tt)* }
        composed {
            $($method:ident $Function:ident $about:literal $(= $_of_f64:path)?: |$_x:ident| $_value:expr, |$_of:ident, $_y:ident| $_partial:expr;)*
        }
    ) => {
        /// A function of one number, as an argument of [`Real::elementary`](crate::Real::elementary). These functions
        /// are composed of other methods of `Real`, so a number type need not implement them.
        ///
        /// At an end of the domain the derivative is the limit from inside. It is infinite for `asin`, `acos`,
        /// `acosh`, `atanh`, `ln_1p`, `xlogx` and the logarithms, for `cbrt` at 0, and for `ln_gamma`, `digamma` and
        /// `trigamma` at 0, where the domain is taken to be the positive numbers. Outside the domain it is NaN, like the
        /// value. At negative integers `ln_gamma` is infinite, and its derivatives are NaN.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[non_exhaustive]
        pub enum Elementary {
            $(#[doc = $about] $Function,)*
        }

        impl Elementary {
            /// All functions.
            pub const ALL: &'static [Self] = &[$(Self::$Function,)*];

            /// Returns the name of the method of [`Real`](crate::Real).
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$Function => stringify!($method),)*
                }
            }
        }
    };
}

functions!(define);
