//! Actuators with the limits of a data sheet: a largest force, which falls with speed and brakes beyond the largest speed.
//!
//! The force falls linearly with speed and changes its sign at the speed without a load. That is the line of a DC motor,
//! which is a generator beyond this speed. It is also a model of a pneumatic cylinder with one-way flow control valves that
//! throttle the exhaust (meter-out): the air that leaves through the throttle has a back pressure, which grows with speed.
//! Without a load it equals the supply pressure, and it brakes a cylinder that something else moves faster. In a real valve
//! the flow is choked, so the back pressure grows more steeply with speed.

use autodiff::Real;
use autodiff_programs::Compiled;

use super::bar::{Bar, BarForce};
use crate::kernel;
use crate::laws::law::Law;
use crate::settings::above;

crate::settings! {
    /// Actuators whose force is limited and falls with speed, in place of their springs. Beyond their speed they brake.
    struct Actuator<R> {
        /// Largest force, pulling or pushing, of an actuator that does not brake.
        force: R = 10.0, allowed above(0.0, 1e6), unit "N", source "beyond the paper: take it from a data sheet";
        /// Speed at which the length changes without a load.
        speed: R = 1.0, allowed above(0.0, 1e3), unit "m/s", source "beyond the paper: take it from a data sheet";
    }
}

impl Law for Actuator {
    const NAME: &'static str = "actuator";
    const COMPILED: Compiled = Compiled::Narrow;
}

#[kernel]
impl BarForce for Actuator {
    const NEEDS_RATE: bool = true;

    /// An actuator pulls its length towards the target like a spring, but with at most `force` times `1 - rate / speed`
    /// in the direction in which it moves. While it is driven backwards it holds `force`. Beyond `speed` it brakes, whatever
    /// its target is, and the brake goes on growing with speed: a constant brake would be a kink, at which the implicit step
    /// overshoots. Where the spring reaches `force`, at rate 0, and at twice its speed backwards, the derivative is that of the
    /// constant force. Where the spring meets the line that falls with speed, it is that of the spring.
    fn tension<R: Real>(actuator: &Actuator<R>, bar: Bar<R>) -> R {
        let force = actuator.force;
        let share = bar.share_of_actuator();
        let spring = bar.spring();
        let relative = bar.rate * actuator.speed.recip();
        let held = spring.min(force).max(-force);
        let pull = force * (R::one() + relative);
        let push = force * (R::one() - relative);
        let tension = (-push).max(pull.min(held));
        share * (tension - spring)
    }
}
