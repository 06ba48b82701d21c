//! Functions in SIMD lanes: by a recording that is replayed at many points, and by a rollout whose kernel runs in lanes.

use autodiff::{Function, Real, vjp};
use autodiff_programs::data::Recorded;
use autodiff_programs::{Kernel, Rollout, kernel};

use crate::common::Formula;
use crate::steps::Mapped;

/// Returns the values and gradients of a formula, by a recording.
pub(crate) fn values_and_gradients(formula: &Formula, points: &[Vec<f64>]) -> Vec<(f64, Vec<f64>)> {
    let recorded = Recorded::new(formula, points[0].len()).expect("a formula needs no values");
    recorded.values_and_gradients(points)
}

/// A function of each element of an array.
#[derive(Clone, Copy)]
struct OfEach<F>(F);

#[kernel]
impl<F: Function + Copy + Send + 'static> Kernel<1, 1> for OfEach<F> {
    fn eval<R: Real>(&self, [x]: [R; 1], _: &[R]) -> [R; 1] {
        [self.0.eval(&[x])]
    }
}

/// Returns the values and slopes of a function of one number at all points, with the names of the ways to compute them.
pub(crate) fn slopes<R: Real + Into<f64>>(
    function: impl Function + Copy + Send + Sync + 'static,
    points: &[R],
) -> Vec<(&'static str, Vec<[f64; 2]>)> {
    let recorded = Recorded::new(&function, 1).expect("no values are asked for");
    let columns: Vec<[R; 1]> = points.iter().map(|&x| [x]).collect();
    let both = recorded.values_and_gradients(&columns);
    let both = both
        .into_iter()
        .map(|(value, slope)| [value.into(), slope[0].into()]);
    let rollout = Rollout::new(Mapped(OfEach(function), points.len()), 1);
    let ones = vec![R::one(); points.len()];
    let (values, slopes) = vjp(|x| rollout.run(x, &[]), points, &ones);
    let mapped = values
        .into_iter()
        .zip(slopes)
        .map(|(value, slope)| [value.into(), slope.into()]);
    vec![
        ("in lanes", both.collect()),
        ("in a rollout", mapped.collect()),
    ]
}
