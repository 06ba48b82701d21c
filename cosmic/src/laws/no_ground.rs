//! No contact: there is no ground.

use autodiff::arrays::Uniforms;
use autodiff::{Pullback, Real};

use super::contact::{Contact, Drifting, Flying, Impact};
use super::law::Law;
use super::motion::{Drift, Particle};
use crate::geometry::Vector;

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
    fn respond<R: Real, const D: usize>(_: &Self, impact: Impact<R, D>) -> Vector<R, D> {
        impact.velocity
    }

    #[inline(always)]
    fn drift<R: Real, const D: usize>(
        _: &Self,
        drift: &Drift,
        node: Particle<R, D>,
    ) -> Particle<R, D> {
        node.after(R::lit(drift.dt))
    }

    #[inline(always)]
    fn flying_vjp<R: Real, const M: usize>(
        flying: &Flying<Self>,
        at: Pullback<R, 7, 4, M>,
        given: &Uniforms<R>,
    ) -> [[R; 7]; M] {
        flying.emitted_vjp(at, given)
    }

    #[inline(always)]
    fn drifting_vjp<R: Real, const M: usize>(
        drifting: &Drifting<Self>,
        at: Pullback<R, 4, 4, M>,
        _: &Uniforms<R>,
    ) -> [[R; 4]; M] {
        drifting.emitted_vjp(at)
    }
}
