//! Coulomb friction: reduces the velocity along the ground and never reverses it (D5).

use autodiff::Real;

use super::contact::{Contact, Flying, Impact, emitted_adjoints};
use crate::geometry::Vector;
use crate::kernel;
use crate::laws::law::Law;
use crate::laws::motion::{Drift, Particle};

crate::settings! {
    /// Coulomb friction: slows a node along the ground; its velocity out of the ground becomes zero.
    struct Coulomb<R> {} of physics {
        /// Coefficient of friction.
        friction: R = "physics.friction";
    }
}

impl Law for Coulomb {
    const NAME: &'static str = "coulomb";
}

#[kernel]
impl Contact for Coulomb {
    fn respond<R: Real, const D: usize>(law: &Coulomb<R>, impact: Impact<R, D>) -> Vector<R, D> {
        let (along, friction) = (impact.velocity.along(), law.friction);
        let braked = along.shortened(friction * impact.velocity.up().abs());
        // Without friction, nothing holds a node at rest. The derivative of its velocity must then be 1, but the
        // derivative of `shortened` at 0 is 0.
        Vector::select(R::zero().less(friction), braked, along).along()
    }

    // After the impact, the velocity out of the ground is 0. The rest of the drift therefore changes only the position
    // along the ground.
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

    fn grip<R: Real>(law: &Coulomb<R>) -> R {
        law.friction
    }

    emitted_adjoints! {}
}
