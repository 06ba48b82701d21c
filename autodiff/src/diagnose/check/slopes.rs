//! Computes difference quotients over a range of steps, and judges a claimed slope by them.
//!
//! [`Judge::verdict`] decides in this order:
//! 1. The central quotient is taken where it changes least from step to step, on a plateau. Without a plateau
//!    the function is rough: kink.
//! 2. If the left and the right slope stay apart at this step and smaller ones, the point is a kink. If they
//!    come together on a plateau of smaller steps, that plateau replaces the first.
//! 3. A claimed slope that agrees with the plateau is right: smooth, or kink by point 2.
//! 4. A claimed slope that agrees with a plateau of smaller steps, with a clearly different slope, is right too.
//! 5. A claimed slope between the different slopes of the two sides is a choice at a kink: kink. Where the sides
//!    grow apart, as at a cusp, so is any slope.
//! 6. Any other slope is wrong.

use super::report::{Verdict, WRONG_BY};

/// The difference quotients for one step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quotients {
    pub(super) step: f64,
    pub(super) left: f64,
    pub(super) central: f64,
    pub(super) right: f64,
    /// A bound on the error of the quotients that noise in the function's values causes.
    pub(super) noise: f64,
}

impl Quotients {
    /// Returns the distance between the left and the right slope.
    fn gap(&self) -> f64 {
        (self.right - self.left).abs()
    }

    /// Returns the larger of two distances: that of the left slope and that of the right slope from `base`.
    pub(super) fn steepest(&self, base: f64) -> f64 {
        (self.left - base).abs().max((self.right - base).abs())
    }
}

/// A step around which the quotients change little from one step to the next.
#[derive(Clone, Copy)]
struct Plateau {
    /// The index of the step in the sweep. A larger index means a smaller step.
    level: usize,
    slope: f64,
    /// The difference from the slopes of the neighbouring steps, plus the noise. This estimates the error of the slope:
    /// the truncation error dominates at larger steps, and the noise at smaller ones. The difference alone is not
    /// enough. At steps so small that the value does not change, all slopes are zero and differ by nothing.
    spread: f64,
    noise: f64,
    /// The magnitude of the left or the right slope, whichever is larger. It sets the scale, because at a minimum the
    /// central slope is zero.
    steepest: f64,
}

/// Returns the difference quotients for all steps. `value(h)` is the function at the distance `h` from the point along
/// the direction, and `here` is the value at the point. Values and arguments have a relative error of `noise`. The
/// largest argument has the magnitude `size`.
pub(super) fn sweep(
    here: f64,
    value: impl Fn(f64) -> f64,
    steps: impl Iterator<Item = f64>,
    noise: f64,
    size: f64,
) -> Vec<Quotients> {
    let slopes = |step: f64| {
        let (behind, ahead) = (value(-step), value(step));
        let mut slopes = Quotients {
            step,
            left: (here - behind) / step,
            central: (ahead - behind) / (2.0 * step),
            right: (ahead - here) / step,
            noise: 0.0,
        };
        // Not the value at the point alone, because it may be zero at a minimum.
        let largest = here.abs().max(behind.abs()).max(ahead.abs());
        slopes.noise = noise * (largest + size * slopes.steepest(0.0)) / step;
        slopes
    };
    steps.map(slopes).collect()
}

/// Returns an estimate of how much the slope changes over the middle one of the steps. It is the scale of errors where
/// the slope and the gradient are zero. The change is measured at the middle step and at all larger steps, and scaled
/// in proportion to the step. The smallest result counts, because a jump beside the point is not a change of the slope.
pub(super) fn change(sweep: &[Quotients], claimed: f64) -> f64 {
    let middle = sweep.len() / 2;
    let change = |slopes: &Quotients| slopes.steepest(claimed) / slopes.step * sweep[middle].step;
    let changes = sweep[..=middle].iter().map(change);
    // An infinite or NaN change cannot set the scale.
    let least = changes.filter(|change| change.is_finite()).reduce(f64::min);
    least.unwrap_or(0.0)
}

fn central(slopes: &Quotients) -> f64 {
    slopes.central
}

fn plateau(sweep: &[Quotients], slope: impl Fn(&Quotients) -> f64, level: usize) -> Plateau {
    let [before, here, after] = [-1, 0, 1].map(|i: isize| {
        let level = level.saturating_add_signed(i).min(sweep.len() - 1);
        slope(&sweep[level])
    });
    let noise = sweep[level].noise;
    Plateau {
        level,
        slope: here,
        spread: (here - before).abs() + (here - after).abs() + noise,
        noise,
        steepest: sweep[level].steepest(0.0),
    }
}

