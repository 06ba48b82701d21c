//! Hooke's law: the tension of a bar is proportional to the change of its length.

use autodiff::Real;
use autodiff_programs::Pullback;

use super::bar::{Bar, BarForce, Tension};
use crate::kernel;
use crate::laws::law::Law;

crate::settings! {
    /// Tension proportional to the change of length.
    struct Hooke {}
}

impl Law for Hooke {
    const NAME: &'static str = "hooke";
}

#[kernel]
impl BarForce for Hooke {
    const NOUN: &'static str = "spring";

    fn tension<R: Real>(_: &Self, bar: Bar<R>) -> R {
        bar.spring()
    }

    fn energy(&self, bar: Bar<f64>) -> Option<f64> {
        let change = bar.length - bar.target;
        Some(0.5 * bar.stiffness * change * change)
    }

    fn tension_vjp<R: Real, const M: usize>(
        tension: &Tension<Self>,
        at: Pullback<R, 6, 2, M>,
    ) -> [[R; 6]; M] {
        tension.emitted_vjp(at)
    }

    fn tension_vjp_in_space<R: Real, const M: usize>(
        tension: &Tension<Self, 3>,
        at: Pullback<R, 7, 3, M>,
    ) -> [[R; 7]; M] {
        tension.emitted_vjp(at)
    }
}
