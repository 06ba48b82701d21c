//! Checks with many seeds, for functions that are easily misjudged.

use crate::check::{claimed, point, seeds};
use autodiff::check::{Options, Report, Verdict};
use autodiff::{Real, gradient};

const SEEDS: u64 = 100;

type Value<'a> = &'a dyn Fn(&[f64]) -> f64;

/// Returns the reports of checks of a claimed gradient at a point, with many seeds.
fn reports(value: Value, [x, gradient]: [&[f64]; 2], options: &Options) -> Vec<Report> {
    let check = |Options { seed, .. }| {
        let options = Options {
            seed,
            ..options.clone()
        };
        claimed(value, [x, gradient], &options)
    };
    seeds(SEEDS).map(check).collect()
}

/// Asserts that every seed gives this verdict, and that no seed accepts the negative control.
fn is(verdict: Verdict, name: &str, value: Value, x: &[f64], gradient: &[f64]) {
    let reports = reports(value, [x, gradient], &Options::default());
    for (seed, report) in reports.iter().enumerate() {
        assert_eq!(report.verdict, verdict, "{name}, seed {seed}\n{report}");
        let found_out = report.control.is_none_or(|said| said == Verdict::Wrong);
        assert!(found_out, "{name}, seed {seed}\n{report}");
    }
}

/// Rosenbrock's function. At its minimum the value is zero and all arguments are one.
fn rosenbrock<R: Real>(x: &[R]) -> R {
    x.windows(2).fold(R::zero(), |sum, x| {
        let valley = x[1] - x[0] * x[0];
        sum + (R::one() - x[0]).powi(2) + R::lit(100.0) * valley * valley
    })
}

/// Returns noise in `[-1, 1)` that depends only on the arguments.
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

/// The sum of squared residuals of a model that fits its data exactly.
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
fn right_gradients_where_slopes_vanish_are_smooth() {
    let smooth = |name, value: Value, x: &[f64]| {
        is(Verdict::Smooth, name, value, x, &vec![0.0; x.len()]);
    };
    for n in [2, 10, 100] {
        smooth("minimum", &rosenbrock::<f64>, &vec![1.0; n]);
    }
    for scale in [1e-300, 1e300] {
        smooth("scaled", &|x| scale * rosenbrock(x), &[1.0; 2]);
    }
    for raised in [1.0, 1e6] {
        smooth("raised", &|x| raised + rosenbrock(x), &[1.0; 2]);
    }
    for n in [1, 2, 5, 20] {
        smooth("perfect fit", &misfit, &point(n));
    }
    smooth("cube", &|x| x[0].powi(3), &[0.0]);
    smooth("cube beside zero", &|x| (x[0] - 0.3).powi(3), &[0.3]);
    smooth("x |x|", &|x| x[0] * x[0].abs(), &[0.0]);
    smooth("half a square", &|x| x[0].max(0.0).powi(2), &[0.0]);
    smooth("zero", &|_| 0.0, &[0.3]);
    let flat = |x: &[f64]| 1e3 * (x[0].sin().powi(2) + x[0].cos().powi(2));
    smooth("a large value", &flat, &[0.7]);
    for beside in [1e-12, 1e-10, 1e-8, 1e-6, 1e-3] {
        let x = [1.0 + beside, 1.0];
        let slopes = gradient(rosenbrock, &x);
        is(Verdict::Smooth, "beside", &rosenbrock::<f64>, &x, &slopes);
    }
}

/// Wrong gradients at the minima of the test above must be found.
#[test]
fn wrong_gradients_at_minima_are_wrong() {
    for claimed in [1e-8, 1e-6, 1e-3, 1.0] {
        let wrong = |name, value: Value, x: &[f64], slopes: &[f64]| {
            is(Verdict::Wrong, name, value, x, slopes);
        };
        wrong("zero", &rosenbrock::<f64>, &[1.0; 2], &[0.0, claimed]);
        let raised = |x: &[f64]| 1.0 + rosenbrock(x);
        wrong("raised", &raised, &[1.0; 2], &[0.0, claimed]);
        wrong("cube", &|x| x[0].powi(3), &[0.0], &[claimed]);
    }
}

#[test]
fn spikes_cusps_and_small_kinks_are_kinks() {
    let kink = |name, value: Value, x: &[f64], slopes: &[f64]| {
        is(Verdict::Kink, name, value, x, slopes);
    };
    for height in [1.0, 1e-3, 1e-6, 1e-9] {
        let spike = |x: &[f64]| x[0] + x[1].sin() + if x[0] == 0.0 { height } else { 0.0 };
        kink("spike", &spike, &[0.0, 0.3], &[1.0, 0.3f64.cos()]);
    }
    for power in [0.1, 1.0 / 3.0, 0.5, 0.9] {
        let cusp = |x: &[f64]| x[0].abs().powf(power);
        kink("cusp", &cusp, &[0.0], &[0.0]);
        let joined = |x: &[f64]| cusp(x) + x[1].exp();
        kink("cusp and slope", &joined, &[0.0, 0.2], &[0.0, 0.2f64.exp()]);
    }
    // The kink is small compared to the curvature, so it shows only at the smallest steps.
    let small = |x: &[f64]| 1e-3 * x[0].abs() + x[0] * x[0] + x[0];
    kink("small", &small, &[0.0], &[1.0]);
}

