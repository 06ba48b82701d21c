//! Bars that push up to their Euler load.

use autodiff::Real;

use super::bar::{Bar, BarForce};
use super::law::Law;
use crate::settings::above;

crate::settings! {
    /// Bars buckle: they push with at most their Euler load.
    struct Buckle<R> {
        /// Bending stiffness `E I` of a bar: the elastic modulus of its material times the second moment of area of its
        /// section. With joints at both ends, a bar of the length `l` buckles under `pi^2 E I / l^2`.
        bending: R = 0.03, allowed above(0.0, 1e9), unit "N m2", source "a carbon rod of 1.5 mm, with 120 GPa";
    }
}

impl Law for Buckle {
    const NAME: &'static str = "buckle";
}

impl<R: Real> Buckle<R> {
    /// The Euler load, N.
    #[inline(always)]
    fn load(&self, rest_length: R) -> R {
        R::lit(std::f64::consts::PI.powi(2)) * self.bending / (rest_length * rest_length)
    }
}

impl BarForce for Buckle {
    const REPLACES_SPRING: bool = true;

    /// A bar that is compressed further than its Euler load allows keeps pushing with that load. There the derivative
    /// with respect to its length is 0.
    #[inline(always)]
    fn tension<R: Real>(buckle: &Buckle<R>, bar: Bar<R>) -> R {
        let spring = bar.spring();
        spring.max(-buckle.load(bar.rest_length)) - spring
    }

    fn energy(&self, bar: Bar<f64>) -> Option<f64> {
        // The missing force grows with the compression beyond that of the Euler load.
        let beyond = (-bar.spring() - self.load(bar.rest_length)).max(0.0);
        Some(match bar.stiffness > 0.0 {
            true => -0.5 * beyond * beyond / bar.stiffness,
            false => 0.0,
        })
    }
}
