//! Test problems with known optima: Svanberg's, and problems of W. Hock and K. Schittkowski, "Test examples for
//! nonlinear programming codes", Lecture Notes in Economics and Mathematical Systems 187, 1981. Where a variable has no
//! bounds in the collection, `mma` gets the bounds that stand here, which are inactive at the optimum.

use std::fmt;

use autodiff::{Real, jacobian, lit};
use cosmic_optimiser::mma::{self, Options, Variant};
use cosmic_optimiser::{OptimiserError, Problem, Solution, Stop, augmented};

/// A problem with a known optimum.
#[derive(Clone, Copy)]
pub(crate) struct Case {
    pub(crate) name: &'static str,
    /// The number of equalities, which come before the inequalities.
    pub(crate) equalities: usize,
    /// The bounds of each variable.
    pub(crate) bounds: &'static [[f64; 2]],
    pub(crate) start: &'static [f64],
    /// The objective at the optimum.
    pub(crate) optimum: f64,
    pub(crate) values: fn(&[f64]) -> Vec<f64>,
    pub(crate) gradients: fn(&[f64]) -> Vec<f64>,
}

impl Case {
    /// The lower and the upper bounds.
    pub(crate) fn bounds(&self) -> [Vec<f64>; 2] {
        [0, 1].map(|side| self.bounds.iter().map(|bound| bound[side]).collect())
    }

    /// The objective minus the optimum, relative to the optimum if that is above 1.
    pub(crate) fn excess(&self, objective: f64) -> f64 {
        (objective - self.optimum) / self.optimum.abs().max(1.0)
    }

    /// The largest violation of a constraint.
    pub(crate) fn violation(&self, constraints: &[f64]) -> f64 {
        let violation = |(i, f): (usize, &f64)| match i < self.equalities {
            true => f.abs(),
            false => f.max(0.0),
        };
        constraints
            .iter()
            .enumerate()
            .map(violation)
            .fold(0.0, f64::max)
    }
}

/// Declares problems: name, number of equalities, bounds, start, optimum, and the functions for all number types.
macro_rules! problems {
    ($($name:ident, $equalities:literal, $bounds:expr, $start:expr, $optimum:expr, |$x:ident| $values:expr;)*) => {
        $(fn $name<R: Real>($x: &[R]) -> Vec<R> { $values })*

        /// All problems.
        pub(crate) const CASES: &[Case] = &[$(Case {
            name: stringify!($name),
            equalities: $equalities,
            bounds: &$bounds,
            start: &$start,
            optimum: $optimum,
            values: $name::<f64>,
            gradients: |x| jacobian($name, x).into_vec(),
        }),*];
    };
}

fn sum<R: Real>(terms: impl Iterator<Item = R>) -> R {
    terms.fold(R::zero(), |sum, term| sum + term)
}

/// The first two equalities of the problems 78, 80 and 81, and their third one.
fn sphere_and_products<R: Real>(x: &[R]) -> [R; 3] {
    [
        sum(x.iter().map(|x| *x * *x)) - lit(10.0),
        x[1] * x[2] - lit(5.0) * x[3] * x[4],
        x[0].powi(3) + x[1].powi(3) + lit(1.0),
    ]
}

/// A driver of this crate with its default options.
pub(crate) type Driver = fn(&mut Problem<'_>, &[f64]) -> Result<Solution, OptimiserError>;

/// The drivers, by the names that the table of the README gives them.
pub(crate) const DRIVERS: [(&str, Driver); 3] = [
    ("GCMMA", |problem, start| {
        mma::minimise(problem, start, &Options::default())
    }),
    ("plain MMA", |problem, start| {
        let variant = Variant::Plain;
        mma::minimise(
            problem,
            start,
            &Options {
                variant,
                ..Options::default()
            },
        )
    }),
    ("augmented", |problem, start| {
        augmented::minimise(problem, start, &Stop::default())
    }),
];

/// The results of NLopt, by `examples/comparison.py`.
pub(crate) const NLOPT: &str = include_str!("data/nlopt.txt");

/// What a run cost, and how far from the optimum it ended.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Effort {
    /// The number of evaluations until a point was within 1e-6 of the optimum; 0 if none was.
    pub(crate) near: usize,
    /// The number of evaluations in all.
    pub(crate) all: usize,
    pub(crate) excess: f64,
    pub(crate) violation: f64,
}

