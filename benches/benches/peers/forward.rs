//! Measures derivatives in forward mode: a gradient with respect to ten arguments, and a dense Jacobian.

use crate::task::{Task, Way, kept};

/// The number of arguments of the gradient.
const FEW: usize = 10;
/// The number of arguments and values of the Jacobian.
const MANY: usize = 100;

pub(crate) fn gradient() -> Task {
    let x: &'static [f64; FEW] = &kept([std::array::from_fn(|i| 0.5 + 0.1 * (i as f64).sin())])[0];
    Task {
        title: format!("Gradient with respect to {FEW} arguments"),
        about: "A sum of products of a sine and an exponential over neighbouring arguments.",
        source: include_str!("forward.rs"),
        // The tolerance is for sines and exponentials of two libraries, and for products in a different order.
        tolerance: 1e-14,
        ways: vec![
            Way::new("primal", "", &["primal"], || vec![primal::waves(x)]),
            Way::new(
                "ours",
                "`value_and_gradient_array`",
                &["ours", "ours_array"],
                || ours_array::gradient(x),
            ),
            Way::new(
                "ours",
                "`gradient_forward`",
                &["ours", "ours_slice"],
                || ours_slice::gradient(x),
            ),
            Way::new(
                "num-dual",
                "`gradient`, `DualSVec64<10>`",
                &["num_dual"],
                || num_dual::gradient(x),
            ),
        ],
    }
}

pub(crate) fn jacobian() -> Task {
    let x: &'static [f64; MANY] = &kept([std::array::from_fn(|i| 0.5 + 0.1 * (i as f64).sin())])[0];
    Task {
        title: format!("Dense Jacobian of {MANY} values with respect to {MANY} arguments"),
        about: "Each value is a polynomial of three arguments.",
        source: include_str!("forward.rs"),
        // The tolerance is for a few roundings in each entry.
        tolerance: 1e-14,
        ways: vec![
            Way::new("primal", "", &["ours_values"], || ours_values::values(x)),
            Way::new(
                "ours",
                "`jacobian`",
                &["ours_values", "ours_jacobian"],
                || ours_jacobian::jacobian(x),
            ),
            Way::new(
                "num-dual",
                "`jacobian`, `DualSVec64<100>`",
                &["num_dual_jacobian"],
                || num_dual_jacobian::jacobian(x),
            ),
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

/// The function for any driver.
mod ours {
    use autodiff::{Function, Real};

    pub(super) struct Waves;

    impl Function for Waves {
        fn eval<R: Real>(&self, x: &[R]) -> R {
            let term = |x: &[R]| (x[0] * x[1]).sin() * (x[0] - x[1]).exp();
            x.windows(2).map(term).sum()
        }
    }
}

/// The gradient as an array.
mod ours_array {
    use autodiff::{Function, value_and_gradient_array};

    use super::{FEW, ours::Waves};

    pub(super) fn gradient(x: &[f64; FEW]) -> Vec<f64> {
        value_and_gradient_array(|x| Waves.eval(x), *x).1.to_vec()
    }
}

/// The gradient as a vector.
mod ours_slice {
    use autodiff::{Function, gradient_forward};

    use super::{FEW, ours::Waves};

    pub(super) fn gradient(x: &[f64; FEW]) -> Vec<f64> {
        gradient_forward(|x| Waves.eval(x), x)
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

/// The values for any driver.
mod ours_values {
    use autodiff::Real;

    pub(super) fn values<R: Real>(x: &[R]) -> Vec<R> {
        let at = |i: usize| x[i % x.len()];
        let value = |i: usize| {
            let (a, b, c) = (at(i), at(i + 1), at(i + 7));
            a * b - c * a + (b - c) * b
        };
        (0..x.len()).map(value).collect()
    }
}

/// A dense Jacobian. Each pass computes eight columns.
mod ours_jacobian {
    use super::ours_values::values;

    pub(super) fn jacobian(x: &[f64]) -> Vec<f64> {
        autodiff::jacobian(values, x).into_vec()
    }
}

/// Dual numbers with a fixed length, as the documentation of num_dual shows for `jacobian`.
mod num_dual_jacobian {
    use nalgebra::SVector;
    use num_dual::{DualSVec64, jacobian as dual_jacobian};

    use super::MANY;

    pub(super) fn jacobian(x: &[f64; MANY]) -> Vec<f64> {
        let values = |x: SVector<DualSVec64<MANY>, MANY>| {
            let at = |i: usize| x[i % MANY];
            SVector::<_, MANY>::from_fn(|i, _| {
                let (a, b, c) = (at(i), at(i + 1), at(i + 7));
                a * b - c * a + (b - c) * b
            })
        };
        let (_, jacobian) = dual_jacobian(values, &SVector::from(*x));
        jacobian.transpose().as_slice().to_vec()
    }
}
