//! The square of a number, as the simplest objective.

use autodiff::{Real, gradient};
use serde_json::value::RawValue;

use super::work::{Error, Prepared, read, work};

fn square<R: Real>(x: R) -> R {
    x * x
}

pub(super) fn prepare(function: &str, input: &RawValue) -> Prepared {
    let x: f64 = read(input)?;
    match function {
        "square" => work(move || square(x)),
        "double" => work(move || gradient(|x| square(x[0]), &[x])[0]),
        _ => Error::function(function),
    }
}
