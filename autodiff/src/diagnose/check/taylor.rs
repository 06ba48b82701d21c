//! Measures the order at which the remainder of the linear approximation falls with the step.

use super::slopes::{Quotients, missed};

/// A remainder counts as clear of the noise if it is this many times as large as the noise. Then noise changes the
/// order between two neighbouring steps, half a decade apart, by at most a twentieth.
const CLEAR: f64 = 32.0;

/// The number of orders, from the smallest clear steps on, whose median is taken. A median of five tolerates two
/// outliers. Only the smallest steps are used, because a small error of the slope shows there and a kink beside the
/// point does not.
const LOCAL: usize = 5;

/// Returns the order at which the remainder `|f(x + h d) - f(x) - h slope|` falls with `h`. It is the median of the
/// orders between neighbouring steps, over the smallest steps whose remainders are clear of the noise. The remainder is
/// taken on both sides of the point and the larger one counts, so that a change of sign on one side does not look like
/// a fall. The noise is the noise of the options or the noise observed at steps smaller than `rests`, whichever is
/// larger; `rests` is the step of the plateau. `None` if no two neighbouring steps are clear.
pub(super) fn order(sweep: &[Quotients], slope: f64, rests: f64) -> Option<f64> {
    let level = sweep.iter().position(|slopes| slopes.step == rests)?;
    let missed = missed(sweep, level);
    let clear = |slopes: &Quotients| {
        let remainder = slopes.step * slopes.steepest(slope);
        let noise = missed.max(slopes.step * slopes.noise);
        let is_clear = remainder.is_finite() && remainder > CLEAR * noise;
        is_clear.then(|| [slopes.step, remainder].map(f64::ln))
    };
    let points: Vec<_> = sweep.iter().map(clear).collect();
    let local = |pair: &[Option<[f64; 2]>]| {
        let ([far, more], [near, less]) = (pair[0]?, pair[1]?);
        Some((more - less) / (far - near))
    };
    let orders = points.windows(2).rev().filter_map(local);
    let mut orders: Vec<f64> = orders.take(LOCAL).collect();
    orders.sort_by(f64::total_cmp);
    let middle = orders.len() / 2;
    let upper = *orders.get(middle)?;
    Some(match orders.len() % 2 {
        0 => 0.5 * (orders[middle - 1] + upper),
        _ => upper,
    })
}
