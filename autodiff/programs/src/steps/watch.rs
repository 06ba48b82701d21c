//! A check that the states of a rollout stay within a bound.

use autodiff::internal::WIDEST;
use autodiff::simd::{Lane, Vectorized};
use autodiff::{Mask, Real};

use super::instance::Instance;
use crate::arrays::Array;

/// Remembers for each start whether the magnitudes of all numbers in its states so far were below a bound.
#[derive(Clone, Copy)]
pub(crate) struct Watch<R> {
    bound: R,
    /// Zero, or NaN once a number of a state was not below the bound. Element `k` belongs to start `k % starts`.
    verdict: [R; WIDEST],
}

impl<R: Real> Watch<R> {
    pub(crate) fn new(bound: f64) -> Self {
        Self {
            bound: R::lit(bound),
            verdict: [R::zero(); WIDEST],
        }
    }

    /// Checks the state that is in a row.
    pub(crate) fn look(&mut self, instance: &Instance<R>, row: &[R]) {
        R::vectorize(Look {
            watch: self,
            parts: &instance.layout.state,
            row,
        });
    }

    /// Returns one number for each start (initial state): NaN if any number in any of its states was not below the
    /// bound, otherwise zero.
    pub(crate) fn verdicts(&self, starts: usize) -> Vec<R> {
        let mut verdicts = vec![R::zero(); starts];
        for (place, &seen) in self.verdict.iter().enumerate() {
            verdicts[place % starts] += seen;
        }
        verdicts
    }
}

struct Look<'a, R> {
    watch: &'a mut Watch<R>,
    /// The parts of the state. Each part begins with a number of the first start, so a lane always belongs to one
    /// start.
    parts: &'a [Array],
    row: &'a [R],
}

impl<R: Real> Vectorized<R> for Look<'_, R> {
    const USE_THE_ATTRIBUTE_KERNEL: () = ();
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        let bound = L::splat(self.watch.bound);
        // This shortcut is only taken in SIMD lanes, because a tape would record the sums.
        if L::N > 1 && self.is_small::<L>(bound) {
            return;
        }
        let mut below = L::Mask::splat(true);
        for part in self.parts {
            let numbers = &self.row[part.range()];
            for i in (0..numbers.len()).step_by(L::N) {
                // Both comparisons are false for NaN.
                let x = L::load_up_to(&numbers[i..]);
                below = below & x.less(bound) & (-bound).less(x);
            }
        }
        let verdict = &mut self.watch.verdict;
        let nan = L::lit(f64::NAN);
        L::select(below, L::load(verdict), nan).store(verdict);
    }
}

impl<R: Real> Look<'_, R> {
    /// Returns whether the sum of all magnitudes is below the bound in every lane. If it is, every number is below the
    /// bound, even with rounding. This is cheaper than comparing each number. Squares would be slow: those of tiny numbers
    /// are subnormal.
    #[inline(always)]
    fn is_small<L: Lane<R>>(&self, bound: L) -> bool {
        let mut sums = [L::zero(); 2];
        for part in self.parts {
            let numbers = &self.row[part.range()];
            let pairs = numbers.chunks_exact(2 * L::N);
            let rest = pairs.remainder();
            for pair in pairs {
                let (x, y) = (L::load(pair), L::load(&pair[L::N..]));
                sums = [sums[0] + x.abs(), sums[1] + y.abs()];
            }
            for rest in rest.chunks(L::N) {
                sums[0] += L::load_up_to(rest).abs();
            }
        }
        (sums[0] + sums[1]).less(bound).all()
    }
}
