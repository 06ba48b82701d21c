//! Finds a saddle point: minimises over `(x1, y1)` the maximum over `(x2, y2)`. One gradient descent runs inside the
//! other.

use autodiff::Real;
use serde::Deserialize;
use serde_json::value::RawValue;

use super::descent::{Mode, Objective, argmin};
use super::work::{Prepared, read, work};

#[derive(Deserialize)]
struct Input {
    start: [f64; 2],
}

/// The function to minimise over `(x1, y1)` and maximise over `(x2, y2)`.
fn objective<R: Real>(first: &[R], second: &[R]) -> R {
    R::dot(first, first) - R::dot(second, second)
}

/// The negative objective, as a function of `(x2, y2)` for the given `(x1, y1)`.
struct Opposed;

impl Objective for Opposed {
    fn eval<R: Real>(&self, first: &[R], second: &[R]) -> R {
        -objective(first, second)
    }
}

/// The maximum of the objective over `(x2, y2)`, as a function of `(x1, y1)`. It is found by descent from the given
/// start, with derivatives in the given mode.
struct Greatest(Mode);

impl Objective for Greatest {
    fn eval<R: Real>(&self, start: &[R], first: &[R]) -> R {
        objective(first, &argmin(self.0, &Opposed, first, start))
    }
}

pub(super) fn prepare(function: &str, input: &RawValue) -> Prepared {
    let Input { start } = read(input)?;
    let [outer, inner] = Mode::pair(function)?;
    work(move || {
        let first = argmin(outer, &Greatest(inner), &start, &start);
        let second = argmin(inner, &Opposed, &first, &start);
        [first, second].concat()
    })
}