/// A smooth function plus a bump of the given width around `x[0] = 0`.
fn bump(x: &[f64], width: f64) -> f64 {
    x[0] + x[1].sin() + (-(x[0] / width).powi(2)).exp()
}

#[test]
fn a_narrow_term_that_is_forgotten_is_wrong_and_named() {
    let cos = 0.4f64.cos();
    for width in [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8] {
        let value = |x: &[f64]| bump(x, width);
        let at = [width, 0.4];
        for report in reports(&value, [&at, &[1.0, cos]], &Options::default()) {
            assert_eq!(report.verdict, Verdict::Wrong, "{width:e}\n{report}");
            assert_eq!(report.worst.index, 0, "{width:e}\n{report}");
            assert_eq!(report.worst.verdict, Verdict::Wrong, "{width:e}\n{report}");
        }
        let slope = 1.0 - 2.0 / width * (-1f64).exp();
        is(Verdict::Smooth, "right", &value, &at, &[slope, cos]);
        is(
            Verdict::Smooth,
            "at the top",
            &value,
            &[0.0, 0.4],
            &[1.0, cos],
        );
    }
    // If the bump is narrower than the smallest step, differences see only a spike.
    for width in [1e-10, 1e-11, 1e-12] {
        let value = |x: &[f64]| bump(x, width);
        for report in reports(&value, [&[width, 0.4], &[1.0, cos]], &Options::default()) {
            assert_ne!(report.verdict, Verdict::Smooth, "{width:e}\n{report}");
        }
    }
    let width = 1e-5;
    let kink = |x: &[f64]| bump(x, width) + 1e4 * x[2].abs();
    let slope = 1.0 - 2.0 / width * (-1f64).exp();
    is(
        Verdict::Kink,
        "a kink inside",
        &kink,
        &[width, 0.4, 0.0],
        &[slope, cos, 0.0],
    );
}

#[test]
fn noise_is_no_kink() {
    let x = point(5);
    for size in [1e-15, 1e-13, 1e-11, 1e-10] {
        let value = |x: &[f64]| sines(x) + size * noise(x);
        let of = |factor: f64, options: &Options| {
            let slopes: Vec<f64> = x.iter().map(|x| factor * x.cos()).collect();
            reports(&value, [&x, &slopes], options)
        };
        let smooth = of(1.0, &Options::default());
        let smooth = smooth.iter().filter(|r| r.verdict == Verdict::Smooth);
        // If the options do not state the noise, the differences may settle on a wrong slope by chance.
        assert!(smooth.count() as u64 >= SEEDS - 2, "{size:e}");
        let options = Options {
            noise: size.max(f64::EPSILON),
            ..Options::default()
        };
        for (factor, verdict) in [(1.0, Verdict::Smooth), (1.02, Verdict::Wrong)] {
            for report in of(factor, &options) {
                assert_eq!(report.verdict, verdict, "{size:e}\n{report}");
            }
        }
    }
}

#[test]
fn one_wrong_component_of_a_thousand_is_named() {
    let x = point(1000);
    for wrong in [1e-4, 1e-2, 1.0] {
        let mut claimed: Vec<f64> = x.iter().map(|x| x.cos()).collect();
        claimed[417] *= 1.0 + wrong;
        for report in reports(&sines, [&x, &claimed], &Options::default()) {
            assert_eq!(report.verdict, Verdict::Wrong, "{wrong:e}\n{report}");
            assert_eq!(report.worst.index, 417, "{wrong:e}\n{report}");
        }
    }
}

/// If a function varies over less than the smallest step, the check is right only with smaller steps in the options.
#[test]
fn small_lengths_need_small_steps() {
    let (x, inverse) = (1e-9, |x: &[f64]| 1.0 / x[0]);
    is(
        Verdict::Kink,
        "steps too large",
        &inverse,
        &[x],
        &[-1.0 / x / x],
    );
    let options = Options {
        smallest_step: 1e-16,
        ..Options::default()
    };
    for (factor, verdict) in [(1.0, Verdict::Smooth), (1.001, Verdict::Wrong)] {
        for report in reports(&inverse, [&[x], &[-factor / x / x]], &options) {
            assert_eq!(report.verdict, verdict, "{report}");
        }
    }
}

/// An error of three times the tolerance must be found, at any scale of the function.
#[test]
fn small_errors_are_wrong() {
    let x = point(5);
    for scale in [1e-300, 1e-6, 1.0, 1e6, 1e305] {
        for (factor, verdict) in [(1.0, Verdict::Smooth), (1.0 + 3e-6, Verdict::Wrong)] {
            let claimed: Vec<f64> = x.iter().map(|x| scale * factor * x.cos()).collect();
            let value = |x: &[f64]| scale * sines(x);
            let reports = reports(&value, [&x, &claimed], &Options::default());
            let same = reports.iter().filter(|report| report.verdict == verdict);
            // A direction that is nearly at right angles to the error does not show the error.
            assert!(same.count() as u64 >= SEEDS - 1, "{scale:e} by {factor}");
        }
    }
}
