//! Actuators with the limits of a data sheet: a largest force, which falls with speed.

use autodiff::Real;

use super::bar::{Bar, BarForce};
use super::law::Law;
use crate::kernel;
use crate::settings::above;

crate::settings! {
    /// Actuators whose force is limited and falls with speed, in place of their springs.
    struct Actuator<R> {
        /// Largest force, pulling or pushing.
        force: R = 10.0, allowed above(0.0, 1e6), unit "N", source "beyond the paper: take it from a data sheet";
        /// Speed at which the length changes without a load.
        speed: R = 1.0, allowed above(0.0, 1e3), unit "m/s", source "beyond the paper: take it from a data sheet";
    }
}

impl Law for Actuator {
    const NAME: &'static str = "actuator";
}

#[kernel]
impl BarForce for Actuator {
    const NEEDS_RATE: bool = true;

    /// An actuator pulls its length towards the target like a spring, but with at most `force` times `1 - rate / speed`
    /// in the direction in which it does work. While it is driven backwards it holds `force`. At its
    /// limits, the derivative is that of the limit, and at rate 0 that of an actuator which is driven backwards.
    fn tension<R: Real>(actuator: &Actuator<R>, bar: Bar<R>) -> R {
        let (zero, one) = (R::zero(), R::one());
        let share = bar.share_of_actuator();
        let spring = bar.spring();
        let relative = bar.rate * actuator.speed.recip();
        let pull = actuator.force * (one + relative).clamp(zero, one);
        let push = actuator.force * (one - relative).clamp(zero, one);
        share * (spring.min(pull).max(-push) - spring)
    }
}
