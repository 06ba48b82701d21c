//! Difference quotients over a sweep of steps, and what they say about a claimed slope.

use super::{Verdict, WRONG_BY};

/// The difference quotients of one step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slopes {
    pub(super) step: f64,
    pub(super) left: f64,
    pub(super) central: f64,
    pub(super) right: f64,
    /// What the value's noise makes of the quotients.
    pub(super) noise: f64,
}

impl Slopes {
    /// How far left and right slope are apart.
    fn gap(&self) -> f64 {
        (self.right - self.left).abs()
    }

    /// The steeper side's slope, less one that is taken away from both.
    pub(super) fn steepest(&self, less: f64) -> f64 {
        (self.left - less).abs().max((self.right - less).abs())
    }
}

/// A step at which quotients change least from step to step.
#[derive(Clone, Copy)]
struct Plateau {
    level: usize,
    slope: f64,
    /// How much the slope differs from those of the neighbouring steps, and its noise. Above the
    /// step truncation decides, below it noise, here neither, so this measures both. (Differences
    /// alone do not: steps below the value's resolution give zero, time and again.)
    spread: f64,
    noise: f64,
    /// The slope of the steeper side: at a minimum the central one is zero and no measure.
    steepest: f64,
}

/// `value(h)` is the function at distance `h` along the direction, `here` that at none. Its values and
/// its arguments, which are up to `size`, have a relative error of `noise`.
pub(super) fn sweep(
    (here, value): (f64, impl Fn(f64) -> f64),
    steps: impl Iterator<Item = f64>,
    (noise, size): (f64, f64),
) -> Vec<Slopes> {
    let slopes = |step: f64| {
        let (behind, ahead) = (value(-step), value(step));
        let mut slopes = Slopes {
            step,
            left: (here - behind) / step,
            central: (ahead - behind) / (2.0 * step),
            right: (ahead - here) / step,
            noise: 0.0,
        };
        // The value at the point alone does not tell: at a minimum it may be zero.
        let largest = here.abs().max(behind.abs()).max(ahead.abs());
        slopes.noise = noise * (largest + size * slopes.steepest(0.0)) / step;
        slopes
    };
    steps.map(slopes).collect()
}

/// How much the slope changes over the middle step: what sets a scale where the slope is zero and
/// the gradient too. Of the steps above, the one with the least change for its length tells, for a
/// jump beside the point is no change of the slope.
pub(super) fn change(sweep: &[Slopes], claimed: f64) -> f64 {
    let middle = sweep.len() / 2;
    let change = |slopes: &Slopes| slopes.steepest(claimed) / slopes.step * sweep[middle].step;
    let changes = sweep[..=middle].iter().map(change);
    // Values that are not finite set no scale.
    let least = changes.filter(|change| change.is_finite()).reduce(f64::min);
    least.unwrap_or(0.0)
}

fn central(slopes: &Slopes) -> f64 {
    slopes.central
}

