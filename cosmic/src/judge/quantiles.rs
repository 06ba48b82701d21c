//! Quantiles of a robot's results from several starts.

use rand::RngExt;
use serde::{Deserialize, Serialize};

use crate::random::{Purpose, stream};

/// Three quantiles of a robot's results over several starts, mostly displacements along the ground in metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quantiles {
    /// 10 % quantile.
    pub p10: f64,
    /// Median.
    pub p50: f64,
    /// 90 % quantile.
    pub p90: f64,
}

impl Quantiles {
    /// The quantiles of a sample, with linear interpolation. NaN and infinities, from diverged rollouts, count as minus
    /// infinity. A quantile between minus infinity and a number is minus infinity.
    ///
    /// # Panics
    /// If the sample is empty.
    pub fn of(sample: &[f64]) -> Self {
        let sorted = sorted(sample);
        Self {
            p10: between(&sorted, 0.1),
            p50: between(&sorted, 0.5),
            p90: between(&sorted, 0.9),
        }
    }

    /// Returns the bootstrap estimate of the standard error of the sample's median: the standard deviation of the medians of
    /// resamples, which are drawn with replacement. The random stream is fixed, so the result depends only on the sample. It
    /// is not finite if a median is not.
    ///
    /// # Panics
    /// If the sample is empty.
    pub fn median_error(sample: &[f64]) -> f64 {
        let mut stream = stream(0, Purpose::Bootstrap);
        let mut again = vec![0.0; sample.len()];
        let mut draw = |_| {
            again.fill_with(|| sample[stream.random_range(0..sample.len())]);
            Self::of(&again).p50
        };
        let medians: Vec<f64> = (0..RESAMPLES).map(&mut draw).collect();
        let mean = medians.iter().sum::<f64>() / RESAMPLES as f64;
        let squares: f64 = medians.iter().map(|x| (x - mean).powi(2)).sum();
        (squares / (RESAMPLES as f64 - 1.0)).sqrt()
    }
}

/// The number of resamples from which the standard error of a median is estimated.
const RESAMPLES: usize = 1000;

/// What a number that is not finite counts as.
const FALLEN: f64 = f64::NEG_INFINITY;

fn sorted(sample: &[f64]) -> Vec<f64> {
    assert!(
        !sample.is_empty(),
        "the sample is empty, but quantiles need at least one number"
    );
    let finite = |&x: &f64| if x.is_finite() { x } else { FALLEN };
    let mut sorted: Vec<f64> = sample.iter().map(finite).collect();
    sorted.sort_by(f64::total_cmp);
    sorted
}

/// The quantile `q` of a sorted sample.
fn between(sorted: &[f64], q: f64) -> f64 {
    let at = q * (sorted.len() - 1) as f64;
    let (below, share) = (sorted[at.floor() as usize], at.fract());
    let above = sorted[at.ceil() as usize];
    if below.is_finite() {
        below + share * (above - below)
    } else {
        FALLEN
    }
}
