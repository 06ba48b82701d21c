//! The report of a check, apart from its verdict: the order of the remainder, the name of the worst component, and the
//! verdict on a gradient that is wrong on purpose.

use crate::check::{Smooth, claimed, point, seeds};
use autodiff::check::{Options, Report, Verdict, check_gradient};
use autodiff::{Function, gradient};

/// The tolerance for a measured order. Orders are measured between steps half a decade apart. There, rounding errors
/// and terms of higher order change the remainders by a few parts in a hundred.
const ORDER: f64 = 0.1;

/// A function of several numbers.
type Value<'a> = &'a dyn Fn(&[f64]) -> f64;

/// Returns the measured order of the remainder for each direction.
fn orders(report: &Report) -> Vec<Option<f64>> {
    report.directions.iter().map(|row| row.taylor).collect()
}

fn is_order(report: &Report, order: f64) {
    for taylor in orders(report) {
        let taylor = taylor.expect("steps above the rounding");
        assert!((taylor - order).abs() < ORDER, "not {order}\n{report}");
    }
}

/// Along a direction of small curvature the term of third order shows, so the measured order may exceed 2.
#[test]
fn remainders_are_of_second_order_where_the_gradient_is_right() {
    for n in [2, 7, 50] {
        let reports = seeds(20).map(|options| check_gradient(&Smooth, &point(n), &options));
        let orders: Vec<f64> = reports.flat_map(|r| orders(&r)).flatten().collect();
        assert_eq!(orders.len(), 80);
        let bent = |order: &&f64| (*order - 2.0).abs() < ORDER;
        assert!(orders.iter().filter(bent).count() >= 76, "{orders:?}");
        let right = |order: &f64| (2.0 - ORDER..3.0 + ORDER).contains(order);
        assert!(orders.iter().all(right), "{orders:?}");
    }
}

/// The errors of these gradients range from half of the slope to a hundred times the tolerance.
#[test]
fn remainders_are_of_first_order_where_the_gradient_is_wrong() {
    let x = point(3);
    let right = gradient(|x| Smooth.eval(x), &x);
    for wrong in [0.5, 1e-2, 1e-4] {
        let slopes: Vec<f64> = right.iter().map(|g| g * (1.0 + wrong)).collect();
        for options in seeds(20) {
            let mut report = claimed(|x| Smooth.eval(x), [&x, &slopes], &options);
            assert_eq!(report.verdict, Verdict::Wrong, "{report}");
            // A direction that is nearly at right angles to the error does not show the error.
            report.directions.retain(|row| row.error > 1e-5);
            is_order(&report, 1.0);
        }
    }
}

/// The measured order must be that of the leading term of the remainder.
#[test]
fn remainders_have_the_order_of_their_leading_term() {
    for power in [1.0, 1.5, 2.0, 3.0, 4.0] {
        for (options, scale) in seeds(20).zip([1e-280, 1e-9, 1.0, 1e300].into_iter().cycle()) {
            let value = |x: &[f64]| scale * (x[0] - 0.3).abs().powf(power);
            is_order(&claimed(value, [&[0.3], &[0.0]], &options), power);
        }
    }
}

/// The function has a kink beside the point, which only the larger steps cross. So the measured order must be that of
/// the smaller steps.
#[test]
fn the_smaller_steps_decide() {
    for distance in [1e-2, 1e-3, 1e-4, 1e-5] {
        for options in seeds(20) {
            let value = |x: &[f64]| x[0].exp() + (x[0] - distance).max(0.0);
            is_order(&claimed(value, [&[0.0], &[1.0]], &options), 2.0);
        }
    }
}

/// The order is 3 over the lower half decade of steps and 1 over the upper half decade. Neither is in the middle, so
/// the report must give the mean.
#[test]
fn of_two_orders_the_mean_counts() {
    let (largest_step, smallest_step) = (1e-2, 1e-3);
    let middle = f64::sqrt(largest_step * smallest_step);
    let value = |x: &[f64]| x[0].abs() * (x[0].abs() / middle).min(1.0).powi(2);
    for options in seeds(20) {
        let options = Options {
            largest_step,
            smallest_step,
            ..options
        };
        is_order(&claimed(value, [&[0.0], &[0.0]], &options), 2.0);
    }
}

