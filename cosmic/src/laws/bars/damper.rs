//! Damping inside bars: the viscous part of a Kelvin-Voigt material. Without it, only the drag of the air on nodes
//! (`physics.damping`) dampens vibrations.

use autodiff::Real;

use super::bar::{Bar, BarForce};
use crate::kernel;
use crate::laws::law::Law;
use crate::settings::within;

crate::settings! {
    /// Bars resist changes of their length, with a damping (N s/m) of `time` times their stiffness.
    struct Damper<R> {
        /// Viscosity of a bar's material divided by its stiffness. It gives a bar whose ends vibrate against
        /// each other at `w` rad/s the damping ratio `w * time / 2`.
        time: R = 3e-4, allowed within(0.0, 1.0), unit "s",
            auto "a damping ratio of 0.088 for a bar of skeleton between two neighbouring nodes that carry nothing else; at \
                  most 1 s",
            source "beyond the paper";
    }
}

impl Law for Damper {
    const NAME: &'static str = "damper";
}

#[kernel]
impl BarForce for Damper {
    const NEEDS_RATE: bool = true;

    fn tension<R: Real>(damper: &Damper<R>, bar: Bar<R>) -> R {
        bar.stiffness * damper.time * bar.rate
    }
}
