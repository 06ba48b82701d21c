//! An operation that this crate does not have: weighted arrays.

use autodiff::Real;
use autodiff::simd::Lane;
use autodiff_programs::kernel;
use autodiff_programs::operations::{ArrayOperation, Forward, Reverse};

/// Multiplies an offset from the weighted mean, and a value, by weights, and appends another array. The second output is the
/// mean.
pub(crate) struct Weighted;

#[kernel]
impl ArrayOperation for Weighted {
    fn forward<R: Real, L: Lane<R>>(&self, Forward { x, y, .. }: Forward<R>) {
        let [weights, offset, value, other] = [0, 1, 2, 3].map(|k| x.get(k));
        let (len, starts) = (weights.len(), x.starts());
        let (all, means) = y.split_at_mut(2 * len + other.len());
        for s in 0..starts {
            let (mut sum, mut total) = (R::zero(), R::zero());
            for at in (s..len).step_by(starts) {
                sum = weights[at].fma(offset[at], sum);
                total += weights[at];
            }
            means[s] = sum / total;
        }
        for at in 0..len {
            all[at] = weights[at] * (offset[at] - means[at % starts]);
            all[len + at] = weights[at] * value[at];
        }
        all[2 * len..].copy_from_slice(other);
    }

    fn reverse<R: Real, L: Lane<R>>(&self, step: Reverse<R>) {
        let Reverse { x, y, y_bar, .. } = step;
        let (mut x_bar, starts) = (step.x_bar, x.starts());
        let [weights, offset, value, other] = [0, 1, 2, 3].map(|k| x.get(k));
        let (len, end) = (weights.len(), 2 * weights.len() + other.len());
        // The cotangents of the offsets from the mean, divided by the weights.
        let rest = step.scratch;
        rest.resize(len, R::zero());
        for s in 0..starts {
            let (mut sum, mut total) = (R::zero(), R::zero());
            for at in (s..len).step_by(starts) {
                sum = weights[at].fma(y_bar[at], sum);
                total += weights[at];
            }
            for at in (s..len).step_by(starts) {
                rest[at] = y_bar[at] - (sum - y_bar[end + s]) / total;
            }
        }
        if let Some(bar) = x_bar.get_mut(0) {
            for at in 0..len {
                bar[at] += (offset[at] - y[end + at % starts]) * rest[at];
                bar[at] += value[at] * y_bar[len + at];
            }
        }
        for (k, from) in [(1, &rest[..]), (2, &y_bar[len..2 * len])] {
            if let Some(bar) = x_bar.get_mut(k) {
                for at in 0..len {
                    bar[at] += weights[at] * from[at];
                }
            }
        }
        if let Some(bar) = x_bar.get_mut(3) {
            for at in 0..other.len() {
                bar[at] += y_bar[2 * len + at];
            }
        }
    }
}
