//! A custom derivative rule for the solution of Kepler's equation. The derivative follows from the equation itself, so
//! the iterations of the solver are not differentiated.
//!
//! `cargo run -p cosmic-autodiff --example custom_rule`

use autodiff::check::{Options, Verdict, check_gradient};
use autodiff::custom::{Rule, apply};
use autodiff::{Function, Real};

/// The eccentric anomaly `E`, which solves `E - e sin E = M`, as a function of `x = [M, e]`.
#[derive(Clone)]
struct EccentricAnomaly;

impl Rule for EccentricAnomaly {
    fn value<R: Real>(&self, x: &[R]) -> R {
        let [mean_anomaly, eccentricity] = [x[0], x[1]];
        let mut anomaly = mean_anomaly + eccentricity * mean_anomaly.sin();
        for _ in 0..8 {
            let residual = anomaly - eccentricity * anomaly.sin() - mean_anomaly;
            anomaly -= residual / (R::one() - eccentricity * anomaly.cos());
        }
        anomaly
    }

    /// The partials follow from the implicit function theorem.
    fn partials<R: Real>(&self, x: &[R], anomaly: R) -> Vec<R> {
        let by_mean_anomaly = (R::one() - x[1] * anomaly.cos()).recip();
        vec![by_mean_anomaly, anomaly.sin() * by_mean_anomaly]
    }
}

/// The distance of the orbiting body from the focus, in units of the semi-major axis.
struct Distance;

impl Function for Distance {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        R::one() - x[1] * apply(EccentricAnomaly, x).cos()
    }
}

fn main() {
    let report = check_gradient(&Distance, &[1.0, 0.4], &Options::default());
    println!("{report}");
    assert_eq!(report.verdict, Verdict::Smooth);
}
