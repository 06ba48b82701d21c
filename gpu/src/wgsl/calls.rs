//! The names of functions and constants in printed formulas.

use autodiff::Elementary;

/// A function that a formula calls, beside those of `basic.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Called {
    Elementary(Elementary),
    /// A power with this exponent.
    Power(i32),
}

impl Called {
    /// Whether the formula of the function loops until all lanes have a result. Such a loop has no end in a recording.
    pub(super) fn loops(self) -> bool {
        use Elementary::{CotPi, Digamma, LnGamma, Trigamma};
        matches!(self, Self::Elementary(CotPi | Digamma | LnGamma | Trigamma))
    }

    pub(super) fn name(self) -> String {
        match self {
            Self::Elementary(function) => format!("{}_of", function.name()),
            Self::Power(exponent) if exponent < 0 => {
                format!("power_minus_{}", -i64::from(exponent))
            }
            Self::Power(exponent) => format!("power_{exponent}"),
        }
    }
}

/// Prints a constant. The language has no literals for numbers that are not finite; an infinite one becomes the largest
/// float, and NaN becomes zero.
pub(super) fn constant(value: f64) -> String {
    let single = value as f32;
    let single = match single.is_nan() {
        true => 0.0,
        false => single.clamp(f32::MIN, f32::MAX),
    };
    // The parentheses keep a sign apart from an operator.
    match single.is_sign_negative() {
        true => format!("({single:?}f)"),
        false => format!("{single:?}f"),
    }
}
