//! Measures a gradient in forward mode: a sum of products of a sine and an exponential over neighbouring arguments.

use crate::task::{Task, Way, kept};

/// The number of arguments.
const FEW: usize = 10;

pub(crate) fn task() -> Task {
    let x: &'static [f64; FEW] = &kept([std::array::from_fn(|i| 0.5 + 0.1 * (i as f64).sin())])[0];
    Task {
        title: format!("Gradient with respect to {FEW} arguments"),
        source: include_str!("forward.rs"),
        // The tolerance is for sines and exponentials of two libraries, and for products in a different order.
        tolerance: 1e-14,
        ways: vec![
            Way::new("primal", "", || vec![primal::waves(x)]),
            Way::new("ours", "`value_and_gradient_array`", || ours::gradient(x)),
            Way::new("num-dual", "`gradient`, `DualSVec64<10>`", || {
                num_dual::gradient(x)
            }),
        ],
    }
}

/// The function in plain numbers.
mod primal {
    pub(super) fn waves(x: &[f64]) -> f64 {
        let term = |x: &[f64]| (x[0] * x[1]).sin() * (x[0] - x[1]).exp();
        x.windows(2).map(term).sum()
    }
}

/// The function for any driver, and its gradient as an array.
mod ours {
    use autodiff::{Real, value_and_gradient_array};

    use super::FEW;

    fn waves<R: Real>(x: &[R]) -> R {
        let term = |x: &[R]| (x[0] * x[1]).sin() * (x[0] - x[1]).exp();
        x.windows(2).map(term).sum()
    }

    pub(super) fn gradient(x: &[f64; FEW]) -> Vec<f64> {
        value_and_gradient_array(|x| waves(x), *x).1.to_vec()
    }
}

/// Dual numbers with a fixed length, as the documentation of num_dual shows for `gradient`.
mod num_dual {
    use nalgebra::SVector;
    use num_dual::{DualNum, DualSVec64, gradient as dual_gradient};

    use super::FEW;

    pub(super) fn gradient(x: &[f64; FEW]) -> Vec<f64> {
        let waves = |x: SVector<DualSVec64<FEW>, FEW>| {
            let term = |x: &[DualSVec64<FEW>]| (x[0] * x[1]).sin() * (x[0] - x[1]).exp();
            x.as_slice().windows(2).map(term).sum::<DualSVec64<FEW>>()
        };
        let (_, gradient) = dual_gradient(waves, &SVector::from(*x));
        gradient.as_slice().to_vec()
    }
}
