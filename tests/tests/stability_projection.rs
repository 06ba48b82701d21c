//! The projections at the extremes, and the derivative that stands in for the sharp one's.

use autodiff::{Real, VectorFunction, jacobian, vjp};
use cosmic::projection::{Holds, Projection, mixtures, softmax};
use cosmic::scene::ProjectionSettings;
use cosmic_tests::{assert_near, own_reference_folder, references, stability_cases};

struct Softmax {
    beta: f64,
}

impl VectorFunction for Softmax {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        softmax([x[0], x[1], x[2]], self.beta).to_vec()
    }
}

#[test]
fn softmax_values() {
    for case in stability_cases("jacobian_dp_dz") {
        let beta = case.number("beta");
        let shares = Softmax { beta }.eval(&case.numbers("z"));
        for (got, expected) in shares.into_iter().zip(case.numbers("p")) {
            let tolerance = case.of_file("tolerance_abs_p");
            assert_near(got, expected, tolerance, &case.case);
        }
    }
}

#[test]
fn softmax_jacobians_forward_and_reverse() {
    for case in stability_cases("jacobian_dp_dz") {
        let (z, beta) = (case.numbers("z"), case.number("beta"));
        let forward = jacobian(&Softmax { beta }, &z);
        let expected = case.numbers("jacobian_dp_dz");
        let expected: &[[f64; 3]] = expected.as_chunks().0;
        for i in 0..3 {
            let mut row = [0.0; 3];
            row[i] = 1.0;
            let (_, reverse) = vjp(&Softmax { beta }, &z, &row);
            for k in 0..3 {
                // The file's bound: shares are rounded at 1e-16, which beta multiplies.
                for got in [forward[i][k], reverse[k]] {
                    assert_near(got, expected[i][k], 1e-12 * beta, &case.case);
                }
            }
        }
    }
}

struct Projected {
    projection: Projection,
    settings: ProjectionSettings,
}

impl VectorFunction for Projected {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let (z, _) = x.as_chunks();
        let mixtures = mixtures(self.projection, z, &self.settings, &Holds::default());
        mixtures.iter().flat_map(|mixture| mixture.0).collect()
    }
}

/// The stability projection has the value of its sharp softmax and the derivative of its soft
/// one, the mean over the edges included.
#[test]
fn straight_through() {
    for reference in references(&own_reference_folder()) {
        let case = reference.case();
        let project = |settings: &ProjectionSettings| Projected {
            projection: Projection::Stability,
            settings: settings.clone(),
        };
        let blend = project(&case.sharpness);
        // With the soft sharpness for the value too, the two softmaxes are one.
        let soft = project(&ProjectionSettings {
            beta_stability: case.sharpness.beta_straight_through,
            ..case.sharpness.clone()
        });
        let z = &case.design.vectors().into_owned().into_flattened();
        let cotangent: Vec<f64> = (0..z.len()).map(|i| (i as f64).sin()).collect();
        let (values, got) = vjp(&blend, z, &cotangent);
        let (soft_values, expected) = vjp(&soft, z, &cotangent);
        assert_eq!(values, blend.eval(z));
        assert_ne!(values, soft_values, "the values are the sharp ones");
        assert_eq!(got, expected);
    }
}
