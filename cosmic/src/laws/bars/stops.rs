//! End stops of actuators. `materials.max_strain` limits only the target length of an actuator. The bar is compliant
//! and overshoots its target unless it meets a stop.

use autodiff::Real;

use super::bar::{Bar, BarForce};
use crate::kernel;
use crate::laws::law::Law;
use crate::settings::{above, within};

crate::settings! {
    /// Actuators meet a stiff stop at either end of their stroke.
    struct Stops<R> {
        /// Strain of a bar at its stops, stretched or compressed. With the actuator's value of
        /// `materials.max_strain`, the stops are exactly at the ends of its range of targets.
        at: R = 0.35, allowed above(0.0, 0.99),
            auto "27/35 of the largest actuation strain, so that an actuator meets its stop before the \
                  end of its stroke; with the law `actuator` the whole of it, because that law limits the force",
            source "beyond the paper";
        /// Stiffness of the stops of an actuator with the largest strain `at`. For an actuator with another largest
        /// strain, the stiffness is in proportion to that strain.
        stiffness: R = 400.0, allowed within(0.0, 1e9), unit "N/m",
            auto "130/3 times the stiffness of an actuator, so that actuators of any stiffness overshoot their stops by the \
                  same strain",
            source "that of skeleton";
    }
}

impl Law for Stops {
    const NAME: &'static str = "stops";
}

#[kernel]
impl BarForce for Stops {
    const NOUN: &'static str = "stop";

    /// The force is proportional to the share of the actuator material in the bar, so a passive bar has no stops. If
    /// the bar just touches a stop, the derivative is 0, as it is between the stops. (The kink table in
    /// `autodiff/src/kinks.md` defines the derivative of `max` for equal numbers.)
    fn tension<R: Real>(stops: &Stops<R>, bar: Bar<R>) -> R {
        let (longest, shortest) = stops.ends(bar.rest_length);
        let zero = R::zero();
        let beyond = (bar.length - longest).max(zero) - (shortest - bar.length).max(zero);
        stops.stiffness_of(&bar) * beyond
    }

    fn energy(&self, bar: Bar<f64>) -> Option<f64> {
        let (longest, shortest) = self.ends(bar.rest_length);
        let beyond = (bar.length - longest).max(0.0) + (shortest - bar.length).max(0.0);
        Some(0.5 * self.stiffness_of(&bar) * beyond * beyond)
    }
}

impl<R: Real> Stops<R> {
    /// The stiffness of the stops of a bar, N/m.
    #[inline(always)]
    fn stiffness_of(&self, bar: &Bar<R>) -> R {
        bar.strain * self.at.recip() * self.stiffness
    }

    /// The largest and the smallest length at which the bar does not touch a stop.
    #[inline(always)]
    fn ends(&self, rest_length: R) -> (R, R) {
        let [longest, shortest] = [R::one() + self.at, R::one() - self.at];
        (rest_length * longest, rest_length * shortest)
    }
}
