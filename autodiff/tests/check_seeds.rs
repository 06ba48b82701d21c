//! The gradient checker over many seeds: what is easily taken for something else.

use crate::check::{claimed, point, seeds};
use autodiff::check::{Options, Report, Verdict};
use autodiff::{Function, Real, gradient};

const SEEDS: u64 = 100;

/// A function, a point, and the gradient that is claimed there.
struct Subject<F> {
    value: F,
    x: Vec<f64>,
    gradient: Vec<f64>,
}

impl<F: Fn(&[f64]) -> f64> Subject<F> {
    fn new(value: F, x: &[f64], gradient: &[f64]) -> Self {
        Subject {
            value,
            x: x.to_vec(),
            gradient: gradient.to_vec(),
        }
    }

    fn reports(&self, options: Options) -> Vec<Report> {
        let check = |Options { seed, .. }| {
            let options = Options {
                seed,
                ..options.clone()
            };
            claimed(&self.value, [&self.x, &self.gradient], &options)
        };
        seeds(SEEDS).map(check).collect()
    }

    /// Every seed must give this verdict, and none may believe the negative control.
    fn is(&self, verdict: Verdict, name: &str) {
        for (seed, report) in self.reports(Options::default()).iter().enumerate() {
            assert_eq!(report.verdict, verdict, "{name}, seed {seed}\n{report}");
            let found_out = report.control.is_none_or(|said| said == Verdict::Wrong);
            assert!(found_out, "{name}, seed {seed}\n{report}");
        }
    }
}

/// Zero at its minimum, where all components are one.
struct Rosenbrock;

impl Function for Rosenbrock {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        x.windows(2).fold(R::zero(), |sum, x| {
            let valley = x[1] - x[0] * x[0];
            sum + (R::one() - x[0]).powi(2) + R::lit(100.0) * valley * valley
        })
    }
}

fn rosenbrock(x: &[f64]) -> f64 {
    Rosenbrock.eval(x)
}

