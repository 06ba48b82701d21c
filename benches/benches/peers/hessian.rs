//! Measures the computation of the Hessian of a logistic regression's loss.

use crate::task::{Task, Way, kept};

/// The number of weights.
const WEIGHTS: usize = 10;
/// The number of data.
const DATA: usize = 200;

/// A datum: its features, multiplied by the sign of its class. The loss is the sum of `ln(1 + exp(-w x))` over the data
/// `x`.
type Datum = [f64; WEIGHTS];

pub(crate) fn task() -> Task {
    let number = |i: usize| (0.618_033_988 * (i as f64 + 1.0)).fract() - 0.5;
    let datum = |i: usize| std::array::from_fn(|j| 2.0 * number(i * WEIGHTS + j));
    let data: &'static [Datum] = kept((0..DATA).map(datum));
    let w: &'static Datum = &kept([std::array::from_fn(number)])[0];
    Task {
        title: format!("Hessian of a logistic regression, {WEIGHTS} weights and {DATA} data"),
        source: include_str!("hessian.rs"),
        // The tolerance is for sums of 200 terms in a different order, and for different forms of the derivative of
        // ln(1 + e).
        tolerance: 1e-13,
        ways: vec![
            Way::new("by hand", "", || hand::hessian(data, w)),
            Way::new("ours", "`hessian` of a `data::Sum`", ours::hessian(data, w)),
            Way::new(
                "echidna",
                "`hessian_vec`, tape kept",
                echidna::hessian(data, w),
            ),
        ],
    }
}

/// The known formula for the Hessian of a generalised linear model, without automatic differentiation.
mod hand {
    use super::{Datum, WEIGHTS};

    pub(super) fn hessian(data: &[Datum], w: &Datum) -> Vec<f64> {
        let mut hessian = vec![0.0; WEIGHTS * WEIGHTS];
        for x in data {
            let margin: f64 = x.iter().zip(w).map(|(x, w)| x * w).sum();
            let share = 1.0 / (1.0 + margin.exp());
            let curvature = share * (1.0 - share);
            for (row, xi) in hessian.chunks_mut(WEIGHTS).zip(x) {
                for (entry, xj) in row.iter_mut().zip(x) {
                    *entry += curvature * xi * xj;
                }
            }
        }
        hessian
    }
}

/// The loss of one datum as a summand, which runs in lanes over the data.
mod ours {
    use autodiff::Real;
    use autodiff_programs::data::{Sum, Summand};

    use super::Datum;

    #[derive(Clone)]
    struct Loss;

    impl Summand for Loss {
        fn eval<R: Real>(&self, w: &[R], x: &[R]) -> R {
            (-R::dot(w, x)).softplus()
        }
    }

    pub(super) fn hessian(data: &[Datum], w: &Datum) -> impl Fn() -> Vec<f64> {
        let sum = Sum::new(Loss, data);
        move || autodiff::hessian(|w| sum.run(w), w).into_vec()
    }
}

/// A tape of echidna that is recorded once. Each pass computes ten directions.
mod echidna {
    use echidna::BReverse64;
    use num_traits::Float;

    use super::Datum;

    pub(super) fn hessian(data: &[Datum], w: &Datum) -> impl FnMut() -> Vec<f64> {
        let zero = BReverse64::constant(0.0);
        let loss = |w: &[BReverse64]| {
            let margin = |x: &Datum| x.iter().zip(w).fold(zero, |sum, (&x, &w)| sum + x * w);
            data.iter()
                .fold(zero, |sum, x| sum + (-margin(x)).exp().ln_1p())
        };
        let (tape, _) = echidna::record(loss, w);
        move || tape.hessian_vec::<10>(w).2.concat()
    }
}
