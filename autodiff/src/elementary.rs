//! The names of elementary functions of one number.

/// A function of one number for [`Real::elementary`](crate::Real::elementary): those that a number type
/// need not have an implementation of, because they are made of others.
///
/// At an end of its domain the derivative is the limit from inside, infinite for `asin`, `acos`,
/// `acosh`, `atanh`, `ln_1p` and the logarithms, as it is for `cbrt` at 0; outside it is NaN, as
/// the value is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Elementary {
    /// Inverse sine.
    Asin,
    /// Inverse cosine.
    Acos,
    /// Hyperbolic sine.
    Sinh,
    /// Hyperbolic cosine.
    Cosh,
    /// Inverse hyperbolic sine.
    Asinh,
    /// Inverse hyperbolic cosine.
    Acosh,
    /// Inverse hyperbolic tangent.
    Atanh,
    /// `e^x - 1`.
    ExpM1,
    /// `ln(1 + x)`.
    Ln1p,
    /// Logarithm to base 2.
    Log2,
    /// Logarithm to base 10.
    Log10,
    /// Cubic root of either sign.
    Cbrt,
    /// `1 / (1 + e^-x)`.
    Sigmoid,
    /// `ln(1 + e^x)`.
    Softplus,
}

impl Elementary {
    /// The name of the method.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Asin => "asin",
            Self::Acos => "acos",
            Self::Sinh => "sinh",
            Self::Cosh => "cosh",
            Self::Asinh => "asinh",
            Self::Acosh => "acosh",
            Self::Atanh => "atanh",
            Self::ExpM1 => "exp_m1",
            Self::Ln1p => "ln_1p",
            Self::Log2 => "log2",
            Self::Log10 => "log10",
            Self::Cbrt => "cbrt",
            Self::Sigmoid => "sigmoid",
            Self::Softplus => "softplus",
        }
    }
}
