//! Problems of engineering design with published optima. Their variables and constraints have very different sizes.
#![expect(
    clippy::approx_constant,
    reason = "the published coefficients are not those constants"
)]

use autodiff::{Real, jacobian, lit};
use cosmic_optimiser::{Problem, Status};

use super::problems::DRIVERS;

fn reducer<R: Real>(x: &[R]) -> Vec<R> {
    let c = |v: f64| -> R { R::lit(v) };
    let (a, b, z, l1, l2, d1, d2) = (x[0], x[1], x[2], x[3], x[4], x[5], x[6]);
    vec![
        c(0.7854) * a * b * b * (c(3.3333) * z * z + c(14.9334) * z - c(43.0934))
            - c(1.508) * a * (d1 * d1 + d2 * d2)
            + c(7.4777) * (d1.powi(3) + d2.powi(3))
            + c(0.7854) * (l1 * d1 * d1 + l2 * d2 * d2),
        c(27.0) / (a * b * b * z) - c(1.0),
        c(397.5) / (a * b * b * z * z) - c(1.0),
        c(1.93) * l1.powi(3) / (b * z * d1.powi(4)) - c(1.0),
        c(1.93) * l2.powi(3) / (b * z * d2.powi(4)) - c(1.0),
        ((c(745.0) * l1 / (b * z)).powi(2) + c(16.9e6)).sqrt() / (c(110.0) * d1.powi(3)) - c(1.0),
        ((c(745.0) * l2 / (b * z)).powi(2) + c(157.5e6)).sqrt() / (c(85.0) * d2.powi(3)) - c(1.0),
        b * z / c(40.0) - c(1.0),
        c(5.0) * b / a - c(1.0),
        a / (c(12.0) * b) - c(1.0),
        (c(1.5) * d1 + c(1.9)) / l1 - c(1.0),
        (c(1.1) * d2 + c(1.9)) / l2 - c(1.0),
    ]
}
fn spring<R: Real>(x: &[R]) -> Vec<R> {
    let c = |v: f64| -> R { R::lit(v) };
    let (d, w, n) = (x[0], x[1], x[2]);
    vec![
        (n + c(2.0)) * w * d * d,
        c(1.0) - w.powi(3) * n / (c(71785.0) * d.powi(4)),
        (c(4.0) * w * w - d * w) / (c(12566.0) * (w * d.powi(3) - d.powi(4)))
            + c(1.0) / (c(5108.0) * d * d)
            - c(1.0),
        c(1.0) - c(140.45) * d / (w * w * n),
        (d + w) / c(1.5) - c(1.0),
    ]
}
fn hs106<R: Real>(x: &[R]) -> Vec<R> {
    let c = |v: f64| -> R { R::lit(v) };
    vec![
        x[0] + x[1] + x[2],
        c(-1.0) + c(0.0025) * (x[3] + x[5]),
        c(-1.0) + c(0.0025) * (x[4] + x[6] - x[3]),
        c(-1.0) + c(0.01) * (x[7] - x[4]),
        -x[0] * x[5] + c(833.33252) * x[3] + c(100.0) * x[0] - c(83333.333),
        -x[1] * x[6] + c(1250.0) * x[4] + x[1] * x[3] - c(1250.0) * x[3],
        -x[2] * x[7] + c(1250000.0) + x[2] * x[4] - c(2500.0) * x[4],
    ]
}
struct Case {
    name: &'static str,
    bounds: Vec<[f64; 2]>,
    start: Vec<f64>,
    /// The published minimum.
    best: f64,
    values: fn(&[f64]) -> Vec<f64>,
    gradients: fn(&[f64]) -> Vec<f64>,
}

macro_rules! case {
    ($function:ident, $bounds:expr, $start:expr, $best:expr) => {
        Case {
            name: stringify!($function),
            bounds: $bounds.to_vec(),
            start: $start.to_vec(),
            best: $best,
            values: $function::<f64>,
            gradients: |x| jacobian($function, x).into_vec(),
        }
    };
}

fn cases() -> Vec<Case> {
    let of_reducer = [
        [2.6, 3.6],
        [0.7, 0.8],
        [17.0, 28.0],
        [7.3, 8.3],
        [7.3, 8.3],
        [2.9, 3.9],
        [5.0, 5.5],
    ];
    let of_spring = [[0.05, 2.0], [0.25, 1.3], [2.0, 15.0]];
    let mut of_hs106 = [[10.0, 1e3]; 8];
    of_hs106[..3].copy_from_slice(&[[100.0, 1e4], [1e3, 1e4], [1e3, 1e4]]);
    vec![
        case!(
            reducer,
            of_reducer,
            [3.1, 0.75, 22.0, 7.8, 7.8, 3.4, 5.25],
            2994.4710661
        ),
        case!(spring, of_spring, [0.1, 0.6, 8.0], 0.012665232788),
        case!(spring, of_spring, [0.06, 0.4, 10.0], 0.012665232788),
        case!(
            hs106,
            of_hs106,
            [5e3, 5e3, 5e3, 200.0, 350.0, 150.0, 225.0, 425.0],
            7049.2480205
        ),
    ]
}

#[test]
fn every_driver_finds_the_published_optima() {
    for case in cases() {
        let side = |k: usize| {
            case.bounds
                .iter()
                .map(|bounds| bounds[k])
                .collect::<Vec<_>>()
        };
        for (driver, minimise) in DRIVERS {
            let mut problem = Problem::new(&side(0), &side(1), case.values, case.gradients);
            let end = minimise(&mut problem, &case.start).expect("a well-posed problem");
            let excess = end.objective / case.best - 1.0;
            let what = format!("{}, {driver}: excess {excess:.1e}, {end:?}", case.name);
            assert_eq!(end.status, Status::Converged, "{what}");
            // The tolerances of a run are 1e-6; multipliers and ranges of variables are up to ten times the objective.
            assert!(excess.abs() < 1e-5 && end.violation <= 1e-6, "{what}");
        }
    }
}

/// With gradients of the wrong sign, a run climbs to a corner and satisfies the optimality conditions there.
#[test]
fn a_run_that_climbs_has_not_converged() {
    fn bowl<R: Real>(x: &[R]) -> Vec<R> {
        vec![R::sum_of(&[0, 1].map(|j| (x[j] - lit(0.3)).powi(2)))]
    }
    let wrong = |x: &[f64]| {
        jacobian(bowl, x)
            .into_vec()
            .iter()
            .map(|g| -g)
            .collect::<Vec<f64>>()
    };
    for (driver, minimise) in DRIVERS {
        let mut problem = Problem::new(&[-1.0; 2], &[1.0; 2], bowl::<f64>, wrong);
        let end = minimise(&mut problem, &[0.9, 0.5]).expect("a well-posed problem");
        assert_ne!(end.status, Status::Converged, "{driver}: {end:?}");
        if driver == "plain MMA" {
            assert_eq!(end.status, Status::WorseThanStart, "{end:?}");
        }
        // A start at the optimum is not worse than itself.
        let right = |x: &[f64]| jacobian(bowl, x).into_vec();
        let mut problem = Problem::new(&[-1.0; 2], &[1.0; 2], bowl::<f64>, right);
        let end = minimise(&mut problem, &[0.3; 2]).expect("a well-posed problem");
        assert_eq!(end.status, Status::Converged, "{driver}: {end:?}");
    }
}
