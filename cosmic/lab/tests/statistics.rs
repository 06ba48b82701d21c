use cosmic::random::{Purpose, stream};
use cosmic_lab::statistics::Statistics;
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
