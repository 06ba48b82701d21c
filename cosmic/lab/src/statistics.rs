//! Statistics of a sample with their standard errors.

use cosmic::codesign::Quantiles;
use cosmic::random::{Purpose, stream};
use rand::RngExt;

/// The number of resamples for the error of a median.
const RESAMPLES: usize = 1000;

/// The statistics of a sample. A number that depends on a diverged run is `None`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Statistics {
    /// The largest number.
    pub(crate) best: Option<f64>,
    pub(crate) p10: Option<f64>,
    pub(crate) median: Option<f64>,
    pub(crate) p90: Option<f64>,
    /// The standard error of the median, by the bootstrap; `None` for a single number.
    pub(crate) standard_error: Option<f64>,
}

impl Statistics {
    /// The statistics of a sample. A diverged run is NaN in the sample, and counts as lowest.
    pub(crate) fn of(sample: &[f64]) -> Self {
        if sample.is_empty() {
            return Self::default();
        }
        let spread = Quantiles::of(sample);
        Self {
            best: finite(sample.iter().copied().fold(f64::NEG_INFINITY, f64::max)),
            p10: finite(spread.p10),
            median: finite(spread.p50),
            p90: finite(spread.p90),
            standard_error: finite(standard_error(sample)).filter(|_| sample.len() > 1),
        }
    }
}

fn finite(x: f64) -> Option<f64> {
    Some(x).filter(|x| x.is_finite())
}

/// The mean of a sample, and its estimate of the population's variance.
fn mean_and_variance(sample: &[f64]) -> [f64; 2] {
    let count = sample.len() as f64;
    let mean = sample.iter().sum::<f64>() / count;
    let squares: f64 = sample.iter().map(|x| (x - mean).powi(2)).sum();
    [mean, squares / (count - 1.0)]
}

/// The mean of a sample and its standard error; `None` for a single number.
pub(crate) fn mean(sample: &[f64]) -> Option<[f64; 2]> {
    let [mean, variance] = mean_and_variance(sample);
    (sample.len() > 1).then(|| [mean, (variance / sample.len() as f64).sqrt()])
}

/// The standard deviation of the medians of resamples, drawn with replacement. The random stream is fixed, so that the
/// result depends only on the sample.
fn standard_error(sample: &[f64]) -> f64 {
    let mut stream = stream(0, Purpose::Bootstrap);
    let mut again = vec![0.0; sample.len()];
    let mut draw = |_| {
        again.fill_with(|| sample[stream.random_range(0..sample.len())]);
        Quantiles::of(&again).p50
    };
    let medians: Vec<f64> = (0..RESAMPLES).map(&mut draw).collect();
    mean_and_variance(&medians)[1].sqrt()
}

#[cfg(test)]
mod tests {
    use super::{Statistics, mean};
    use cosmic::random::{Purpose, stream};
    use rand::RngExt;

    #[test]
    fn diverged_runs_count_lowest() {
        let sample = [2.0, f64::NAN, 1.0];
        let statistics = Statistics::of(&sample);
        assert_eq!((statistics.best, statistics.median), (Some(2.0), Some(1.0)));
        assert_eq!((statistics.p10, statistics.standard_error), (None, None));
        assert_eq!(Statistics::of(&[]).best, None);
    }

    #[test]
    fn the_error_of_the_median_of_a_uniform_sample_is_known() {
        let mut stream = stream(7, Purpose::Weights);
        let sample: Vec<f64> = (0..400).map(|_| stream.random()).collect();
        let error = Statistics::of(&sample).standard_error.unwrap();
        // The exact error is 1 / (2 f sqrt(n)) = 0.025, because the density f is 1. The bootstrap estimates it from a
        // single sample, so a factor of two is allowed.
        assert!((0.0125..0.05).contains(&error), "{error}");
        let error = |sample: &[f64]| Statistics::of(sample).standard_error;
        assert_eq!([error(&[3.0; 9]), error(&[3.0])], [Some(0.0), None]);
    }

    #[test]
    fn the_error_of_a_mean_is_the_scatter_over_the_root_of_the_count() {
        assert_eq!(mean(&[1.0, 3.0]), Some([2.0, 1.0]));
        assert_eq!(mean(&[0.0, 0.0, 2.0, 2.0]).map(|[m, _]| m), Some(1.0));
        assert_eq!(mean(&[1.0]), None);
    }
}
