//! The order at which the remainder of the linear approximation falls with the step.

use super::slopes::{Quotients, missed};

/// A remainder is clear of the noise if it is this many times as large. With steps half a decade apart, noise then
/// changes a local order by at most a twentieth.
const CLEAR: f64 = 32.0;

/// The number of clear steps, from the smallest on, whose median counts. A median of so many tolerates two outliers.
/// At the smallest steps a small error of the slope shows, and a kink beside the point does not.
const LOCAL: usize = 5;

/// Returns the order at which `|f(x + h d) - f(x) - h slope|` falls with `h`: the median of the orders between
/// neighbouring steps, over the smallest steps that are clear of the noise. The remainder is the larger one ahead and
/// behind, so that a change of sign on one side does not count as a fall. The noise is the larger of two: the stated
/// noise, and the noise observed at steps smaller than `rests`, the step of the plateau. `None` if no two
/// neighbouring steps are clear.
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
