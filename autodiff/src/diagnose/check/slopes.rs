//! Difference quotients over a sweep of steps, and what they say about a claimed slope.
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

/// The difference quotients of one step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quotients {
    pub(super) step: f64,
    pub(super) left: f64,
    pub(super) central: f64,
    pub(super) right: f64,
    /// The error of the quotients caused by the noise of the values.
    pub(super) noise: f64,
}

impl Quotients {
    /// The distance between the left and the right slope.
    fn gap(&self) -> f64 {
        (self.right - self.left).abs()
    }

    /// The larger distance of the two sides' slopes from `base`.
    pub(super) fn steepest(&self, base: f64) -> f64 {
        (self.left - base).abs().max((self.right - base).abs())
    }
}

/// A step around which the quotients change little from one step to the next.
#[derive(Clone, Copy)]
struct Plateau {
    /// The index of the step in the sweep. Steps shrink as the index grows.
    level: usize,
    slope: f64,
    /// The difference from the slopes of the neighbouring steps, plus the noise. Truncation dominates at larger
    /// steps and noise at smaller ones, so this estimates both. The difference alone is not enough, because all
    /// steps below the value's resolution give the same slope, zero.
    spread: f64,
    noise: f64,
    /// The slope of the steeper side. It sets the scale, because at a minimum the central slope is zero.
    steepest: f64,
}

/// The quotients of all steps. `value(h)` is the function at distance `h` along the direction, and `here` its
/// value at the point. Values and arguments, of magnitudes up to `size`, have a relative error of `noise`.
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
        // The value at the point may be zero at a minimum.
        let largest = here.abs().max(behind.abs()).max(ahead.abs());
        slopes.noise = noise * (largest + size * slopes.steepest(0.0)) / step;
        slopes
    };
    steps.map(slopes).collect()
}

/// The change of the slope over the middle step. It is the scale of errors where the slope and the gradient are zero.
/// It is extrapolated from that larger step whose slope changes least relative to its length, because a jump beside
/// the point is not a change of the slope.
pub(super) fn change(sweep: &[Quotients], claimed: f64) -> f64 {
    let middle = sweep.len() / 2;
    let change = |slopes: &Quotients| slopes.steepest(claimed) / slopes.step * sweep[middle].step;
    let changes = sweep[..=middle].iter().map(change);
    // Only finite values set a scale.
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

/// The plateau with the least spread, if any quotient is finite.
fn settled(sweep: &[Quotients], slope: impl Fn(&Quotients) -> f64) -> Option<Plateau> {
    (1..sweep.len().saturating_sub(1))
        .map(|level| plateau(sweep, &slope, level))
        .filter(|plateau| plateau.spread.is_finite())
        .min_by(|a, b| a.spread.total_cmp(&b.spread))
}

/// The observed noise of the values: the median error with which values at smaller steps than that of index `level`
/// miss the plateau's central slope. Noise, or a jump beside the point, moves the two sides differently, so it shows
/// here. A kink, a cusp or a spike at the point moves both sides alike, so it does not show.
pub(super) fn missed(sweep: &[Quotients], level: usize) -> f64 {
    let miss = |slopes: &Quotients| (slopes.central - sweep[level].central).abs() * slopes.step;
    let mut misses: Vec<f64> = sweep[level + 1..].iter().map(miss).collect();
    misses.sort_by(f64::total_cmp);
    misses[misses.len() / 2]
}

/// Whether the values bend by more than the observed noise (`missed`) and the stated noise.
fn bends(slopes: &Quotients, missed: f64) -> bool {
    slopes.gap() * slopes.step > Judge::BENT * missed && slopes.gap() > Judge::SAFETY * slopes.noise
}

/// Whether the gap between left and right slope grows as the step shrinks.
fn grows_apart(sweep: &[Quotients]) -> bool {
    sweep.len() > 2 && sweep[2].gap() > 2.0 * sweep[0].gap()
}

/// Judges a claimed slope.
#[derive(Clone, Copy)]
pub(super) struct Judge {
    pub(super) claimed: f64,
    pub(super) typical: f64,
    pub(super) tolerance: f64,
    /// At this slope, a step as long as the point changes the value by its noise. Smaller slopes are not
    /// distinguished from zero.
    pub(super) unseen: f64,
}

impl Judge {
    /// The largest spread of a plateau, relative to its slope.
    const ROUGH: f64 = 1e-2;
    /// A spread is an estimate of the error. This many times the spread is a bound.
    const SAFETY: f64 = 4.0;
    /// Values that bend by this many times their observed noise do so for another reason. Noise of amplitude 1 bends
    /// them by up to 4, and its observed median is at least 1/8.
    const BENT: f64 = 32.0;
    /// A gap stays if the next smaller step keeps more than this part of it. The gap of a smooth function shrinks to
    /// 0.32.
    const STAYS: f64 = 0.5;

    /// Returns the scale for relative errors of a slope. It is clamped to finite numbers, because an error divided by
    /// infinity would be zero.
    pub(super) fn scale(&self, slope: f64) -> f64 {
        let scale = self.claimed.abs().max(slope.abs()).max(self.typical);
        scale.clamp(f64::MIN_POSITIVE, f64::MAX)
    }

    /// Whether the claimed slope equals another exact derivative, up to the tolerance.
    pub(super) fn same(&self, derivative: f64) -> bool {
        self.claimed == derivative
            || (self.claimed - derivative).abs()
                <= self.tolerance * self.scale(derivative) + self.unseen
    }

    /// Returns the verdict, the slopes that it rests on, and their possible error.
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
        // The steps of the plateau may cross a kink beside the point. If smaller steps settle on a clearly
        // different slope, that slope decides.
        for level in best.level + 1..sweep.len() - 1 {
            let closer = plateau(sweep, central, level);
            let unsure = Self::SAFETY * (closer.spread + best.spread);
            let other = (closer.slope - best.slope).abs() > unsure;
            if other && self.settles(&closer) && self.agrees(&closer) {
                return rests(agreed(self.stays_apart(sweep, &closer)), &closer);
            }
        }
        // Every slope is between sides that grow apart, as at a cusp.
        if self.between_sides(sweep) || kink && grows_apart(&sweep[best.level..]) {
            return rests(Verdict::Kink, &best);
        }
        rests(Verdict::Wrong, &best)
    }

    /// Returns the verdict on the slope that is made wrong by [`WRONG_BY`], from the verdict on the claimed slope and
    /// the possible error of the differences. Returns `None` unless the differences are sure enough of the claimed
    /// slope.
    pub(super) fn control(
        &self,
        sweep: &[Quotients],
        verdict: Verdict,
        unsure: f64,
    ) -> Option<Verdict> {
        let unsure = unsure + self.tolerance * self.scale(self.claimed);
        // The error counts twice: in the comparison with the claimed slope and in that with the wrong slope.
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

    /// Whether the left and the right slope stay apart or grow apart somewhere from the plateau down. At a
    /// smooth point their gap shrinks like the step. This looks at four levels, because noise may keep them
    /// apart over three by chance.
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

    /// The plateau with the least spread among those at smaller steps where the left and the right slope come
    /// together. If there is one, a narrow term and not a kink kept them apart at larger steps.
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

    /// Whether the two sides settle on different slopes with the claimed slope between them.
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
