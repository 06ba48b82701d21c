//! What a sample of seeds says, and how far it is to be trusted.

use cosmic::codesign::Quantiles;
use cosmic::random::{Purpose, stream};
use rand::RngExt;
use serde::Serialize;

/// How often a sample is drawn again for the error of its median.
const RESAMPLES: usize = 1000;

/// The statistics of a sample; a number that leans on a run that diverged is `None`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(super) struct Statistics {
    /// The largest number.
    pub(super) best: Option<f64>,
    /// The 10 % quantile.
    pub(super) p10: Option<f64>,
    /// The median.
    pub(super) median: Option<f64>,
    /// The 90 % quantile.
    pub(super) p90: Option<f64>,
    /// The standard error of the median, by the bootstrap; of two numbers or more.
    pub(super) standard_error: Option<f64>,
}

impl Statistics {
    /// Of a sample in which runs that diverged are `None`, and count lowest.
    pub(super) fn of(sample: &[Option<f64>]) -> Self {
        if sample.is_empty() {
            return Self::default();
        }
        let numbers: Vec<f64> = sample.iter().map(|x| x.unwrap_or(f64::NAN)).collect();
        let spread = Quantiles::of(&numbers);
        let finite = |x: f64| Some(x).filter(|x| x.is_finite());
        Self {
            best: finite(numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max)),
            p10: finite(spread.p10),
            median: finite(spread.p50),
            p90: finite(spread.p90),
            standard_error: finite(standard_error(&numbers)).filter(|_| numbers.len() > 1),
        }
    }
}

/// The mean of a sample and the variance of its population.
fn mean_and_variance(sample: &[f64]) -> [f64; 2] {
    let count = sample.len() as f64;
    let mean = sample.iter().sum::<f64>() / count;
    let squares: f64 = sample.iter().map(|x| (x - mean).powi(2)).sum();
    [mean, squares / (count - 1.0)]
}

/// The mean of a sample and its standard error, of two numbers or more.
pub(super) fn mean(sample: &[f64]) -> Option<[f64; 2]> {
    let [mean, variance] = mean_and_variance(sample);
    (sample.len() > 1).then(|| [mean, (variance / sample.len() as f64).sqrt()])
}

/// The scatter of the medians of samples drawn from this one with replacement. The stream is the
/// same for every sample: an error belongs to the sample and not to when it was asked for.
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
        let statistics = Statistics::of(&[Some(2.0), None, Some(1.0)]);
        assert_eq!((statistics.best, statistics.median), (Some(2.0), Some(1.0)));
        assert_eq!((statistics.p10, statistics.standard_error), (None, None));
        assert_eq!(Statistics::of(&[]).best, None);
    }

    #[test]
    fn the_error_of_the_median_of_a_uniform_sample_is_known() {
        let mut stream = stream(7, Purpose::Weights);
        let sample: Vec<_> = (0..400).map(|_| Some(stream.random::<f64>())).collect();
        let error = Statistics::of(&sample).standard_error.unwrap();
        // 1 / (2 f sqrt(n)) with density f = 1: 0.025. The bootstrap of one sample estimates it
        // to within some tens of a percent.
        assert!((0.0125..0.05).contains(&error), "{error}");
        assert_eq!(Statistics::of(&[Some(3.0); 9]).standard_error, Some(0.0));
    }

    #[test]
    fn the_error_of_a_mean_is_the_scatter_over_the_root_of_the_count() {
        assert_eq!(mean(&[1.0, 3.0]), Some([2.0, 1.0]));
        assert_eq!(mean(&[0.0, 0.0, 2.0, 2.0]).map(|[m, _]| m), Some(1.0));
        assert_eq!(mean(&[1.0]), None);
    }
}
