//! Infinite friction: a node stops where it touches the ground.

use autodiff::Real;
use autodiff_programs::Compiled;

use super::contact::{Contact, Flying, Impact, emitted_adjoints};
use crate::geometry::Vector;
use crate::kernel;
use crate::laws::law::Law;
use crate::laws::motion::{Drift, Particle};

crate::settings! {
    /// Infinite friction: a node stops where it touches the ground.
    struct Sticking {}
}

impl Law for Sticking {
    const NAME: &'static str = "infinite";
    const COMPILED: Compiled = Compiled::Narrow;
}

#[kernel]
impl Contact for Sticking {
    fn respond<R: Real, const D: usize>(_: &Self, _: Impact<R, D>) -> Vector<R, D> {
        Vector::zero()
    }

    // After the impact the node does not move, so only the time before the impact changes its position.
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

    emitted_adjoints! {}
}
