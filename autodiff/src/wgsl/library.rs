//! The elementary functions of printed programs.
//!
//! The language's own `sin`, `cos` and `exp` have few guaranteed digits, so the basic functions are written here, with the
//! formulas that this crate uses for `f32` on a processor. All others are printed from their formulas.

use std::collections::{BTreeMap, BTreeSet};

use super::formula;
use crate::elementary::Elementary;
use crate::math::by_squaring;
use crate::real::Real;

/// The text of the basic functions.
const BASIC: &str = include_str!("basic.wgsl");

/// A function that a formula calls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Called {
    /// A function of `basic.wgsl`.
    Basic(&'static str),
    Elementary(Elementary),
    /// A power with this exponent.
    Power(i32),
}

impl Called {
    pub(super) fn name(self) -> String {
        match self {
            Self::Basic(name) => name.to_owned(),
            Self::Elementary(function) => format!("{}_of", function.name()),
            Self::Power(exponent) if exponent < 0 => {
                format!("power_minus_{}", -i64::from(exponent))
            }
            Self::Power(exponent) => format!("power_{exponent}"),
        }
    }
}

/// Returns the text of the called functions, and of those that they call. Functions are declared before they are used.
pub(super) fn print(calls: BTreeSet<Called>) -> String {
    let mut pending: Vec<Called> = calls.into_iter().collect();
    let mut printed = BTreeMap::new();
    while let Some(called) = pending.pop() {
        let name = called.name();
        if printed.contains_key(&called) {
            continue;
        }
        let function = match called {
            Called::Basic(_) => continue,
            Called::Elementary(function) => formula::of_one(&name, |x| function.value(x)),
            Called::Power(exponent) => formula::of_one(&name, |x| {
                let times = exponent.unsigned_abs();
                let power = by_squaring(Real::lit(1.0), x, times);
                if exponent < 0 { power.recip() } else { power }
            }),
        };
        pending.extend(&function.calls);
        printed.insert(called, function.text);
    }
    let texts: Vec<String> = printed.into_values().collect();
    format!("{BASIC}\n{}", texts.join("\n"))
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
