//! Coulomb friction: it shortens the velocity along the ground and never reverses it (D5).

use autodiff::arrays::Uniforms;
use autodiff::{Pullback, Real};

use super::contact::{Contact, Drifting, Flying, Impact};
use super::law::Law;
use super::motion::{Drift, Particle};
use crate::geometry::Vector;
use crate::settings::Settings;

/// The normal part of the velocity vanishes; friction brakes the part along the ground.
#[derive(Clone, Debug, Default)]
pub struct Coulomb<R = f64> {
    /// Coefficient of friction: the scene's `physics.friction`.
    pub friction: R,
}

crate::settings_inputs! { Coulomb [R] [friction: R, "physics.friction";] }

impl Settings for Coulomb {
    fn about(&self) -> &'static str {
        "Coulomb friction: it brakes a node along the ground; the velocity out of it vanishes."
    }
}

impl Law for Coulomb {
    const NAME: &'static str = "coulomb";
}

impl Contact for Coulomb {
    #[inline(always)]
    fn respond<R: Real, const D: usize>(law: &Coulomb<R>, impact: Impact<R, D>) -> Vector<R, D> {
        let (along, friction) = (impact.velocity.along(), law.friction);
        let braked = along.shortened(friction * impact.velocity.up().abs());
        // Without friction nothing holds a node at rest: no kink is there, and no derivative of
        // one.
        Vector::select(R::zero().less(friction), braked, along).along()
    }

    // Without a way out of the ground after the impact, which is none.
    #[inline(always)]
    fn drift<R: Real, const D: usize>(
        law: &Coulomb<R>,
        drift: &Drift,
        node: Particle<R, D>,
    ) -> Particle<R, D> {
        let (touches, moving) = drift.touch(node);
        let (velocity, rest) = (node.v, R::lit(drift.dt) - moving);
        let braked = Self::respond(law, Impact { velocity, rest });
        let slid = Vector::select(touches, braked * rest, Vector::zero());
        Particle {
            x: node.after(moving).x.moved_along(slid),
            v: Vector::select(touches, braked, velocity),
        }
    }

    fn with_friction(self, friction: f64) -> Self {
        Self { friction }
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
        settings: &Uniforms<R>,
    ) -> [[R; 4]; M] {
        drifting.emitted_vjp(at, settings)
    }
}