impl Effort {
    /// Reads a line of `data/nlopt.txt`: the problem, the algorithm, and its effort.
    pub(crate) fn parse(line: &str) -> Option<(&str, &str, Self)> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let effort = Effort {
            near: words[2].parse().ok()?,
            all: words[3].parse().ok()?,
            excess: words[4].parse().ok()?,
            violation: words[5].parse().ok()?,
        };
        Some((words[0], words[1], effort))
    }
}

/// A cell of the table in the README.
impl fmt::Display for Effort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.near {
            0 => write!(f, "no: {:.0e}, {:.0e}", self.excess, self.violation),
            near => write!(f, "{near} of {}", self.all),
        }
    }
}

/// Runs a driver on a problem from its start.
pub(crate) fn run(case: &Case, driver: Driver) -> (Solution, Effort) {
    let (mut near, mut all) = (0, 0);
    let values = |x: &[f64]| {
        let values = (case.values)(x);
        all += 1;
        let off = case
            .excess(values[0])
            .abs()
            .max(case.violation(&values[1..]));
        if near == 0 && off <= 1e-6 {
            near = all;
        }
        values
    };
    let [lower, upper] = case.bounds();
    let mut problem =
        Problem::new(&lower, &upper, values, case.gradients).with_equalities(case.equalities);
    let solution = driver(&mut problem, case.start).expect("a well-posed problem");
    drop(problem);
    let effort = Effort {
        near,
        all,
        excess: case.excess(solution.objective),
        violation: solution.violation,
    };
    (solution, effort)
}

const INF: f64 = f64::INFINITY;
const FREE: [f64; 2] = [-INF, INF];

