//! Difference quotients over a sweep of steps, and what they say about a claimed slope.

use super::Verdict;

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
}

/// `value(h)` is the function at distance `h` along the direction.
pub(super) fn sweep(
    value: impl Fn(f64) -> f64,
    steps: impl Iterator<Item = f64>,
    noise: f64,
) -> Vec<Slopes> {
    let here = value(0.0);
    let slopes = |step: f64| {
        let (behind, ahead) = (value(-step), value(step));
        Slopes {
            step,
            left: (here - behind) / step,
            central: (ahead - behind) / (2.0 * step),
            right: (ahead - here) / step,
            noise: noise * here.abs() / step,
        }
    };
    steps.map(slopes).collect()
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
    }
}

/// The plateau with the least spread, if any quotient is finite.
fn settled(sweep: &[Slopes], slope: impl Fn(&Slopes) -> f64) -> Option<Plateau> {
    (1..sweep.len().saturating_sub(1))
        .map(|level| plateau(sweep, &slope, level))
        .filter(|plateau| plateau.spread.is_finite())
        .min_by(|a, b| a.spread.total_cmp(&b.spread))
}

/// Judges a claimed slope.
pub(super) struct Judge {
    pub(super) claimed: f64,
    pub(super) typical: f64,
    pub(super) tolerance: f64,
}

impl Judge {
    /// Below this part of its slope a spread leaves a plateau a plateau.
    const ROUGH: f64 = 1e-2;
    /// A spread is a guess of an error, not a bound: this many of them are.
    const SAFETY: f64 = 4.0;

    /// What errors of a slope are measured against.
    pub(super) fn scale(&self, slope: f64) -> f64 {
        let scale = self.claimed.abs().max(slope.abs()).max(self.typical);
        scale.max(f64::MIN_POSITIVE)
    }

    /// Whether another exact derivative is the claimed one.
    pub(super) fn same(&self, derivative: f64) -> bool {
        self.claimed == derivative
            || (self.claimed - derivative).abs() <= self.tolerance * self.scale(derivative)
    }

    /// The verdict, and the slopes that it rests on.
    pub(super) fn verdict(&self, sweep: &[Slopes]) -> (Verdict, Slopes) {
        let central = |slopes: &Slopes| slopes.central;
        let Some(best) = settled(sweep, central).filter(|best| self.settles(best)) else {
            // No derivative to compare with: rough, or with an infinite slope.
            return (Verdict::Kink, sweep[sweep.len() / 2]);
        };
        if self.agrees(&best) {
            let kink = self.gap_stays(&sweep[best.level..]);
            let verdict = if kink { Verdict::Kink } else { Verdict::Smooth };
            return (verdict, sweep[best.level]);
        }
        // The stencil may have crossed a kink beside the point: a smaller step with a clearly
        // different slope, settled too, has the last word.
        for level in best.level + 1..sweep.len() - 1 {
            let closer = plateau(sweep, central, level);
            let apart = Self::SAFETY * (closer.spread + best.spread);
            let other = (closer.slope - best.slope).abs() > apart;
            if other && self.settles(&closer) && self.agrees(&closer) {
                return (Verdict::Smooth, sweep[level]);
            }
        }
        if self.between_sides(sweep) {
            return (Verdict::Kink, sweep[best.level]);
        }
        (Verdict::Wrong, sweep[best.level])
    }

    fn settles(&self, plateau: &Plateau) -> bool {
        let rough = Self::ROUGH * plateau.slope.abs().max(self.typical);
        plateau.spread <= rough.max(Self::SAFETY * plateau.noise)
    }

    fn agrees(&self, plateau: &Plateau) -> bool {
        let error = (self.claimed - plateau.slope).abs();
        self.claimed.is_finite()
            && error <= self.tolerance * self.scale(plateau.slope) + Self::SAFETY * plateau.spread
    }

    /// Whether left and right slope stay apart as the step shrinks: at a smooth point their gap
    /// shrinks like the step, a factor 10 over the three steps looked at.
    fn gap_stays(&self, sweep: &[Slopes]) -> bool {
        let [first, second, third, ..] = sweep else {
            return false;
        };
        let [first, second, third] = [first, second, third].map(|s| (s.right - s.left).abs());
        let stays = |gap: f64| gap > 0.5 * first && gap < 2.0 * first;
        first > self.tolerance * self.typical && stays(second) && stays(third)
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
