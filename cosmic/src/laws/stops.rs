//! End stops of actuators. The largest strain of a material limits the target length, but the bar
//! is compliant and overshoots the target unless it meets a stop.

use autodiff::Real;

use super::bar::{Bar, BarForce};
use super::law::Law;
use crate::settings::{above, within};

crate::settings! {
    /// Actuators meet a stiff stop at either end of their stroke.
    struct Stops<R> {
        /// Strain at the stops, stretched and compressed; that of `materials.max_strain` for a stop right
        /// at the end of what is asked for.
        at: R = 0.35, allowed above(0.0, 0.99), source "beyond the paper";
        /// Stiffness of the stops of an actuator whose largest strain is `at`, and in proportion to that strain.
        stiffness: R = 400.0, allowed within(0.0, 1e6), unit "N/m", source "that of skeleton";
    }
}

impl Law for Stops {
    const NAME: &'static str = "stops";
}

impl BarForce for Stops {
    const NOUN: &'static str = "stop";

    /// Proportional to the share of actuator, so a passive bar has no stops. Exactly at a stop the derivative is 0, as
    /// within the free stroke (`max` of equals in the kink table of `autodiff/src/real.rs`).
    #[inline(always)]
    fn tension<R: Real>(stops: &Stops<R>, bar: Bar<R>) -> R {
        let (longest, shortest) = stops.ends(bar.rest_length);
        let zero = R::zero();
        let beyond = (bar.length - longest).max(zero) - (shortest - bar.length).max(zero);
        stops.share(bar.strain) * stops.stiffness * beyond
    }

    fn energy(&self, bar: Bar<f64>) -> Option<f64> {
        let (longest, shortest) = self.ends(bar.rest_length);
        let beyond = (bar.length - longest).max(0.0) + (shortest - bar.length).max(0.0);
        Some(0.5 * self.share(bar.strain) * self.stiffness * beyond * beyond)
    }
}

impl<R: Real> Stops<R> {
    /// The largest and the smallest length of the free stroke.
    #[inline(always)]
    fn ends(&self, rest_length: R) -> (R, R) {
        let [longest, shortest] = [R::one() + self.at, R::one() - self.at];
        (rest_length * longest, rest_length * shortest)
    }

    /// The share of actuator in a bar, if `at` is the largest strain of an actuator.
    #[inline(always)]
    fn share(&self, strain: R) -> R {
        strain * self.at.recip()
    }
}
