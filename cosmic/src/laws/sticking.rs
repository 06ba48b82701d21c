//! Infinite friction: a node stops where it touches the ground.

use autodiff::Real;

use super::contact::{Contact, Drifting, Flying, Impact};
use super::law::Law;
use super::motion::{Drift, Particle};
use crate::geometry::Vector;

crate::settings! {
    /// Infinite friction: a node stops where it touches the ground.
    struct Sticking {}
}

impl Law for Sticking {
    const NAME: &'static str = "infinite";
}

impl Contact for Sticking {
    #[inline(always)]
    fn respond<R: Real, const D: usize>(&self, _: Impact<R, D>) -> Vector<R, D> {
        Vector::zero()
    }

    // Without the way after the impact, which is none.
    #[inline(always)]
    fn drift<R: Real, const D: usize>(
        &self,
        drift: &Drift,
        node: Particle<R, D>,
    ) -> Particle<R, D> {
        let (touches, moving) = drift.touch(node);
        Particle {
            x: node.after(moving).x,
            v: Vector::select(touches, Vector::zero(), node.v),
        }
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
