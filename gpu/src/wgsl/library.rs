//! The elementary functions of printed programs.
//!
//! The language's own `sin`, `cos` and `exp` have few guaranteed digits, so the basic functions are written here, with the
//! formulas that `autodiff` uses for `f32` on a processor. All others are printed from their formulas.

use std::collections::{BTreeMap, BTreeSet};

use autodiff::Real;
use autodiff::internal::by_squaring;
use autodiff_programs::internal::Formula;

use super::calls::Called;
use super::formula;

/// The text of the basic functions.
const BASIC: &str = include_str!("basic.wgsl");

/// Returns the text of the called functions, and of those that they call. Functions are declared before they are used.
pub(super) fn print(calls: BTreeSet<Called>) -> String {
    let mut pending: Vec<Called> = calls.into_iter().collect();
    let mut printed = BTreeMap::new();
    while let Some(called) = pending.pop() {
        let name = called.name();
        if printed.contains_key(&called) {
            continue;
        }
        let formula = match called {
            Called::Elementary(function) => Formula::of_one(|x| function.value(x)),
            Called::Power(exponent) => Formula::of_one(|x| {
                let times = exponent.unsigned_abs();
                let power = by_squaring(Real::lit(1.0), x, times);
                if exponent < 0 { power.recip() } else { power }
            }),
        };
        let function = formula::of_one(&name, &formula);
        pending.extend(&function.calls);
        printed.insert(called, function.text);
    }
    let texts: Vec<String> = printed.into_values().collect();
    format!("{BASIC}\n{}", texts.join("\n"))
}