/// Returns the plateau with the least spread. `None` if no spread is finite.
fn settled(sweep: &[Quotients], slope: impl Fn(&Quotients) -> f64) -> Option<Plateau> {
    (1..sweep.len().saturating_sub(1))
        .map(|level| plateau(sweep, &slope, level))
        .filter(|plateau| plateau.spread.is_finite())
        .min_by(|a, b| a.spread.total_cmp(&b.spread))
}

/// Returns the noise that is observed in the values. It is measured at all steps smaller than step number `level`: the
/// noise is the median error with which their values miss a line with the central slope of step `level`. Noise, and a
/// jump beside the point, move the values on the two sides differently, so they count. A kink, a cusp or a spike at the
/// point moves both sides alike, so it does not count.
pub(super) fn missed(sweep: &[Quotients], level: usize) -> f64 {
    let miss = |slopes: &Quotients| (slopes.central - sweep[level].central).abs() * slopes.step;
    let mut misses: Vec<f64> = sweep[level + 1..].iter().map(miss).collect();
    misses.sort_by(f64::total_cmp);
    misses[misses.len() / 2]
}

/// Returns whether the left and the right slope differ by more than noise can explain: by more than the observed noise
/// (`missed`), and by more than the noise that the options state.
fn bends(slopes: &Quotients, missed: f64) -> bool {
    slopes.gap() * slopes.step > Judge::BENT * missed && slopes.gap() > Judge::SAFETY * slopes.noise
}

/// Returns whether the gap between the left and the right slope grows as the step shrinks.
fn grows_apart(sweep: &[Quotients]) -> bool {
    sweep.len() > 2 && sweep[2].gap() > 2.0 * sweep[0].gap()
}

/// Judges a claimed slope by the difference quotients.
#[derive(Clone, Copy)]
pub(super) struct Judge {
    pub(super) claimed: f64,
    pub(super) typical: f64,
    pub(super) tolerance: f64,
    /// Slopes smaller than this count as zero. Over a step as long as the point, such a slope changes the value by less
    /// than the noise.
    pub(super) unseen: f64,
}

impl Judge {
    /// The largest spread of a plateau, as a fraction of its slope.
    const ROUGH: f64 = 1e-2;
    /// The spread of a plateau estimates the error of its slope. The error is assumed to be below this many times the
    /// spread.
    const SAFETY: f64 = 4.0;
    /// If the values bend at the point by more than this many times their observed noise, noise cannot be the reason.
    /// Noise of amplitude 1 bends the values by up to 4, and its observed median is at least 1/8.
    const BENT: f64 = 32.0;
    /// The gap between the left and the right slope counts as staying open if, from one step to the next smaller one,
    /// it keeps more than this fraction. For a smooth function it keeps 0.32.
    const STAYS: f64 = 0.5;

    /// Returns the scale for relative errors of a slope. It is clamped to finite numbers, because an error divided by
    /// infinity would be zero.
    pub(super) fn scale(&self, slope: f64) -> f64 {
        let scale = self.claimed.abs().max(slope.abs()).max(self.typical);
        scale.clamp(f64::MIN_POSITIVE, f64::MAX)
    }

    /// Returns whether the claimed slope agrees with a derivative from another exact source, within the tolerance.
    pub(super) fn same(&self, derivative: f64) -> bool {
        self.claimed == derivative
            || (self.claimed - derivative).abs()
                <= self.tolerance * self.scale(derivative) + self.unseen
    }

    /// Returns the verdict, the difference quotients that decided it, and their possible error.
    pub(super) fn verdict(&self, sweep: &[Quotients]) -> (Verdict, Quotients, f64) {
        let Some(best) = settled(sweep, central).filter(|best| self.settles(best)) else {
            // Without a plateau the function is rough, or its slope is infinite.
            return (Verdict::Kink, sweep[sweep.len() / 2], f64::INFINITY);
        };
        let apart = self.stays_apart(sweep, &best);
        let closer = apart.then(|| self.closer(sweep, &best)).flatten();
        let kink = apart && closer.is_none();
        let best = closer.unwrap_or(best);
        let agreed = |kink| if kink { Verdict::Kink } else { Verdict::Smooth };
        let rests = |verdict, on: &Plateau| (verdict, sweep[on.level], Self::SAFETY * on.spread);
        if self.agrees(&best) {
            return rests(agreed(kink), &best);
        }
        // The steps of the plateau may cross a kink beside the point. So if the quotients of smaller steps settle on a
        // clearly different slope, that slope decides.
        for level in best.level + 1..sweep.len() - 1 {
            let closer = plateau(sweep, central, level);
            let unsure = Self::SAFETY * (closer.spread + best.spread);
            let other = (closer.slope - best.slope).abs() > unsure;
            if other && self.settles(&closer) && self.agrees(&closer) {
                return rests(agreed(self.stays_apart(sweep, &closer)), &closer);
            }
        }
        // If the left and the right slope grow apart, as at a cusp, every slope counts as being between them.
        if self.between_sides(sweep) || kink && grows_apart(&sweep[best.level..]) {
            return rests(Verdict::Kink, &best);
        }
        rests(Verdict::Wrong, &best)
    }

