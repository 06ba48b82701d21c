//! The least `(x1, y1)` of the greatest `(x2, y2)` of a function: descent within descent.

use std::marker::PhantomData;

use autodiff::Real;
use serde::Deserialize;
use serde_json::value::RawValue;

use super::descent::{Forward, Mode, Objective, Reverse, argmin};
use super::work::{Error, Prepared, read, work};

#[derive(Deserialize)]
struct Input {
    start: [f64; 2],
}

/// What `(x1, y1)` makes small and `(x2, y2)` makes large.
fn objective<R: Real>(first: &[R], second: &[R]) -> R {
    R::dot(first, first) - R::dot(second, second)
}

/// The negative of the objective at the given `(x1, y1)`: its least value is the greatest.
struct Opposed;

impl Objective for Opposed {
    fn eval<R: Real>(&self, first: &[R], second: &[R]) -> R {
        -objective(first, second)
    }
}

/// The greatest value of the objective, found from the given start on by inner derivatives in the
/// mode `M`.
struct Greatest<M>(PhantomData<M>);

impl<M: Mode> Objective for Greatest<M> {
    fn eval<R: Real>(&self, start: &[R], first: &[R]) -> R {
        objective(first, &argmin::<R, M>(&Opposed, first, start))
    }
}

/// The saddle point, by derivatives in the mode `Outer` of descents in the mode `Inner`.
fn saddle<Outer: Mode, Inner: Mode>(start: &[f64]) -> Vec<f64> {
    let greatest = Greatest::<Inner>(PhantomData);
    let mut first = argmin::<f64, Outer>(&greatest, start, start);
    let second = argmin::<f64, Inner>(&Opposed, &first, start);
    first.extend(second);
    first
}

pub(super) fn prepare(function: &str, input: &RawValue) -> Prepared {
    let Input { start } = read(input)?;
    match function {
        "rr" => work(move || saddle::<Reverse, Reverse>(&start)),
        "ff" => work(move || saddle::<Forward, Forward>(&start)),
        "fr" => work(move || saddle::<Forward, Reverse>(&start)),
        "rf" => work(move || saddle::<Reverse, Forward>(&start)),
        _ => Error::function(function),
    }
}