problems! {
    // Svanberg 1987: a cantilever beam of five hollow segments, and a truss of two bars.
    beam, 0, [[1.0, 10.0]; 5], [5.0; 5], 1.339_956_36, |x| {
        let cubes = [61.0, 37.0, 19.0, 7.0, 1.0];
        let sinks = sum((0..5).map(|j| lit(cubes[j]) / x[j].powi(3)));
        vec![lit(0.0624) * sum(x.iter().copied()), sinks - lit(1.0)]
    };
    two_bars, 0, [[0.2, 4.0], [0.1, 1.6]], [1.5, 0.5], 1.508_652_4, |x| {
        let length = (x[1] * x[1] + lit(1.0)).sqrt();
        let [sum, difference] = [1.0, -1.0].map(|sign| lit(8.0) / x[0] + lit(sign) / (x[0] * x[1]));
        let stress = |bar: R| lit(0.124) * length * bar - lit(1.0);
        vec![x[0] * length, stress(sum), stress(difference)]
    };
    // Svanberg's example in three variables: the point of two balls that is nearest to the origin.
    balls, 0, [[0.0, 5.0]; 3], [4.0, 3.0, 2.0], 8.770_246_5, |x| {
        let ball = |c: [f64; 3]| sum((0..3).map(|j| (x[j] - lit(c[j])).powi(2))) - lit(9.0);
        vec![sum(x.iter().map(|x| *x * *x)), ball([5.0, 2.0, 1.0]), ball([3.0, 4.0, 3.0])]
    };
    // Plain MMA cycles here.
    bowl, 0, [[-2.0, 2.0]; 2], [1.0; 2], 0.0, |x| vec![x[0] * x[0] + x[1] * x[1]];
    hs1, 0, [[-2.0, 2.0], [-1.5, 2.0]], [-2.0, 1.0], 0.0, |x| {
        vec![lit(100.0) * (x[1] - x[0] * x[0]).powi(2) + (lit(1.0) - x[0]).powi(2)]
    };
    hs21, 0, [[2.0, 50.0], [-50.0, 50.0]], [2.0, -1.0], -99.96, |x| vec![
        lit(0.01) * x[0] * x[0] + x[1] * x[1] - lit(100.0),
        lit(10.0) - lit(10.0) * x[0] + x[1],
    ];
    hs24, 0, [[0.0, 5.0]; 2], [1.0, 0.5], -1.0, |x| {
        let root = 3.0_f64.sqrt();
        let scale = lit(1.0 / (27.0 * root));
        vec![
            ((x[0] - lit(3.0)).powi(2) - lit(9.0)) * x[1].powi(3) * scale,
            x[1] - x[0] / lit(root),
            -x[0] - lit(root) * x[1],
            x[0] + lit(root) * x[1] - lit(6.0),
        ]
    };
    hs29, 0, [[-10.0, 10.0]; 3], [1.0; 3], -22.627_417, |x| vec![
        -x[0] * x[1] * x[2],
        x[0] * x[0] + lit(2.0) * x[1] * x[1] + lit(4.0) * x[2] * x[2] - lit(48.0),
    ];
    hs30, 0, [[1.0, 10.0], [-10.0, 10.0], [-10.0, 10.0]], [1.0; 3], 1.0, |x| vec![
        sum(x.iter().map(|x| *x * *x)),
        lit(1.0) - x[0] * x[0] - x[1] * x[1],
    ];
    hs31, 0, [[-10.0, 10.0], [1.0, 10.0], [-10.0, 1.0]], [1.0; 3], 6.0, |x| vec![
        lit(9.0) * x[0] * x[0] + x[1] * x[1] + lit(9.0) * x[2] * x[2],
        lit(1.0) - x[0] * x[1],
    ];
    hs34, 0, [[0.0, 100.0], [0.0, 100.0], [0.0, 10.0]], [0.0, 1.05, 2.9], -0.834_032_445, |x| vec![
        -x[0],
        x[0].exp() - x[1],
        x[1].exp() - x[2],
    ];
    hs35, 0, [[0.0, 3.0]; 3], [0.5; 3], 1.0 / 9.0, |x| vec![
        lit(9.0) - lit(8.0) * x[0] - lit(6.0) * x[1] - lit(4.0) * x[2] + lit(2.0) * x[0] * x[0]
            + lit(2.0) * x[1] * x[1] + x[2] * x[2] + lit(2.0) * x[0] * x[1] + lit(2.0) * x[0] * x[2],
        x[0] + x[1] + lit(2.0) * x[2] - lit(3.0),
    ];
    hs36, 0, [[0.0, 20.0], [0.0, 11.0], [0.0, 42.0]], [10.0; 3], -3300.0, |x| vec![
        -x[0] * x[1] * x[2],
        x[0] + lit(2.0) * x[1] + lit(2.0) * x[2] - lit(72.0),
    ];
    hs37, 0, [[0.0, 42.0]; 3], [10.0; 3], -3456.0, |x| {
        let sum = x[0] + lit(2.0) * x[1] + lit(2.0) * x[2];
        vec![-x[0] * x[1] * x[2], sum - lit(72.0), -sum]
    };
    hs43, 0, [[-10.0, 10.0]; 4], [0.0; 4], -44.0, |x| {
        let s: Vec<R> = x.iter().map(|x| *x * *x).collect();
        vec![
            s[0] + s[1] + lit(2.0) * s[2] + s[3] - lit(5.0) * (x[0] + x[1]) - lit(21.0) * x[2] + lit(7.0) * x[3],
            s[0] + s[1] + s[2] + s[3] + x[0] - x[1] + x[2] - x[3] - lit(8.0),
            s[0] + lit(2.0) * s[1] + s[2] + lit(2.0) * s[3] - x[0] - x[3] - lit(10.0),
            lit(2.0) * s[0] + s[1] + s[2] + lit(2.0) * x[0] - x[1] - x[3] - lit(5.0),
        ]
    };
    hs64, 0, [[1.0, 1000.0]; 3], [1.0; 3], 6_299.842_43, |x| vec![
        lit(5.0) * x[0] + lit(5e4) / x[0] + lit(20.0) * x[1] + lit(7.2e4) / x[1] + lit(10.0) * x[2]
            + lit(1.44e5) / x[2],
        lit(4.0) / x[0] + lit(32.0) / x[1] + lit(120.0) / x[2] - lit(1.0),
    ];
    hs66, 0, [[0.0, 100.0], [0.0, 100.0], [0.0, 10.0]], [0.0, 1.05, 2.9], 0.518_163_274, |x| vec![
        lit(0.2) * x[2] - lit(0.8) * x[0],
        x[0].exp() - x[1],
        x[1].exp() - x[2],
    ];
    hs76, 0, [[0.0, 10.0]; 4], [0.5; 4], -4.681_818_182, |x| vec![
        x[0] * x[0] + lit(0.5) * x[1] * x[1] + x[2] * x[2] + lit(0.5) * x[3] * x[3] - x[0] * x[2] + x[2] * x[3]
            - x[0] - lit(3.0) * x[1] + x[2] - x[3],
        x[0] + lit(2.0) * x[1] + x[2] + x[3] - lit(5.0),
        lit(3.0) * x[0] + x[1] + lit(2.0) * x[2] - x[3] - lit(4.0),
        lit(1.5) - x[1] - lit(4.0) * x[2],
    ];
    hs93, 0, [[0.0, 20.0]; 6], [5.54, 4.4, 12.02, 11.82, 0.702, 0.852], 135.075_961, |x| {
        let first = x[0] * x[3] * (x[0] + x[1] + x[2]);
        let second = x[1] * x[2] * (x[0] + lit(1.57) * x[1] + x[3]);
        let (fifth, sixth) = (x[4] * x[4], x[5] * x[5]);
        let product = lit(1e-3) * x[0] * x[1] * x[2] * x[3] * x[4] * x[5];
        vec![
            lit(0.0204) * first + lit(0.0187) * second + lit(0.0607) * first * fifth + lit(0.0437) * second * sixth,
            lit(2.07) - product,
            lit(6.2e-4) * first * fifth + lit(5.8e-4) * second * sixth - lit(1.0),
        ]
    };
    hs100, 0, [[-10.0, 10.0]; 7], [1.0, 2.0, 0.0, 4.0, 0.0, 1.0, 1.0], 680.630_057, |x| vec![
        (x[0] - lit(10.0)).powi(2) + lit(5.0) * (x[1] - lit(12.0)).powi(2) + x[2].powi(4)
            + lit(3.0) * (x[3] - lit(11.0)).powi(2) + lit(10.0) * x[4].powi(6) + lit(7.0) * x[5] * x[5]
            + x[6].powi(4) - lit(4.0) * x[5] * x[6] - lit(10.0) * x[5] - lit(8.0) * x[6],
        lit(2.0) * x[0] * x[0] + lit(3.0) * x[1].powi(4) + x[2] + lit(4.0) * x[3] * x[3] + lit(5.0) * x[4]
            - lit(127.0),
        lit(7.0) * x[0] + lit(3.0) * x[1] + lit(10.0) * x[2] * x[2] + x[3] - x[4] - lit(282.0),
        lit(23.0) * x[0] + x[1] * x[1] + lit(6.0) * x[5] * x[5] - lit(8.0) * x[6] - lit(196.0),
        lit(4.0) * x[0] * x[0] + x[1] * x[1] - lit(3.0) * x[0] * x[1] + lit(2.0) * x[2] * x[2] + lit(5.0) * x[5]
            - lit(11.0) * x[6],
    ];
    hs113, 0, [[-20.0, 20.0]; 10], [2.0, 3.0, 5.0, 5.0, 1.0, 2.0, 7.0, 3.0, 6.0, 10.0], 24.306_209_1, |x| {
        let square = |j: usize, target: f64| (x[j] - lit(target)).powi(2);
        vec![
            x[0] * x[0] + x[1] * x[1] + x[0] * x[1] - lit(14.0) * x[0] - lit(16.0) * x[1] + square(2, 10.0)
                + lit(4.0) * square(3, 5.0) + square(4, 3.0) + lit(2.0) * square(5, 1.0) + lit(5.0) * x[6] * x[6]
                + lit(7.0) * square(7, 11.0) + lit(2.0) * square(8, 10.0) + square(9, 7.0) + lit(45.0),
            lit(4.0) * x[0] + lit(5.0) * x[1] - lit(3.0) * x[6] + lit(9.0) * x[7] - lit(105.0),
            lit(10.0) * x[0] - lit(8.0) * x[1] - lit(17.0) * x[6] + lit(2.0) * x[7],
            lit(2.0) * x[1] - lit(8.0) * x[0] + lit(5.0) * x[8] - lit(2.0) * x[9] - lit(12.0),
            lit(3.0) * square(0, 2.0) + lit(4.0) * square(1, 3.0) + lit(2.0) * x[2] * x[2] - lit(7.0) * x[3]
                - lit(120.0),
            lit(5.0) * x[0] * x[0] + lit(8.0) * x[1] + square(2, 6.0) - lit(2.0) * x[3] - lit(40.0),
            lit(0.5) * square(0, 8.0) + lit(2.0) * square(1, 4.0) + lit(3.0) * x[4] * x[4] - x[5] - lit(30.0),
            x[0] * x[0] + lit(2.0) * square(1, 2.0) - lit(2.0) * x[0] * x[1] + lit(14.0) * x[4] - lit(6.0) * x[5],
            lit(6.0) * x[1] - lit(3.0) * x[0] + lit(12.0) * square(8, 8.0) - lit(7.0) * x[9],
        ]
    };
    hs6, 1, [FREE; 2], [-1.2, 1.0], 0.0, |x| {
        vec![(lit(1.0) - x[0]).powi(2), lit(10.0) * (x[1] - x[0] * x[0])]
    };
    hs7, 1, [FREE; 2], [2.0; 2], -1.732_050_81, |x| {
        let square = x[0] * x[0] + lit(1.0);
        vec![square.ln() - x[1], square * square + x[1] * x[1] - lit(4.0)]
    };
    hs14, 1, [FREE; 2], [2.0; 2], 1.393_464_98, |x| vec![
        (x[0] - lit(2.0)).powi(2) + (x[1] - lit(1.0)).powi(2),
        x[0] - lit(2.0) * x[1] + lit(1.0),
        lit(0.25) * x[0] * x[0] + x[1] * x[1] - lit(1.0),
    ];
    hs26, 1, [FREE; 3], [-2.6, 2.0, 2.0], 0.0, |x| vec![
        (x[0] - x[1]).powi(2) + (x[1] - x[2]).powi(4),
        (x[1] * x[1] + lit(1.0)) * x[0] + x[2].powi(4) - lit(3.0),
    ];
    hs27, 1, [FREE; 3], [2.0; 3], 0.04, |x| vec![
        lit(0.01) * (x[0] - lit(1.0)).powi(2) + (x[1] - x[0] * x[0]).powi(2),
        x[0] + x[2] * x[2] + lit(1.0),
    ];
    hs28, 1, [FREE; 3], [-4.0, 1.0, 1.0], 0.0, |x| vec![
        (x[0] + x[1]).powi(2) + (x[1] + x[2]).powi(2),
        x[0] + lit(2.0) * x[1] + lit(3.0) * x[2] - lit(1.0),
    ];
    hs39, 2, [FREE; 4], [2.0; 4], -1.0, |x| vec![
        -x[0],
        x[1] - x[0].powi(3) - x[2] * x[2],
        x[0] * x[0] - x[1] - x[3] * x[3],
    ];
    hs40, 3, [FREE; 4], [0.8; 4], -0.25, |x| vec![
        -x[0] * x[1] * x[2] * x[3],
        x[0].powi(3) + x[1] * x[1] - lit(1.0),
        x[0] * x[0] * x[3] - x[2],
        x[3] * x[3] - x[1],
    ];
    hs48, 2, [FREE; 5], [3.0, 5.0, -3.0, 2.0, -2.0], 0.0, |x| vec![
        (x[0] - lit(1.0)).powi(2) + (x[1] - x[2]).powi(2) + (x[3] - x[4]).powi(2),
        sum(x.iter().copied()) - lit(5.0),
        x[2] - lit(2.0) * (x[3] + x[4]) + lit(3.0),
    ];
    hs51, 3, [FREE; 5], [2.5, 0.5, 2.0, -1.0, 0.5], 0.0, |x| vec![
        (x[0] - x[1]).powi(2) + (x[1] + x[2] - lit(2.0)).powi(2) + (x[3] - lit(1.0)).powi(2)
            + (x[4] - lit(1.0)).powi(2),
        x[0] + lit(3.0) * x[1] - lit(4.0),
        x[2] + x[3] - lit(2.0) * x[4],
        x[1] - x[4],
    ];
    hs52, 3, [FREE; 5], [2.0; 5], 1859.0 / 349.0, |x| vec![
        (lit(4.0) * x[0] - x[1]).powi(2) + (x[1] + x[2] - lit(2.0)).powi(2) + (x[3] - lit(1.0)).powi(2)
            + (x[4] - lit(1.0)).powi(2),
        x[0] + lit(3.0) * x[1],
        x[2] + x[3] - lit(2.0) * x[4],
        x[1] - x[4],
    ];
    hs60, 1, [[-10.0, 10.0]; 3], [2.0; 3], 0.032_568_200_3, |x| vec![
        (x[0] - lit(1.0)).powi(2) + (x[0] - x[1]).powi(2) + (x[1] - x[2]).powi(4),
        x[0] * (x[1] * x[1] + lit(1.0)) + x[2].powi(4) - lit(4.0 + 3.0 * 2.0_f64.sqrt()),
    ];
    hs61, 2, [FREE; 3], [0.0; 3], -143.646_142, |x| vec![
        lit(4.0) * x[0] * x[0] + lit(2.0) * (x[1] * x[1] + x[2] * x[2]) - lit(33.0) * x[0] + lit(16.0) * x[1]
            - lit(24.0) * x[2],
        lit(3.0) * x[0] - lit(2.0) * x[1] * x[1] - lit(7.0),
        lit(4.0) * x[0] - x[2] * x[2] - lit(11.0),
    ];
    hs63, 2, [[0.0, INF]; 3], [2.0; 3], 961.715_172, |x| vec![
        lit(1000.0) - x[0] * x[0] - lit(2.0) * x[1] * x[1] - x[2] * x[2] - x[0] * x[1] - x[0] * x[2],
        lit(8.0) * x[0] + lit(14.0) * x[1] + lit(7.0) * x[2] - lit(56.0),
        sum(x.iter().map(|x| *x * *x)) - lit(25.0),
    ];
    hs71, 1, [[1.0, 5.0]; 4], [1.0, 5.0, 5.0, 1.0], 17.014_017_3, |x| vec![
        x[0] * x[3] * (x[0] + x[1] + x[2]) + x[2],
        sum(x.iter().map(|x| *x * *x)) - lit(40.0),
        lit(25.0) - x[0] * x[1] * x[2] * x[3],
    ];
    hs73, 1, [[0.0, INF]; 4], [1.0; 4], 29.894_378_2, |x| {
        let weighted = |w: [f64; 4]| sum((0..4).map(|j| lit(w[j]) * x[j]));
        let squares = [0.28, 0.19, 20.5, 0.62];
        let deviation = sum((0..4).map(|j| lit(squares[j]) * x[j] * x[j])).sqrt();
        vec![
            weighted([24.55, 26.75, 39.0, 40.5]),
            sum(x.iter().copied()) - lit(1.0),
            lit(5.0) - weighted([2.3, 5.6, 11.1, 1.3]),
            lit(21.0) + lit(1.645) * deviation - weighted([12.0, 11.9, 41.8, 52.1]),
        ]
    };
    hs77, 2, [FREE; 5], [2.0; 5], 0.241_505_13, |x| vec![
        (x[0] - lit(1.0)).powi(2) + (x[0] - x[1]).powi(2) + (x[2] - lit(1.0)).powi(2) + (x[3] - lit(1.0)).powi(4)
            + (x[4] - lit(1.0)).powi(6),
        x[0] * x[0] * x[3] + (x[3] - x[4]).sin() - lit(8.0_f64.sqrt()),
        x[1] + x[2].powi(4) * x[3] * x[3] - lit(8.0 + 2.0_f64.sqrt()),
    ];
    hs78, 3, [FREE; 5], [-2.0, 1.5, 2.0, -1.0, -1.0], -2.919_700_41, |x| {
        let [sphere, products, cubes] = sphere_and_products(x);
        vec![x[0] * x[1] * x[2] * x[3] * x[4], sphere, products, cubes]
    };
    hs79, 3, [FREE; 5], [2.0; 5], 0.078_776_820_9, |x| vec![
        (x[0] - lit(1.0)).powi(2) + (x[0] - x[1]).powi(2) + (x[1] - x[2]).powi(2) + (x[2] - x[3]).powi(4)
            + (x[3] - x[4]).powi(4),
        x[0] + x[1] * x[1] + x[2].powi(3) - lit(2.0 + 3.0 * 2.0_f64.sqrt()),
        x[1] - x[2] * x[2] + x[3] + lit(2.0 - 2.0 * 2.0_f64.sqrt()),
        x[0] * x[4] - lit(2.0),
    ];
    hs80, 3, [[-2.3, 2.3], [-2.3, 2.3], [-3.2, 3.2], [-3.2, 3.2], [-3.2, 3.2]], [-2.0, 2.0, 2.0, -1.0, -1.0],
        0.053_949_847_8, |x| {
        let [sphere, products, cubes] = sphere_and_products(x);
        vec![(x[0] * x[1] * x[2] * x[3] * x[4]).exp(), sphere, products, cubes]
    };
    hs81, 3, [[-2.3, 2.3], [-2.3, 2.3], [-3.2, 3.2], [-3.2, 3.2], [-3.2, 3.2]], [-2.0, 2.0, 2.0, -1.0, -1.0],
        0.053_949_847_8, |x| {
        let [sphere, products, cubes] = sphere_and_products(x);
        let product = x[0] * x[1] * x[2] * x[3] * x[4];
        vec![product.exp() - lit(0.5) * cubes * cubes, sphere, products, cubes]
    };
}
