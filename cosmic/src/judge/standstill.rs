//! Where and since when a robot stands still at the end of its rollout.

use serde::{Deserialize, Serialize};

crate::keys! {
    /// A robot that stopped walking before the last quarter of its rollout.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    struct Standstill {
        /// The time after which it stands still.
        since: f64, "number", unit "s";
        /// Its displacement along the ground, at which it stands still.
        at: f64, "number", unit "m";
    }
}

/// The share of the rollout at its end in which a robot must stand still.
const LAST: f64 = 0.25;
/// A robot stands still while its mean place differs from the last one by at most this share of its whole way. At a
/// constant speed, it covers five times as much in the last quarter.
const STILL: f64 = 0.05;
/// A robot that never gets further than this share of the lattice's scale stays in place from the start. It is 1 cm in the
/// paper's scenes.
const LEAST: f64 = 0.01;

impl Standstill {
    /// Finds a standstill in the places of a robot along the ground (m) at ascending times (s), the first of which is 0.
    /// The sway of the gait does not count: places are means over a stride of `period` (s). A rollout whose last quarter is
    /// shorter than a stride has no standstill.
    /// `scale` is that of the [lattice](crate::lattice::Lattice::scale), m.
    pub fn of(times: &[f64], places: &[f64], period: f64, scale: f64) -> Option<Self> {
        let (start, end) = (*places.first()?, *times.last()?);
        if period > LAST * end {
            return None;
        }
        let mean = |k: usize| {
            let first = times.partition_point(|time| *time < times[k] - period);
            let window = &places[first..=k];
            window.iter().sum::<f64>() / window.len() as f64 - start
        };
        let means: Vec<f64> = (0..places.len()).map(mean).collect();
        let at = *means.last()?;
        // Earlier means are over less than a period, so they contain the sway.
        let whole = times.partition_point(|time| *time < period);
        let way = (means[whole..].iter()).fold(0.0, |way: f64, mean| way.max(mean.abs()));
        let is_elsewhere = |mean: &f64| (mean - at).abs() > STILL * way;
        let moving = means.iter().rposition(is_elsewhere)?;
        // A mean is half a period late.
        let since = (times[moving] - 0.5 * period).max(0.5 * times[moving + 1]);
        (way >= LEAST * scale && since <= (1.0 - LAST) * end).then_some(Self { since, at })
    }

    /// Why the distance of this robot says little about its walk.
    pub(super) fn reason(self) -> String {
        let Self { since, at } = self;
        format!("it stands still at {at:.2} m from {since:.1} s on")
    }
}
