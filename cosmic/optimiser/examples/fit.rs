//! A fit with constraints: a drug's concentration decays as the sum of a fast and a slow exponential. At the start the
//! two parts add up to the known dose, and the fast rate is at least six times the slow one. The gradients come from
//! `autodiff`.

use autodiff::{Real, jacobian, lit};
use cosmic_optimiser::{OptimiserError, Problem, Status, Stop, augmented};

/// Measured concentrations at the times 0.5, 1, ... 5.
const MEASURED: [f64; 10] = [
    0.612, 0.425, 0.329, 0.258, 0.214, 0.182, 0.151, 0.127, 0.108, 0.094,
];
const DOSE: f64 = 1.0;

/// The sum of squared errors, then the equality, then the inequality. The parameters are both amounts and both rates.
fn fit<R: Real>(p: &[R]) -> Vec<R> {
    let (fast, slow) = (p[2], p[3]);
    let model = |time: f64| p[0] * (lit(-time) * fast).exp() + p[1] * (lit(-time) * slow).exp();
    let error =
        |(k, &measured): (usize, &f64)| (model(0.5 * (k + 1) as f64) - lit(measured)).powi(2);
    let squares: R = MEASURED.iter().enumerate().map(error).sum();
    vec![squares, p[0] + p[1] - lit(DOSE), lit(6.0) * slow - fast]
}

fn main() -> Result<(), OptimiserError> {
    let (lower, upper) = ([0.0; 4], [2.0, 2.0, f64::INFINITY, f64::INFINITY]);
    let mut problem =
        Problem::new(&lower, &upper, fit, |p| jacobian(fit, p).into_vec()).with_equalities(1);
    let solution = augmented::minimise(&mut problem, &[0.5, 0.5, 1.0, 0.5], &Stop::default())?;
    let [a, b, fast, slow] = solution.point[..] else {
        unreachable!("four parameters")
    };
    println!(
        "{a:.3} exp(-{fast:.3} t) + {b:.3} exp(-{slow:.3} t), squared errors {:.2e}",
        solution.objective
    );
    assert_eq!(solution.status, Status::Converged);
    assert!((a + b - DOSE).abs() < 1e-6 && fast >= 6.0 * slow - 1e-6);
    // Ten squares of errors of 4e-3 are 1.6e-4.
    assert!(solution.objective < 1.7e-4);
    Ok(())
}
