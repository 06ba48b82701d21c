//! No contact: there is no ground.

use autodiff::{Pullback, Real};

use super::contact::{Contact, Drifting, Flying, Impact};
use super::law::Law;
use super::motion::Drift;

crate::settings! {
    /// There is no ground.
    struct NoGround {}
}

impl Law for NoGround {
    const NAME: &'static str = "none";
}

impl Contact for NoGround {
    const HAS_GROUND: bool = false;

    #[inline(always)]
    fn respond<R: Real>(&self, impact: Impact<R>) -> [R; 2] {
        impact.velocity
    }

    #[inline(always)]
    fn drift<R: Real>(&self, drift: &Drift, [x, y]: [R; 2], [vx, vy]: [R; 2]) -> [R; 4] {
        let dt = R::lit(drift.dt);
        [dt.fma(vx, x), dt.fma(vy, y), vx, vy]
    }

    #[inline(always)]
    fn flying_vjp<R: Real, const M: usize>(
        flying: &Flying<Self>,
        at: Pullback<R, 7, 4, M>,
    ) -> [[R; 7]; M] {
        flying.emitted_vjp(at)
    }

    #[inline(always)]
    fn drifting_vjp<R: Real, const M: usize>(
        drifting: &Drifting<Self>,
        at: Pullback<R, 4, 4, M>,
    ) -> [[R; 4]; M] {
        drifting.emitted_vjp(at)
    }
}
