//! The least-squares fit of a polynomial to the sign function.

use autodiff::{Function, Real, gradient};
use autodiff_programs::data::{Sum, Summand};
use serde::Deserialize;
use serde_json::value::RawValue;

use super::work::{Error, Prepared, read, require, work};

#[derive(Deserialize)]
struct Input {
    /// The coefficients of the polynomial, beginning with the constant.
    x: Vec<f64>,
    /// The number of points.
    n: usize,
}

/// The term of one point: half the squared error of the polynomial.
#[derive(Clone)]
struct Misfit;

impl Summand for Misfit {
    fn eval<R: Real>(&self, x: &[R], datum: &[R]) -> R {
        let (t, sign) = (datum[0], datum[1]);
        let mut value = R::zero();
        for j in (0..x.len()).rev() {
            value = value.fma(t, x[j]);
        }
        let gap = sign - value;
        R::lit(0.5) * gap * gap
    }
}

/// The squared error of the polynomial at points that are evenly spaced from -1 to 1.
struct Fit {
    points: usize,
}

impl Function for Fit {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let point = |i: usize| {
            let t = -1.0 + i as f64 * 2.0 / (self.points - 1) as f64;
            [t, Real::signum(t)]
        };
        let points: Vec<_> = (0..self.points).map(point).collect();
        Sum::new(Misfit, &points).run(x)
    }
}

pub(super) fn prepare(function: &str, input: &RawValue) -> Prepared {
    let Input { x, n } = read(input)?;
    require(n >= 2, "`n` must be 2 or more")?;
    let fit = Fit { points: n };
    match function {
        "primal" => work(move || fit.eval(&x)),
        "gradient" => work(move || gradient(|x| fit.eval(x), &x)),
        _ => Error::function(function),
    }
}
