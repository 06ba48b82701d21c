//! Springs that grow stiffer as they are stretched or compressed: their tension is `k (e + c e^3)` if their length
//! differs from the target by `e` (m).

use autodiff::arrays::Uniforms;
use autodiff::{Pullback, Real};

use super::bar::{Bar, BarForce, Tension};
use super::law::Law;
use crate::settings::Settings;

/// A spring that grows stiffer as it is stretched or compressed.
#[derive(Clone, Debug, Default)]
pub struct Stiffening<R = f64> {
    /// The cubic coefficient `c`, 1/m^2: the scene's `physics.stiffening`.
    pub cubic: R,
}

crate::settings! { @inputs Stiffening [R] [cubic: R, "physics.stiffening";] }

impl Settings for Stiffening {
    fn about(&self) -> &'static str {
        "Springs that grow stiffer as they are stretched or compressed."
    }
}

impl Law for Stiffening {
    const NAME: &'static str = "stiffening";
}

impl BarForce for Stiffening {
    const NOUN: &'static str = "spring";

    #[inline(always)]
    fn tension<R: Real>(law: &Stiffening<R>, bar: Bar<R>) -> R {
        let change = bar.length - bar.target;
        let growth = (law.cubic * change).fma(change, R::one());
        bar.stiffness * change * growth
    }

    fn energy(&self, bar: Bar<f64>) -> Option<f64> {
        let change = bar.length - bar.target;
        let square = change * change;
        // The energy is the integral of the tension k (e + c e^3).
        Some(0.5 * bar.stiffness * square * (1.0 + 0.5 * self.cubic * square))
    }

    #[inline(always)]
    fn tension_vjp<R: Real, const M: usize>(
        tension: &Tension<Self>,
        at: Pullback<R, 6, 2, M>,
        settings: &Uniforms<R>,
    ) -> [[R; 6]; M] {
        tension.emitted_vjp(at, settings)
    }
}
