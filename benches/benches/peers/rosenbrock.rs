//! Measures the computation of the gradient of Rosenbrock's function, which is a sum over neighbouring arguments.

use crate::task::{Task, Way, kept};

pub(crate) fn task(arguments: usize) -> Task {
    let x = kept((0..arguments).map(|i| 0.5 + 0.1 * (i as f64).sin()));
    let mut ways = vec![
        Way::new("by hand", "", &["hand"], || hand::gradient(x)),
        Way::new("ours", "`gradient`", &["ours"], || ours::gradient(x)),
        Way::new("echidna", "`grad`", &["echidna"], || echidna::gradient(x)),
        Way::new(
            "echidna",
            "bytecode tape, kept",
            &["echidna_kept"],
            echidna_kept::gradient(x),
        ),
        Way::new("reverse", "a tape", &["reverse"], || reverse::gradient(x)),
    ];
    if arguments <= 100 {
        let way = || num_dual::gradient(x);
        ways.push(Way::new("num-dual", "`gradient`", &["num_dual"], way));
    }
    Task {
        title: format!("Gradient of Rosenbrock's function in {arguments} dimensions"),
        about: "Scalar code on a tape, about eight operations per argument. A kept tape was recorded before the clock \
                started. num-dual has only forward mode, so it takes part only with few arguments.",
        source: include_str!("rosenbrock.rs"),
        // The tolerance is for a few roundings: each argument has two terms, which are added in a different order.
        tolerance: 1e-14,
        ways,
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

/// The function on echidna's tape, as in its documentation under "Gradient via reverse mode". Echidna has no `Sum`.
mod echidna {
    use echidna::Reverse;

    pub(super) fn gradient(x: &[f64]) -> Vec<f64> {
        let term = |x: &[Reverse<f64>]| {
            let (valley, slope) = (x[1] - x[0] * x[0], 1.0 - x[0]);
            100.0 * valley * valley + slope * slope
        };
        echidna::grad(
            |x| {
                x.windows(2)
                    .map(term)
                    .fold(Reverse::constant(0.0), |a, b| a + b)
            },
            x,
        )
    }
}

/// The function on a tape of echidna that is kept, as in its documentation under "record once, evaluate many".
mod echidna_kept {
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

/// The function on the tape of the crate `reverse`. Each term is a separate function and not a closure, because a
/// closure cannot name the lifetime of the tape.
mod reverse {
    use reverse::{Gradient, Tape, Var};

    fn term<'a>(x: &[Var<'a>]) -> Var<'a> {
        let (valley, slope) = (x[1] - x[0] * x[0], 1.0 - x[0]);
        100.0 * valley * valley + slope * slope
    }

    pub(super) fn gradient(x: &[f64]) -> Vec<f64> {
        let tape = Tape::new();
        let x = tape.add_vars(x);
        let sum = x.windows(2).map(term).sum::<Var<'_>>();
        sum.grad().wrt(&x)
    }
}

/// Duals of num_dual with a tangent for each argument. The crate's `gradient` uses these for vectors of any length.
mod num_dual {
    use nalgebra::DVector;
    use num_dual::{DualDVec64, gradient as dual_gradient};

    pub(super) fn gradient(x: &[f64]) -> Vec<f64> {
        let term = |x: &[DualDVec64]| {
            let (valley, slope) = (&x[1] - &x[0] * &x[0], -&x[0] + 1.0);
            &valley * &valley * 100.0 + &slope * &slope
        };
        let function =
            |x: DVector<DualDVec64>| x.as_slice().windows(2).map(term).sum::<DualDVec64>();
        let (_, gradient) = dual_gradient(function, &DVector::from_column_slice(x));
        gradient.as_slice().to_vec()
    }
}