#[test]
fn where_all_is_rounding_there_is_no_order() {
    let weights = [0.3, -0.7, 0.2];
    let linear = |x: &[f64]| x.iter().zip(weights).map(|(x, w)| x * w).sum::<f64>();
    for options in seeds(20) {
        for (value, slopes) in [
            (&linear as Value, weights),
            (&|_: &[f64]| 1.0, [0.0; 3]),
            (&|_: &[f64]| 0.0, [0.0; 3]),
            (&linear, [f64::NAN; 3]),
            (&linear, [f64::INFINITY; 3]),
        ] {
            let report = claimed(value, [&point(3), &slopes], &options);
            assert_eq!(orders(&report), [None; 4], "{report}");
        }
        // The options state a noise of 1e-3, which is more than the values bend.
        let noise = 1e-3;
        let report = claimed(
            |x| x[0].exp(),
            [&[0.0], &[1.0]],
            &Options { noise, ..options },
        );
        assert_eq!(orders(&report), [None; 4], "{report}");
    }
}

/// Noise must not be taken for a remainder. In one case it is single precision, which the options state. In the other
/// it is a little noise that the options do not state.
#[test]
fn noise_is_no_remainder() {
    let x = point(3);
    let right = gradient(|x| Smooth.eval(x), &x);
    let single =
        |x: &[f64]| f64::from(Smooth.eval(&x.iter().map(|&x| x as f32).collect::<Vec<_>>()));
    // This adds noise of 1e-11.
    let unsaid = |x: &[f64]| Smooth.eval(x) + 1e-11 * (1e15 * x[0]).sin();
    let cases: [(Value, f32); 2] = [(&single, f32::EPSILON), (&unsaid, 0.0)];
    for (value, noise) in cases {
        for options in seeds(20) {
            let noise = f64::from(noise).max(options.noise);
            let report = claimed(value, [&x, &right], &Options { noise, ..options });
            let orders: Vec<f64> = orders(&report).into_iter().flatten().collect();
            // Only the larger steps are clear of the noise, and there terms of higher order show.
            let right = |order: &f64| (1.7..3.3).contains(order);
            assert!(orders.iter().all(right), "{noise:e}\n{report}");
            assert!(orders.len() == 4 || noise > 1e-9, "{report}");
        }
    }
}

#[test]
fn the_worst_component_has_a_name() {
    let x = point(3);
    let mut wrong = gradient(|x| Smooth.eval(x), &x);
    wrong[1] *= 1.01;
    let mut options = Options::default();
    let report = claimed(|x| Smooth.eval(x), [&x, &wrong], &options);
    assert_eq!((report.worst.index, &report.worst.name), (1, &None));
    assert!(report.worst.to_string().starts_with("1: "), "{report}");
    options.names = ["mass", "drag", "lift"].map(String::from).to_vec();
    let report = claimed(|x| Smooth.eval(x), [&x, &wrong], &options);
    assert_eq!(report.worst.index, 1);
    assert_eq!(report.worst.name.as_deref(), Some("drag"));
    assert!(report.worst.to_string().starts_with("drag: "), "{report}");
    let table = report.to_string();
    assert!(table.contains("worst component drag: "), "{table}");
}

#[test]
#[should_panic(expected = "3 names for 2 components")]
fn a_name_too_many_is_refused() {
    let options = Options {
        names: ["mass", "drag", "lift"].map(String::from).to_vec(),
        ..Options::default()
    };
    check_gradient(&Smooth, &point(2), &options);
}

#[test]
fn a_gradient_that_is_wrong_on_purpose_is_found_out() {
    for n in [2, 7, 50] {
        for options in seeds(20) {
            let report = check_gradient(&Smooth, &point(n), &options);
            assert_eq!(report.control, Some(Verdict::Wrong), "{report}");
            let table = report.to_string();
            let line =
                "negative control: a gradient that is wrong on purpose, by 1 %, is called wrong";
            assert!(table.contains(line), "{table}");
        }
    }
}

/// The negative control must be `None` where its verdict would prove nothing: if the gradient is zero or too small for
/// differences, if it is wrong already, if the differences do not settle, or if the tolerance exceeds one hundredth.
#[test]
fn a_control_that_would_tell_nothing_is_none() {
    let line = |x: &[f64]| x[0].exp() + x[0].abs();
    let coarse = |options: &Options| Options {
        tolerance: 0.02,
        ..options.clone()
    };
    for options in seeds(20) {
        let reports = [
            claimed(|_| 1.0, [&[0.3], &[0.0]], &options),
            claimed(|x| 1.0 + 1e-12 * x[0], [&[0.5], &[1e-12]], &options),
            claimed(|x| x[0] * x[0], [&[1e-12], &[2e-12]], &options),
            claimed(|x| x[0].exp(), [&[0.0], &[1.1]], &options),
            claimed(|x| x[0].exp(), [&[0.0], &[f64::NAN]], &options),
            claimed(line, [&[0.0], &[1.0]], &options),
            claimed(|x| x[0].exp(), [&[0.0], &[1.0]], &coarse(&options)),
        ];
        for report in reports {
            assert_eq!(report.control, None, "{report}");
        }
    }
}
