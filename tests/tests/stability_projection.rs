//! The projections at the extremes, and the derivative that stands in for the sharp one's.

use autodiff::{Real, VectorFunction, jacobian, vjp};
use cosmic::case::Case;
use cosmic::projection::{Projection, mixture, softmax};
use cosmic::scene::ProjectionSettings;
use cosmic_tests::{numbers, own_reference_folder, references, stability_folder};
use serde_json::Value;

struct Softmax {
    beta: f64,
}

impl VectorFunction for Softmax {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        softmax([x[0], x[1], x[2]], self.beta).to_vec()
    }
}

/// Softmax cases are those that list its Jacobian.
fn softmax_cases() -> Vec<(Value, f64)> {
    let files = references(&stability_folder()).into_iter();
    let cases: Vec<(Value, f64)> = files
        .flat_map(|file| {
            let tolerance = file.json["tolerance_abs_p"].as_f64();
            let cases = file.json["cases"].as_array().cloned().unwrap_or_default();
            cases
                .into_iter()
                .filter_map(move |case| Some((case, tolerance?)))
        })
        .filter(|(case, _)| case.get("jacobian_dp_dz").is_some())
        .collect();
    assert!(
        !cases.is_empty(),
        "no softmax case in {}",
        stability_folder().display()
    );
    cases
}

#[test]
fn softmax_values() {
    for (case, tolerance) in softmax_cases() {
        let z = numbers(&case["z"]);
        let beta = case["beta"].as_f64().expect("a number");
        let got = Softmax { beta }.eval(&z);
        for (got, expected) in got.iter().zip(numbers(&case["p"])) {
            assert!(
                (got - expected).abs() <= tolerance,
                "{case}: {got} for {expected}"
            );
        }
    }
}

#[test]
fn softmax_jacobians_forward_and_reverse() {
    for (case, _) in softmax_cases() {
        let z = numbers(&case["z"]);
        let beta = case["beta"].as_f64().expect("a number");
        let forward = jacobian(&Softmax { beta }, &z);
        for i in 0..3 {
            let mut row = [0.0; 3];
            row[i] = 1.0;
            let (_, reverse) = vjp(&Softmax { beta }, &z, &row);
            let expected = numbers(&case["jacobian_dp_dz"][i]);
            for k in 0..3 {
                // The file's bound: shares are rounded at 1e-16, which beta multiplies.
                let bound = 1e-12 * beta;
                assert!(
                    (forward[i][k] - expected[k]).abs() <= bound,
                    "forward, {case}"
                );
                assert!((reverse[k] - expected[k]).abs() <= bound, "reverse, {case}");
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
        mixture(self.projection, z, &self.settings, &[]).into_flattened()
    }
}

/// The stability projection has the value of its sharp softmax and the derivative of its soft
/// one, the mean over the edges included.
#[test]
fn straight_through() {
    for reference in references(&own_reference_folder()) {
        let case = Case::parse(&reference.name(), &reference.text)
            .unwrap_or_else(|error| panic!("{error}"));
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
        let z = case.z.as_flattened();
        let cotangent: Vec<f64> = (0..z.len()).map(|i| (i as f64).sin()).collect();
        let (values, got) = vjp(&blend, z, &cotangent);
        let (soft_values, expected) = vjp(&soft, z, &cotangent);
        assert_eq!(values, blend.eval(z));
        assert_ne!(values, soft_values, "the values are the sharp ones");
        assert_eq!(got, expected);
        check_by_differences(&soft, z, (&cotangent, &expected));
    }
}

/// A directional derivative against central differences.
fn check_by_differences(soft: &Projected, z: &[f64], (cotangent, gradient): (&[f64], &[f64])) {
    let direction: Vec<f64> = (0..z.len()).map(|i| (2.0 * i as f64).cos()).collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let at = |h: f64| {
        let moved: Vec<f64> = z.iter().zip(&direction).map(|(z, d)| z + h * d).collect();
        dot(&soft.eval(&moved), cotangent)
    };
    let h = 1e-5;
    let difference = (at(h) - at(-h)) / (2.0 * h);
    // Truncation is of order (beta h)^2 = 4e-8 of the sizes of the vectors; hundreds of shares
    // rounded at 1e-16 make 1e-9 when divided by h. A wrong mean is off by per cents.
    let scale = dot(gradient, gradient).sqrt() * dot(&direction, &direction).sqrt();
    assert!((difference - dot(gradient, &direction)).abs() <= 1e-6 * scale + 1e-9);
}
