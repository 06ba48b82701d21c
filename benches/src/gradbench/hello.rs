//! The square of a number, and its derivative.

use autodiff::{Real, gradient_of};
use serde_json::value::RawValue;

use super::work::{Prepared, Refusal, read, work};

fn square<R: Real>(x: R) -> R {
    x * x
}

/// Functions `square` and `double`.
///
/// # Errors
/// If there is no such function, or the input is not a number.
pub fn prepare(function: &str, input: &RawValue) -> Prepared {
    let x: f64 = read(input)?;
    match function {
        "square" => work(move || square(x)),
        "double" => work(move || gradient_of(|x| square(x[0]), &[x])[0]),
        _ => Err(Refusal::Function(function.to_owned())),
    }
}
