//! Statistics of a sample with their standard errors.

use cosmic::codesign::Quantiles;
use cosmic::random::{Purpose, stream};
use rand::RngExt;

/// The number of resamples from which the standard error of a median is estimated.
const RESAMPLES: usize = 1000;

/// The statistics of a sample of runs. A number is `None` if it depends on a diverged run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Statistics {
    /// The largest number of the sample.
    pub(crate) best: Option<f64>,
    pub(crate) p10: Option<f64>,
    pub(crate) median: Option<f64>,
    pub(crate) p90: Option<f64>,
    /// The standard error of the median, estimated by the bootstrap; `None` for a sample of one number.
    pub(crate) standard_error: Option<f64>,
}

impl Statistics {
    /// Computes the statistics of a sample. In the sample, NaN stands for a diverged run and counts as the lowest
    /// number.
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

/// Returns the mean of a sample, and the estimate of the population's variance from the sample.
fn mean_and_variance(sample: &[f64]) -> [f64; 2] {
    let count = sample.len() as f64;
    let mean = sample.iter().sum::<f64>() / count;
    let squares: f64 = sample.iter().map(|x| (x - mean).powi(2)).sum();
    [mean, squares / (count - 1.0)]
}

/// Returns the mean of a sample and the standard error of the mean; `None` for a sample of one number.
pub(crate) fn mean(sample: &[f64]) -> Option<[f64; 2]> {
    let [mean, variance] = mean_and_variance(sample);
    (sample.len() > 1).then(|| [mean, (variance / sample.len() as f64).sqrt()])
}

/// Returns the bootstrap estimate of the median's standard error: the standard deviation of the medians of resamples,
/// which are drawn with replacement. The random stream is fixed, so the result depends only on the sample.
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
        // The exact standard error of the median is 1 / (2 f sqrt(n)) = 0.025, where the density f is 1. The bootstrap
        // estimates it from one sample, so the test allows a factor of two.
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
