//! The contact law of a world without ground.

use autodiff::Real;
use autodiff_programs::Compiled;

use super::contact::{Contact, Flying, Impact, emitted_adjoints};
use crate::geometry::Vector;
use crate::kernel;
use crate::laws::law::Law;
use crate::laws::motion::{Drift, Particle};

crate::settings! {
    /// There is no ground.
    struct NoGround {}
}

impl Law for NoGround {
    const NAME: &'static str = "none";
    const COMPILED: Compiled = Compiled::Narrow;
}

#[kernel]
impl Contact for NoGround {
    const HAS_GROUND: bool = false;

    fn respond<R: Real, const D: usize>(_: &Self, impact: Impact<R, D>) -> Vector<R, D> {
        impact.velocity
    }

    fn drift<R: Real, const D: usize>(
        _: &Self,
        drift: &Drift,
        node: Particle<R, D>,
    ) -> Particle<R, D> {
        node.after(R::lit(drift.dt))
    }

    emitted_adjoints! {}
}
