//! No contact: there is no ground.

use autodiff::Real;

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
    fn respond<R: Real, const D: usize>(&self, impact: Impact<R, D>) -> Vector<R, D> {
        impact.velocity
    }

    #[inline(always)]
    fn drift<R: Real, const D: usize>(
        &self,
        drift: &Drift,
        node: Particle<R, D>,
    ) -> Particle<R, D> {
        node.after(R::lit(drift.dt))
    }

    #[inline(always)]
    fn flying_vjp<R: Real>(flying: &Flying<Self>, x: [R; 7], y_bar: [R; 4]) -> [R; 7] {
        flying.emitted_vjp(x, y_bar)
    }

    #[inline(always)]
    fn drifting_vjp<R: Real>(drifting: &Drifting<Self>, x: [R; 4], y_bar: [R; 4]) -> [R; 4] {
        drifting.emitted_vjp(x, y_bar)
    }
}