fn plateau(sweep: &[Slopes], slope: impl Fn(&Slopes) -> f64, level: usize) -> Plateau {
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
fn settled(sweep: &[Slopes], slope: impl Fn(&Slopes) -> f64) -> Option<Plateau> {
    (1..sweep.len().saturating_sub(1))
        .map(|level| plateau(sweep, &slope, level))
        .filter(|plateau| plateau.spread.is_finite())
        .min_by(|a, b| a.spread.total_cmp(&b.spread))
}

/// By how much the values closer than the plateau at `level` miss its slope, in the median: their noise,
/// whatever they are said to have. Noise, and a jump beside the point, moves each side its own way
/// and shows here; a kink, a cusp or a spike at the point moves both alike and does not.
pub(super) fn missed(sweep: &[Slopes], level: usize) -> f64 {
    let miss = |slopes: &Slopes| (slopes.central - sweep[level].central).abs() * slopes.step;
    let mut misses: Vec<f64> = sweep[level + 1..].iter().map(miss).collect();
    misses.sort_by(f64::total_cmp);
    misses[misses.len() / 2]
}

/// Whether the values bend by more than their noise, the one that shows and the one they are said
/// to have.
fn bends(slopes: &Slopes, missed: f64) -> bool {
    slopes.gap() * slopes.step > Judge::BENT * missed && slopes.gap() > Judge::SAFETY * slopes.noise
}

/// Whether the gap between left and right slope grows as the step shrinks.
fn grows_apart(sweep: &[Slopes]) -> bool {
    sweep.len() > 2 && sweep[2].gap() > 2.0 * sweep[0].gap()
}

/// Judges a claimed slope.
#[derive(Clone, Copy)]
pub(super) struct Judge {
    pub(super) claimed: f64,
    pub(super) typical: f64,
    pub(super) tolerance: f64,
    /// A slope that changes the value by no more than its noise over a step as long as the point.
    pub(super) unseen: f64,
}

impl Judge {
    /// Below this part of its slope a spread leaves a plateau a plateau.
    const ROUGH: f64 = 1e-2;
    /// A spread is a guess of an error, not a bound: this many of them are.
    const SAFETY: f64 = 4.0;
    /// Values that bend by this many of their misses do so for more than noise: noise up to one
    /// bends them by up to four, and misses are an eighth of it, in the median, or more.
    const BENT: f64 = 32.0;
    /// A gap that shrinks to more than this part of itself stays: that of a smooth function shrinks
    /// to 0.32 from one level to the next.
    const STAYS: f64 = 0.5;

    /// What errors of a slope are measured against.
    pub(super) fn scale(&self, slope: f64) -> f64 {
        let scale = self.claimed.abs().max(slope.abs()).max(self.typical);
        scale.max(f64::MIN_POSITIVE)
    }

    /// Whether another exact derivative is the claimed one.
    pub(super) fn same(&self, derivative: f64) -> bool {
        self.claimed == derivative
            || (self.claimed - derivative).abs()
                <= self.tolerance * self.scale(derivative) + self.unseen
    }

    /// The verdict, the slopes that it rests on, and by how much they may be off.
    pub(super) fn verdict(&self, sweep: &[Slopes]) -> (Verdict, Slopes, f64) {
        let Some(best) = settled(sweep, central).filter(|best| self.settles(best)) else {
            // No derivative to compare with: rough, or with an infinite slope.
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
        // The stencil may have crossed a kink beside the point: a smaller step with a clearly
        // different slope, settled too, has the last word.
        for level in best.level + 1..sweep.len() - 1 {
            let closer = plateau(sweep, central, level);
            let unsure = Self::SAFETY * (closer.spread + best.spread);
            let other = (closer.slope - best.slope).abs() > unsure;
            if other && self.settles(&closer) && self.agrees(&closer) {
                return rests(agreed(self.stays_apart(sweep, &closer)), &closer);
            }
        }
        // Sides that grow apart, a cusp's, have every slope between them.
        if self.between_sides(sweep) || kink && grows_apart(&sweep[best.level..]) {
            return rests(Verdict::Kink, &best);
        }
        rests(Verdict::Wrong, &best)
    }

    /// What differences alone say of the slope made wrong by [`WRONG_BY`], if they are sure enough of
    /// the right one to tell, given the verdict on that and by how much they may be off.
    pub(super) fn control(
        &self,
        sweep: &[Slopes],
        (verdict, unsure): (Verdict, f64),
    ) -> Option<Verdict> {
        let unsure = unsure + self.tolerance * self.scale(self.claimed);
        // They may be off once when they agree and once when they do not.
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

    /// Whether left and right slope stay apart, or grow apart, somewhere from the plateau down: at
    /// a smooth point their gap shrinks like the step. Over four levels, for noise keeps them apart
    /// over three by chance.
    fn stays_apart(&self, sweep: &[Slopes], best: &Plateau) -> bool {
        let missed = missed(sweep, best.level);
        let first = best.level.min(sweep.len().saturating_sub(4));
        let seen =
            |slopes: &Slopes| slopes.gap() > self.tolerance * self.typical && bends(slopes, missed);
        let stays = |pair: &[Slopes]| pair[1].gap() > Self::STAYS * pair[0].gap();
        sweep[first..].windows(4).any(|levels| {
            let ends = [levels[0], levels[3]];
            stays(&ends) && levels.windows(2).all(stays) && levels.iter().all(seen)
        })
    }

    /// The plateau with the least spread of those below over which left and right slope come
    /// together: then it was not a kink that kept them apart above, but something narrow.
    fn closer(&self, sweep: &[Slopes], best: &Plateau) -> Option<Plateau> {
        let together = |closer: &Plateau| {
            let levels = &sweep[closer.level - 1..=closer.level + 1];
            let missed = missed(sweep, closer.level);
            let shrinks = |pair: &[Slopes]| pair[1].gap() < Self::STAYS * pair[0].gap();
            levels.windows(2).all(shrinks) && levels.iter().all(|slopes| bends(slopes, missed))
        };
        (best.level + 1..sweep.len() - 1)
            .map(|level| plateau(sweep, central, level))
            .filter(|closer| self.settles(closer) && together(closer))
            .filter(|closer| !self.stays_apart(sweep, closer))
            .min_by(|a, b| a.spread.total_cmp(&b.spread))
    }

    /// Whether the two sides settle on different slopes, with the claimed one among them.
    fn between_sides(&self, sweep: &[Slopes]) -> bool {
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
