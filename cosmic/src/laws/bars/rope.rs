//! Bars that pull and do not push: ropes, tendons, and air muscles.

use autodiff::Real;
use autodiff_programs::Compiled;

use super::bar::{Bar, BarForce};
use crate::kernel;
use crate::laws::law::Law;
use crate::settings::within;

crate::settings! {
    /// Bars pull only, like ropes.
    struct Rope<R> {
        /// Whether actuators pull only: 1 for yes, 0 for no.
        actuator: R = 1.0, allowed within(0.0, 1.0), source "beyond the paper";
        /// Whether skeleton bars pull only.
        skeleton: R = 0.0, allowed within(0.0, 1.0), source "beyond the paper";
    }
}

impl Law for Rope {
    const NAME: &'static str = "rope";
    const COMPILED: Compiled = Compiled::Narrow;
}

impl<R: Real> Rope<R> {
    /// The share of a bar's compression that is missing.
    #[inline(always)]
    fn share(&self, bar: &Bar<R>) -> R {
        let of_actuator = bar.share_of_actuator();
        (self.actuator - self.skeleton).fma(of_actuator, self.skeleton)
    }
}

#[kernel]
impl BarForce for Rope {
    /// A bar that is shorter than its target does not push. At the target the derivative is that of the slack rope.
    fn tension<R: Real>(rope: &Rope<R>, bar: Bar<R>) -> R {
        let spring = bar.spring();
        rope.share(&bar) * (spring.max(R::zero()) - spring)
    }

    fn energy(&self, bar: Bar<f64>) -> Option<f64> {
        let slack = (bar.target - bar.length).max(0.0);
        Some(-0.5 * self.share(&bar) * bar.stiffness * slack * slack)
    }
}
