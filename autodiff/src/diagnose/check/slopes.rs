//! Computes difference quotients for two steps, and judges a claimed slope by them.

use super::report::{Verdict, WRONG_BY};
use crate::math::DoubleDouble;

/// The ratio of the two steps.
const RATIO: f64 = 16.0;
/// A remainder that falls faster than the step to this power belongs to a right slope. With a wrong slope or at a kink the
/// power is 1, and for a smooth function 2.
const ORDER: f64 = 1.25;
/// The rounding error of a value in double-double, relative to the value. It allows for a few hundred operations.
const ROUNDING: f64 = 1e-29;
/// A remainder is clear of rounding errors if it is this many times as large.
const CLEAR: f64 = 32.0;
/// A gradient in f64 has the rounding errors of some dozens of operations. Slopes that change the value by less than this
/// part, over a step as long as the point, count as zero.
const UNSEEN: f64 = 64.0 * f64::EPSILON;

/// The difference quotients for one step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quotients {
    pub(super) step: f64,
    pub(super) left: f64,
    pub(super) central: f64,
    pub(super) right: f64,
}

impl Quotients {
    fn new(here: DoubleDouble, value: &dyn Fn(f64) -> DoubleDouble, step: f64) -> Self {
        let (behind, ahead) = (value(-step), value(step));
        Self {
            step,
            left: (here - behind).to_f64() / step,
            central: (ahead - behind).to_f64() / (2.0 * step),
            right: (ahead - here).to_f64() / step,
        }
    }

    fn is_finite(&self) -> bool {
        [self.left, self.central, self.right]
            .iter()
            .all(|x| x.is_finite())
    }

    /// Returns the distance between the left and the right slope.
    fn gap(&self) -> f64 {
        (self.right - self.left).abs()
    }

    /// Returns the distance of the left or the right slope from `base`, whichever is larger.
    fn steepest(&self, base: f64) -> f64 {
        (self.left - base).abs().max((self.right - base).abs())
    }
}

/// Judges a claimed slope by the difference quotients along a direction.
#[derive(Clone, Copy)]
pub(super) struct Judge {
    claimed: f64,
    /// The typical size of a slope. It sets the scale of errors where the slope is small.
    typical: f64,
    tolerance: f64,
    /// Slopes smaller than this are rounding errors of a gradient in f64.
    unseen: f64,
    /// The rounding error of a remainder.
    rounding: f64,
    far: Quotients,
    pub(super) near: Quotients,
}

impl Judge {
    /// Takes the differences. `value(h)` is the function at the distance `h` from the point along the direction, and `here`
    /// is the value at the point, whose largest argument has the magnitude `size`.
    pub(super) fn new(
        here: DoubleDouble,
        value: &dyn Fn(f64) -> DoubleDouble,
        [step, size]: [f64; 2],
    ) -> Self {
        let [far, near] = [step, step / RATIO].map(|step| Quotients::new(here, value, step));
        let change = size * near.steepest(0.0);
        let finite = |x: f64| if x.is_finite() { x } else { 0.0 };
        let magnitude = here.to_f64().abs();
        Self {
            claimed: 0.0,
            typical: 0.0,
            tolerance: 0.0,
            unseen: finite(UNSEEN * magnitude / size.max(1.0)),
            rounding: finite(ROUNDING * (magnitude + change)),
            far,
            near,
        }
    }

    /// Sets the claimed slope, the typical size of a slope, and the tolerance.
    pub(super) fn of(self, claimed: f64, typical: f64, tolerance: f64) -> Self {
        Self {
            claimed,
            typical,
            tolerance,
            ..self
        }
    }

    /// Returns the scale for relative errors of a slope. It is finite, because an error divided by infinity would be
    /// zero.
    pub(super) fn scale(&self, slope: f64) -> f64 {
        let claimed = Some(self.claimed.abs()).filter(|claimed| claimed.is_finite());
        let scale = claimed.unwrap_or(0.0).max(slope.abs()).max(self.typical);
        scale.clamp(f64::MIN_POSITIVE, f64::MAX)
    }

    /// Returns how far a slope may be from the claimed one.
    fn allowed(&self, slope: f64) -> f64 {
        self.tolerance * self.scale(slope) + self.unseen
    }

    /// Returns whether the claimed slope agrees with a derivative from another exact source, within the tolerance.
    pub(super) fn same(&self, derivative: f64) -> bool {
        self.claimed == derivative || (self.claimed - derivative).abs() <= self.allowed(derivative)
    }

    /// Returns the order at which the remainder of the claimed slope falls with the step. The remainder is taken on both
    /// sides of the point and the larger one counts. `None` if it is not clear of rounding errors, which the claimed slope
    /// has too.
    pub(super) fn order(&self) -> Option<f64> {
        let [far, near] = [self.far, self.near].map(|q| q.step * q.steepest(self.claimed));
        let of_slope = self.near.step * f64::EPSILON * self.scale(self.near.central);
        let is_clear = near > CLEAR * (self.rounding + of_slope) && far.is_finite();
        is_clear.then(|| (far / near).ln() / RATIO.ln())
    }

    /// Returns whether the left and the right slope differ from the claimed one by no more than the tolerance, or differ
    /// less and less.
    fn is_smooth(&self) -> bool {
        let Self { near, .. } = self;
        let off = near.steepest(self.claimed);
        let agrees = off <= self.allowed(near.central) + CLEAR * self.rounding / near.step;
        agrees || self.order().is_some_and(|order| order > ORDER)
    }

    pub(super) fn verdict(&self) -> Verdict {
        let Self { far, near, .. } = self;
        if self.claimed.is_nan() {
            return Verdict::Wrong;
        }
        if !far.is_finite() || !near.is_finite() {
            return Verdict::Kink;
        }
        if self.is_smooth() {
            return Verdict::Smooth;
        }
        // At a smooth point the gap shrinks in proportion to the step.
        let allowed = self.allowed(near.steepest(0.0));
        let is_kink = near.gap() > allowed && near.gap() > 0.5 * far.gap();
        let grows = near.gap() > 1.05 * far.gap();
        let least = near.left.min(near.right) - allowed;
        let most = near.left.max(near.right) + allowed;
        if is_kink && (grows || (least..=most).contains(&self.claimed)) {
            return Verdict::Kink;
        }
        // A slope that is infinite, or that oscillates, has no central quotient to agree with.
        let size = near.steepest(0.0).min(far.steepest(0.0)).max(self.typical);
        match (far.central - near.central).abs() > 0.25 * size.max(allowed) {
            true => Verdict::Kink,
            false => Verdict::Wrong,
        }
    }

    /// Returns the verdict on a slope that is wrong on purpose, by [`WRONG_BY`]. Returns `None` unless the claimed slope is
    /// smooth, and so large that its error shows.
    pub(super) fn control(&self, verdict: Verdict) -> Option<Verdict> {
        let doubt = self.allowed(self.claimed) + self.far.steepest(self.claimed);
        // The error counts twice: the claimed slope is compared with the differences, and so is the wrong slope. Hence
        // a quarter.
        let sure = doubt < 0.25 * WRONG_BY * self.claimed.abs();
        let wrong = Self {
            claimed: self.claimed * (1.0 + WRONG_BY),
            ..*self
        };
        (verdict == Verdict::Smooth && sure).then(|| wrong.verdict())
    }
}
