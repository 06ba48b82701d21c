//! Infinite friction: a node stops where it touches the ground.

use autodiff::arrays::Uniforms;
use autodiff::{Pullback, Real};

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
    fn respond<R: Real, const D: usize>(_: &Self, _: Impact<R, D>) -> Vector<R, D> {
        Vector::zero()
    }

    // Without the way after the impact, which is none.
    #[inline(always)]
    fn drift<R: Real, const D: usize>(
        _: &Self,
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
