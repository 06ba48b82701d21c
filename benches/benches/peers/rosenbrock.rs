//! Measures the computation of the gradient of Rosenbrock's function, which is a sum over neighbouring arguments.

use crate::task::{Task, Way, kept};

/// The number of arguments.
const ARGUMENTS: usize = 100;

pub(crate) fn task() -> Task {
    let x = kept((0..ARGUMENTS).map(|i| 0.5 + 0.1 * (i as f64).sin()));
    Task {
        title: format!("Gradient of Rosenbrock's function in {ARGUMENTS} dimensions"),
        source: include_str!("rosenbrock.rs"),
        // The tolerance is for a few roundings: each argument has two terms, which are added in a different order.
        tolerance: 1e-14,
        ways: vec![
            Way::new("by hand", "", || hand::gradient(x)),
            Way::new("ours", "`gradient`", || ours::gradient(x)),
            Way::new("echidna", "bytecode tape, kept", echidna::gradient(x)),
        ],
    }
}

/// The gradient by hand: the two partials of a term have formulas.
mod hand {
    pub(super) fn gradient(x: &[f64]) -> Vec<f64> {
        let mut gradient = vec![0.0; x.len()];
        for i in 0..x.len() - 1 {
            let (valley, slope) = (x[i + 1] - x[i] * x[i], 1.0 - x[i]);
            gradient[i] -= 400.0 * valley * x[i] + 2.0 * slope;
            gradient[i + 1] += 200.0 * valley;
        }
        gradient
    }
}

/// The function as a closure, as in the first example of `autodiff`.
mod ours {
    use autodiff::Var;

    pub(super) fn gradient(x: &[f64]) -> Vec<f64> {
        let term = |x: &[Var<f64>]| {
            let (valley, slope) = (x[1] - x[0] * x[0], 1.0 - x[0]);
            100.0 * valley * valley + slope * slope
        };
        autodiff::gradient(|x| x.windows(2).map(term).sum(), x)
    }
}

/// The function on a tape of echidna that is kept, as in its documentation under "record once, evaluate many".
mod echidna {
    use echidna::BReverse;

    pub(super) fn gradient(x: &[f64]) -> impl FnMut() -> Vec<f64> {
        let term = |x: &[BReverse<f64>]| {
            let (valley, slope) = (x[1] - x[0] * x[0], 1.0 - x[0]);
            100.0 * valley * valley + slope * slope
        };
        let (mut tape, _) = echidna::record(
            |x| {
                x.windows(2)
                    .map(term)
                    .fold(BReverse::constant(0.0), |a, b| a + b)
            },
            x,
        );
        move || tape.gradient(x)
    }
}
