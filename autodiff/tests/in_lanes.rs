//! Functions in SIMD lanes: forward mode over registers.

use autodiff::simd::{Lane, Vectorized, kernel};
use autodiff::{Function, Real};

use crate::common::forward_gradient;

/// The values and gradients at several points, a register of points at a time.
struct InLanes<'a, R, F>(&'a F, &'a [Vec<R>]);

#[kernel]
impl<R: Real, F: Function> Vectorized<R> for InLanes<'_, R, F> {
    type Output = Vec<(R, Vec<R>)>;
    fn run<L: Lane<R>>(self) -> Self::Output {
        let arguments = self.1[0].len();
        let mut found = Vec::new();
        for points in self.1.chunks(L::N) {
            let column = |i: usize| points.iter().map(|x| x[i]).collect::<Vec<R>>();
            let x: Vec<L> = (0..arguments).map(|i| L::load_up_to(&column(i))).collect();
            let numbers = |register: L| {
                let mut numbers = vec![R::zero(); points.len()];
                register.store_up_to(&mut numbers);
                numbers
            };
            let values = numbers(self.0.eval(&x));
            let slopes: Vec<Vec<R>> = forward_gradient(self.0, &x)
                .into_iter()
                .map(numbers)
                .collect();
            for (k, value) in values.into_iter().enumerate() {
                found.push((value, slopes.iter().map(|slopes| slopes[k]).collect()));
            }
        }
        found
    }
}

/// Returns the values and gradients of a function in lanes.
pub(crate) fn values_and_gradients<R: Real>(
    function: &(impl Function + Clone),
    points: &[Vec<R>],
) -> Vec<(R, Vec<R>)> {
    R::vectorize(InLanes(function, points))
}

/// Returns the values and slopes of a function of one number at all points, with the names of the ways to compute them.
pub(crate) fn slopes<R: Real + Into<f64>>(
    function: impl Function + Copy + Send + Sync + 'static,
    points: &[R],
) -> Vec<(&'static str, Vec<[f64; 2]>)> {
    let points: Vec<Vec<R>> = points.iter().map(|&x| vec![x]).collect();
    let both = values_and_gradients(&function, &points);
    let both = both
        .iter()
        .map(|(value, slope)| [(*value).into(), slope[0].into()]);
    vec![("in lanes", both.collect())]
}