/// Noise in `[-1, 1)`, a function of its arguments.
fn noise(x: &[f64]) -> f64 {
    let bits = x.iter().fold(0x1234_5678_u64, |bits, x| {
        let bits = (bits ^ x.to_bits()).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let bits = (bits ^ (bits >> 29)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^ (bits >> 32)
    });
    (bits >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

fn sines(x: &[f64]) -> f64 {
    x.iter().map(|x| x.sin()).sum()
}

/// Squares of the residuals of a model that fits its data, at the point of `x.len()` components.
fn misfit(x: &[f64]) -> f64 {
    let at = point(x.len());
    let residual = |k: usize| {
        let row = (0..x.len()).map(|i| noise(&[k as f64, i as f64]));
        let pairs = row.zip(x.iter().zip(&at));
        let (model, data) = pairs.fold((0.0, 0.0), |(model, data), (a, (x, at))| {
            (model + a * x, data + a * at)
        });
        f64::tanh(model) - f64::tanh(data)
    };
    (0..4 * x.len()).map(|k| residual(k).powi(2)).sum()
}

#[test]
fn right_gradients_at_minima_of_zero_are_smooth() {
    for n in [2, 10, 100] {
        Subject::new(rosenbrock, &vec![1.0; n], &vec![0.0; n]).is(Verdict::Smooth, "zero");
    }
    for scale in [1e-300, 1.0, 1e300] {
        let scaled = |x: &[f64]| scale * rosenbrock(x);
        Subject::new(scaled, &[1.0; 2], &[0.0; 2]).is(Verdict::Smooth, "scaled");
    }
    for raised in [1.0, 1e6] {
        let raised = |x: &[f64]| raised + rosenbrock(x);
        Subject::new(raised, &[1.0; 2], &[0.0; 2]).is(Verdict::Smooth, "raised");
    }
    for n in [1, 2, 5, 20] {
        Subject::new(misfit, &point(n), &vec![0.0; n]).is(Verdict::Smooth, "perfect fit");
    }
    for beside in [1e-12, 1e-10, 1e-8, 1e-6, 1e-3] {
        let x = [1.0 + beside, 1.0];
        Subject::new(rosenbrock, &x, &gradient(|x| Rosenbrock.eval(x), &x))
            .is(Verdict::Smooth, "beside");
    }
}

#[test]
fn right_gradients_where_slopes_vanish_are_smooth() {
    Subject::new(|x| x[0].powi(3), &[0.0], &[0.0]).is(Verdict::Smooth, "cube");
    Subject::new(|x| (x[0] - 0.3).powi(3), &[0.3], &[0.0]).is(Verdict::Smooth, "cube beside zero");
    Subject::new(|x| x[0] * x[0].abs(), &[0.0], &[0.0]).is(Verdict::Smooth, "x |x|");
    Subject::new(|x| x[0].max(0.0).powi(2), &[0.0], &[0.0]).is(Verdict::Smooth, "half a square");
    Subject::new(|_| 0.0, &[0.3], &[0.0]).is(Verdict::Smooth, "zero");
}

/// The negative control of the two tests above.
#[test]
fn wrong_gradients_at_minima_are_wrong() {
    for claimed in [1e-8, 1e-6, 1e-3, 1.0] {
        Subject::new(rosenbrock, &[1.0; 2], &[0.0, claimed]).is(Verdict::Wrong, "zero");
        let raised = |x: &[f64]| 1.0 + rosenbrock(x);
        Subject::new(raised, &[1.0; 2], &[0.0, claimed]).is(Verdict::Wrong, "raised");
        Subject::new(|x| x[0].powi(3), &[0.0], &[claimed]).is(Verdict::Wrong, "cube");
    }
}

#[test]
fn spikes_and_cusps_are_kinks() {
    for height in [1.0, 1e-3, 1e-6, 1e-9] {
        let spike = |x: &[f64]| x[0] + x[1].sin() + if x[0] == 0.0 { height } else { 0.0 };
        let gradient = [1.0, 0.3f64.cos()];
        Subject::new(spike, &[0.0, 0.3], &gradient).is(Verdict::Kink, "spike");
    }
    for power in [0.1, 1.0 / 3.0, 0.5, 0.9] {
        let cusp = |x: &[f64]| x[0].abs().powf(power);
        Subject::new(cusp, &[0.0], &[0.0]).is(Verdict::Kink, "cusp");
        let slope = 0.2f64.exp();
        let cusp = |x: &[f64]| cusp(x) + x[1].exp();
        Subject::new(cusp, &[0.0, 0.2], &[0.0, slope]).is(Verdict::Kink, "cusp with company");
    }
}

/// A kink that the curvature hides but for the smallest steps.
#[test]
fn small_kinks_are_kinks() {
    let kink = |x: &[f64]| 1e-3 * x[0].abs() + x[0] * x[0] + x[0];
    Subject::new(kink, &[0.0], &[1.0]).is(Verdict::Kink, "small");
}

/// A term that has its slope at the point, and elsewhere a value of zero, of the given width.
fn bump(x: &[f64], width: f64) -> f64 {
    x[0] + x[1].sin() + (-(x[0] / width).powi(2)).exp()
}

#[test]
fn a_narrow_term_that_is_forgotten_is_wrong_and_named() {
    for width in [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8] {
        let value = |x: &[f64]| bump(x, width);
        let forgotten = Subject::new(value, &[width, 0.4], &[1.0, 0.4f64.cos()]);
        for report in forgotten.reports(Options::default()) {
            assert_eq!(report.verdict, Verdict::Wrong, "{width:e}\n{report}");
            assert_eq!(report.worst.index, 0, "{width:e}\n{report}");
            assert_eq!(report.worst.verdict, Verdict::Wrong, "{width:e}\n{report}");
        }
        let slope = 1.0 - 2.0 / width * (-1f64).exp();
        let right = Subject::new(value, &[width, 0.4], &[slope, 0.4f64.cos()]);
        right.is(Verdict::Smooth, &format!("{width:e}, right"));
        let top = Subject::new(value, &[0.0, 0.4], &[1.0, 0.4f64.cos()]);
        top.is(Verdict::Smooth, &format!("{width:e}, at the top"));
    }
}

/// Narrower than the smallest step, a term is a spike to differences.
#[test]
fn a_term_too_narrow_to_see_does_not_pass() {
    for width in [1e-10, 1e-11, 1e-12] {
        let value = |x: &[f64]| bump(x, width);
        let forgotten = Subject::new(value, &[width, 0.4], &[1.0, 0.4f64.cos()]);
        for report in forgotten.reports(Options::default()) {
            assert_ne!(report.verdict, Verdict::Smooth, "{width:e}\n{report}");
        }
    }
}

#[test]
fn a_kink_inside_a_narrow_term_is_a_kink() {
    let width = 1e-5;
    let value = |x: &[f64]| bump(x, width) + 1e4 * x[2].abs();
    let slope = 1.0 - 2.0 / width * (-1f64).exp();
    let claimed = [slope, 0.4f64.cos(), 0.0];
    Subject::new(value, &[width, 0.4, 0.0], &claimed).is(Verdict::Kink, "both");
}

#[test]
fn noise_is_no_kink() {
    let slopes: Vec<f64> = point(5).iter().map(|x| x.cos()).collect();
    let subject = |size: f64, factor: f64| {
        let slopes: Vec<f64> = slopes.iter().map(|slope| factor * slope).collect();
        Subject::new(
            move |x: &[f64]| sines(x) + size * noise(x),
            &point(5),
            &slopes,
        )
    };
    for size in [1e-15, 1e-13, 1e-11, 1e-10] {
        let reports = subject(size, 1.0).reports(Options::default());
        let smooth = reports
            .iter()
            .filter(|report| report.verdict == Verdict::Smooth);
        // Noise that the options do not know of may settle on a wrong slope by chance.
        assert!(smooth.count() as u64 >= SEEDS - 2, "{size:e}");
        let options = Options {
            noise: size.max(f64::EPSILON),
            ..Options::default()
        };
        for report in subject(size, 1.0).reports(options.clone()) {
            assert_eq!(report.verdict, Verdict::Smooth, "{size:e}\n{report}");
        }
        for report in subject(size, 1.02).reports(options) {
            assert_eq!(report.verdict, Verdict::Wrong, "{size:e}\n{report}");
        }
    }
}

#[test]
fn one_wrong_component_of_a_thousand_is_named() {
    let x = point(1000);
    for wrong in [1e-4, 1e-2, 1.0] {
        let mut claimed: Vec<f64> = x.iter().map(|x| x.cos()).collect();
        claimed[417] *= 1.0 + wrong;
        for report in Subject::new(sines, &x, &claimed).reports(Options::default()) {
            assert_eq!(report.verdict, Verdict::Wrong, "{wrong:e}\n{report}");
            assert_eq!(report.worst.index, 417, "{wrong:e}\n{report}");
        }
    }
}

/// A function that varies over less than the smallest step needs smaller steps.
#[test]
fn small_lengths_need_small_steps() {
    let x = 1e-9;
    let inverse = |factor: f64| Subject::new(|x: &[f64]| 1.0 / x[0], &[x], &[-factor / x / x]);
    inverse(1.0).is(Verdict::Kink, "steps too large");
    let options = Options {
        smallest_step: 1e-16,
        ..Options::default()
    };
    for (factor, verdict) in [(1.0, Verdict::Smooth), (1.001, Verdict::Wrong)] {
        for report in inverse(factor).reports(options.clone()) {
            assert_eq!(report.verdict, verdict, "{report}");
        }
    }
}

/// Three tolerances off, at any scale of the function.
#[test]
fn small_errors_are_wrong() {
    let slopes: Vec<f64> = point(5).iter().map(|x| x.cos()).collect();
    for scale in [1e-300, 1e-6, 1.0, 1e6, 1e305] {
        for (factor, verdict) in [(1.0, Verdict::Smooth), (1.0 + 3e-6, Verdict::Wrong)] {
            let claimed: Vec<f64> = slopes.iter().map(|slope| scale * factor * slope).collect();
            let value = |x: &[f64]| scale * sines(x);
            let reports = Subject::new(value, &point(5), &claimed).reports(Options::default());
            let same = reports.iter().filter(|report| report.verdict == verdict);
            // Directions that happen to be nearly at right angles to the error do not show it.
            assert!(same.count() as u64 >= SEEDS - 1, "{scale:e} by {factor}");
        }
    }
}
