//! Coulomb friction: it shortens the velocity along the ground and never reverses it (D5).

use autodiff::{Pullback, Real};

use super::contact::{Contact, Drifting, Flying, Impact};
use super::law::Law;
use super::motion::Drift;
use crate::settings::Settings;

/// The normal part of the velocity vanishes; friction brakes the part along the ground.
#[derive(Clone, Debug, Default)]
pub struct Coulomb {
    /// Coefficient of friction: the scene's `physics.friction`.
    pub friction: f64,
}

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
    fn respond<R: Real>(&self, Impact { velocity, .. }: Impact<R>) -> [R; 2] {
        let ([along, out], friction) = (velocity, R::lit(self.friction));
        let left = along.abs() - friction * out.abs();
        let braked = along.signum() * left.max(R::zero());
        // Without friction nothing holds a node at rest: no kink is there, and no derivative of
        // one.
        [
            R::select(R::zero().less(friction), braked, along),
            R::zero(),
        ]
    }

    // Without a way out of the ground after the impact, which is none.
    #[inline(always)]
    fn drift<R: Real>(&self, drift: &Drift, [x, y]: [R; 2], [vx, vy]: [R; 2]) -> [R; 4] {
        let (touches, moving) = drift.touch(y, vy);
        let rest = R::lit(drift.dt) - moving;
        let velocity = [vx, vy];
        let [braked, _] = self.respond(Impact { velocity, rest });
        [
            moving.fma(vx, x) + R::select(touches, rest * braked, R::zero()),
            moving.fma(vy, y),
            R::select(touches, braked, vx),
            R::select(touches, R::zero(), vy),
        ]
    }

    fn with_friction(self, friction: f64) -> Self {
        Self { friction }
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
