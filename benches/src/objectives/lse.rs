//! The logarithm of a sum of exponentials. The largest number is subtracted before the exponentials are taken.

use autodiff::{Function, Real, gradient, lit};
use autodiff_programs::data::Recorded;
use serde::Deserialize;
use serde_json::value::RawValue;

use super::work::{Error, Prepared, read, require, work};

#[derive(Deserialize)]
struct Input {
    x: Vec<f64>,
}

/// The term of one number: `exp(x - largest)`.
struct Exponential {
    largest: f64,
}

impl Function for Exponential {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        (x[0] - lit(self.largest)).exp()
    }
}

struct LogSumExp;

impl Function for LogSumExp {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        // The largest number is a constant, because the function does not depend on its choice.
        let largest = x.iter().fold(f64::NEG_INFINITY, |largest, x| {
            f64::max(largest, x.primal())
        });
        let exponential = Recorded::new(&Exponential { largest }, 1)
            .expect("the exponential can be recorded without values");
        lit(largest) + exponential.total(&[x]).ln()
    }
}

pub(super) fn prepare(function: &str, input: &RawValue) -> Prepared {
    let Input { x } = read(input)?;
    require(!x.is_empty(), "`x` must not be empty")?;
    match function {
        "primal" => work(move || LogSumExp.eval(&x)),
        "gradient" => work(move || gradient(|x| LogSumExp.eval(x), &x)),
        _ => Error::function(function),
    }
}