    /// Returns the verdict on a slope that is wrong on purpose, by [`WRONG_BY`]. `verdict` is the verdict on the
    /// claimed slope, and `unsure` is the possible error of the differences. Returns `None` unless the claimed slope is
    /// smooth and the differences are accurate enough.
    pub(super) fn control(
        &self,
        sweep: &[Quotients],
        verdict: Verdict,
        unsure: f64,
    ) -> Option<Verdict> {
        let unsure = unsure + self.tolerance * self.scale(self.claimed);
        // The error counts twice: the claimed slope is compared with the differences, and so is the wrong slope. Hence
        // a quarter.
        let sure = unsure < 0.25 * WRONG_BY * self.claimed.abs();
        let wrong = Judge {
            claimed: self.claimed * (1.0 + WRONG_BY),
            ..*self
        };
        (verdict == Verdict::Smooth && sure).then(|| wrong.verdict(sweep).0)
    }

    fn settles(&self, plateau: &Plateau) -> bool {
        let rough = Self::ROUGH * plateau.steepest.max(self.typical);
        plateau.spread <= rough.max(Self::SAFETY * plateau.noise)
    }

    fn agrees(&self, plateau: &Plateau) -> bool {
        let error = (self.claimed - plateau.slope).abs();
        self.claimed.is_finite()
            && error <= self.tolerance * self.scale(plateau.slope) + Self::SAFETY * plateau.spread
    }

    /// Returns whether the gap between the left and the right slope stays open or grows over some four successive
    /// steps, from the plateau's step to smaller ones. At a smooth point, the gap shrinks in proportion to the step.
    /// Three steps are not enough, because noise may keep the gap open over three steps by chance.
    fn stays_apart(&self, sweep: &[Quotients], best: &Plateau) -> bool {
        let missed = missed(sweep, best.level);
        let first = best.level.min(sweep.len().saturating_sub(4));
        let seen = |slopes: &Quotients| {
            slopes.gap() > self.tolerance * self.typical && bends(slopes, missed)
        };
        let stays = |pair: &[Quotients]| pair[1].gap() > Self::STAYS * pair[0].gap();
        sweep[first..].windows(4).any(|levels| {
            let ends = [levels[0], levels[3]];
            stays(&ends) && levels.windows(2).all(stays) && levels.iter().all(seen)
        })
    }

    /// Looks for a plateau at smaller steps than those of `best`, where the left and the right slope approach each
    /// other. Returns the plateau with the least spread. If it exists, a narrow term caused the gap at larger steps,
    /// and not a kink.
    fn closer(&self, sweep: &[Quotients], best: &Plateau) -> Option<Plateau> {
        let together = |closer: &Plateau| {
            let levels = &sweep[closer.level - 1..=closer.level + 1];
            let missed = missed(sweep, closer.level);
            let shrinks = |pair: &[Quotients]| pair[1].gap() < Self::STAYS * pair[0].gap();
            levels.windows(2).all(shrinks) && levels.iter().all(|slopes| bends(slopes, missed))
        };
        (best.level + 1..sweep.len() - 1)
            .map(|level| plateau(sweep, central, level))
            .filter(|closer| self.settles(closer) && together(closer))
            .filter(|closer| !self.stays_apart(sweep, closer))
            .min_by(|a, b| a.spread.total_cmp(&b.spread))
    }

    /// Returns whether the left and the right slope each settle, on different values, and the claimed slope is between
    /// them.
    fn between_sides(&self, sweep: &[Quotients]) -> bool {
        let left = settled(sweep, |slopes| slopes.left).filter(|left| self.settles(left));
        let right = settled(sweep, |slopes| slopes.right).filter(|right| self.settles(right));
        let (Some(left), Some(right)) = (left, right) else {
            return false;
        };
        let (low, high) = (left.slope.min(right.slope), left.slope.max(right.slope));
        let unsure = self.tolerance * self.scale(high.abs().max(low.abs()))
            + Self::SAFETY * (left.spread + right.spread);
        high - low > unsure && self.claimed >= low - unsure && self.claimed <= high + unsure
    }
}
