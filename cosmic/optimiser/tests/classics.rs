//! The drivers find the known optima of the test problems, with about as many evaluations as NLopt.

use autodiff::{Real, jacobian, lit};
use cosmic_optimiser::{Problem, Status};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::problems::{CASES, Case, DRIVERS, Effort, NLOPT, run};

/// Asserts that a driver converges to the optimum of a problem, and returns its effort.
fn converges(case: &Case, (name, driver): (&str, super::problems::Driver)) -> Effort {
    let (end, effort) = run(case, driver);
    assert_eq!(
        end.status,
        Status::Converged,
        "{name}, {}: {end:?}",
        case.name
    );
    // The largest errors are 3e-6. The KKT residual 1e-6 and the violation 1e-6 change the objective by about the same
    // share, times multipliers of up to 10.
    let off = case.excess(end.objective).abs();
    assert!(
        off <= 1e-5 && effort.violation <= 1e-6,
        "{name}, {}: {effort:?} {end:?}",
        case.name
    );
    effort
}

/// The sums of the evaluations to the optimum over all problems that both solve: ours and NLopt's.
fn evaluations(rival: &str, ours: impl Iterator<Item = (&'static str, Effort)>) -> [usize; 2] {
    let rows: Vec<_> = NLOPT.lines().filter_map(Effort::parse).collect();
    let both = ours.filter_map(|(name, effort)| {
        let row = rows
            .iter()
            .find(|row| (row.0, row.1) == (name, rival))
            .expect("a row of nlopt.txt");
        (effort.near > 0 && row.2.near > 0).then_some([effort.near, row.2.near])
    });
    both.fold([0; 2], |sum, near| [sum[0] + near[0], sum[1] + near[1]])
}

#[test]
fn conservative_mma_finds_the_optima() {
    // Rosenbrock's valley, `hs1`, takes any MMA thousands of iterations.
    let cases = || {
        CASES
            .iter()
            .filter(|case| case.equalities == 0 && case.name != "hs1")
    };
    let efforts = cases().map(|case| (case.name, converges(case, DRIVERS[0])));
    let [ours, nlopt] = evaluations("MMA", efforts);
    // Ours are 0.9 of NLopt's.
    assert!(
        ours <= nlopt + nlopt / 5,
        "{ours} evaluations, {nlopt} in NLopt"
    );
}

#[test]
fn the_augmented_lagrangian_finds_the_optima() {
    let efforts = CASES
        .iter()
        .map(|case| (case.name, converges(case, DRIVERS[2])));
    let equalities: Vec<_> = efforts.collect();
    let constrained = CASES
        .iter()
        .zip(equalities)
        .filter(|(case, _)| case.equalities > 0);
    let [ours, nlopt] = evaluations("AUGLAG", constrained.map(|(_, effort)| effort));
    assert!(ours <= nlopt, "{ours} evaluations, {nlopt} in NLopt");
}

/// The evaluations of each driver over all problems that it can solve, when this line was written.
const EVALUATIONS: [usize; 3] = [2476, 5281, 5295];

/// The tests above allow many more evaluations, so they do not see a small loss.
#[test]
fn no_driver_needs_more_evaluations_than_before() {
    let evaluations = DRIVERS.map(|(name, driver)| {
        let cases = CASES
            .iter()
            .filter(|case| name == "augmented" || case.equalities == 0);
        cases.map(|case| run(case, driver).1.all).sum::<usize>()
    });
    // Another system's `exp` and `ln` may end a search a little earlier or later.
    let near = |(now, before): (&usize, &usize)| now.abs_diff(*before) * 50 <= *before;
    assert!(
        evaluations.iter().zip(&EVALUATIONS).all(near),
        "{evaluations:?} evaluations, {EVALUATIONS:?} before; if fewer, lower these numbers"
    );
}

/// A random convex problem that is hard to solve: rows of the constraints may be equal, opposite or zero, no point may
/// satisfy them all, and variables may be fixed.
struct Random {
    bounds: [Vec<f64>; 2],
    start: Vec<f64>,
    target: Vec<f64>,
    rows: Vec<(Vec<f64>, f64)>,
    curved: f64,
}

impl Random {
    fn new(seed: u64) -> Self {
        let random = &mut ChaCha8Rng::seed_from_u64(seed);
        let size = random.random_range(1..=5);
        let lower: Vec<f64> = (0..size).map(|_| random.random_range(-3.0..1.0)).collect();
        let widths = [0.0, 1.0, 4.0];
        let upper: Vec<f64> = lower
            .iter()
            .map(|low| low + widths[random.random_range(0..3)])
            .collect();
        let start = (0..size)
            .map(|j| lower[j] + random.random::<f64>() * (upper[j] - lower[j]))
            .collect();
        let mut rows: Vec<(Vec<f64>, f64)> = Vec::new();
        for i in 0..random.random_range(0..=4) {
            let row: Vec<f64> = (0..size).map(|_| random.random_range(-1.0..1.0)).collect();
            let right = random.random_range(-1.0..2.0);
            rows.push(match (i, random.random_range(0..6)) {
                (1.., 0) => rows[i - 1].clone(),
                (1.., 1) => {
                    let (row, right) = &rows[i - 1];
                    (
                        row.iter().map(|a| -a).collect(),
                        right + random.random_range(-0.5..0.5),
                    )
                }
                (_, 2) => (vec![0.0; size], right),
                _ => (row, right),
            });
        }
        Random {
            target: (0..size).map(|_| random.random_range(-4.0..4.0)).collect(),
            curved: [0.0, 0.5][random.random_range(0..2)],
            bounds: [lower, upper],
            start,
            rows,
        }
    }

    fn values<R: Real>(&self, x: &[R]) -> Vec<R> {
        let sum = |term: &dyn Fn(usize) -> R| (0..x.len()).fold(R::zero(), |sum, j| sum + term(j));
        let objective = sum(&|j| (x[j] - lit(self.target[j])).powi(2) * lit(1.0 + j as f64));
        let constraint = |(row, right): &(Vec<f64>, f64)| {
            sum(&|j| lit(row[j]) * x[j] + lit(self.curved * row[j].abs()) * x[j] * x[j])
                - lit(*right)
        };
        std::iter::once(objective)
            .chain(self.rows.iter().map(constraint))
            .collect()
    }
}

/// On random convex problems, both methods find the same optimum, or both find that there is none.
#[test]
fn methods_agree_on_degenerate_problems() {
    let (mut converged, mut infeasible) = (0, 0);
    for seed in 0..400 {
        let random = Random::new(seed);
        let [conservative, _, augmented] = DRIVERS.map(|(_, driver)| {
            let gradients = |x: &[f64]| jacobian(|x| random.values(x), x).into_vec();
            let [lower, upper] = &random.bounds;
            let mut problem = Problem::new(lower, upper, |x| random.values(x), gradients);
            driver(&mut problem, &random.start).unwrap()
        });
        let statuses = (&conservative.status, &augmented.status);
        match statuses {
            (Status::Converged, Status::Converged) => {
                let off = (conservative.objective - augmented.objective).abs();
                // The largest difference is 1.4e-6; a violation of 1e-6 times a multiplier of 10 would be 1e-5.
                assert!(
                    off <= 1e-5 * conservative.objective.abs().max(1.0),
                    "seed {seed}: {off:e}"
                );
                converged += 1;
            }
            (Status::Infeasible, Status::Infeasible) => infeasible += 1,
            _ => panic!("seed {seed}: {statuses:?}"),
        }
    }
    assert!(
        converged > 100 && infeasible > 30,
        "{converged} and {infeasible}"
    );
}
