//! Infinite friction: a node stops where it touches the ground.

use autodiff::{Pullback, Real};

use super::contact::{Contact, Drifting, Flying, Impact};
use super::law::Law;
use super::motion::Drift;

crate::settings! {
    /// Infinite friction: a node stops where it touches the ground.
    struct Sticking {}
}

impl Law for Sticking {
    const NAME: &'static str = "infinite";
}

impl Contact for Sticking {
    #[inline(always)]
    fn respond<R: Real>(&self, _: Impact<R>) -> [R; 2] {
        [R::zero(); 2]
    }

    // Without the way after the impact, which is none.
    #[inline(always)]
    fn drift<R: Real>(&self, drift: &Drift, [x, y]: [R; 2], [vx, vy]: [R; 2]) -> [R; 4] {
        let (touches, moving) = drift.touch(y, vy);
        let after = |v: R| R::select(touches, R::zero(), v);
        [moving.fma(vx, x), moving.fma(vy, y), after(vx), after(vy)]
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
