//! Statistics of a sample with the standard error of the median.

use cosmic::judge::Quantiles;
use cosmic::numbers::finite;

/// The statistics of a sample of runs. A number is `None` if it depends on a diverged run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statistics {
    /// The largest number of the sample.
    pub best: Option<f64>,
    /// The 10 % quantile.
    pub p10: Option<f64>,
    /// The median.
    pub median: Option<f64>,
    /// The 90 % quantile.
    pub p90: Option<f64>,
    /// The standard error of the median, estimated by the bootstrap; `None` for a sample of one number.
    pub standard_error: Option<f64>,
}

impl Statistics {
    /// Computes the statistics of a sample. In the sample, NaN stands for a diverged run and counts as the lowest
    /// number.
    pub fn of(sample: &[f64]) -> Self {
        if sample.is_empty() {
            return Self::default();
        }
        let spread = Quantiles::of(sample);
        Self {
            best: finite(sample.iter().copied().fold(f64::NEG_INFINITY, f64::max)),
            p10: finite(spread.p10),
            median: finite(spread.p50),
            p90: finite(spread.p90),
            standard_error: finite(Quantiles::median_error(sample)).filter(|_| sample.len() > 1),
        }
    }
}
