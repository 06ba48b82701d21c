//! Watching the states that a program goes through.

use super::{Array, Program};
use crate::lanes::{Lane, Vectorized, WIDEST};
use crate::real::{Mask, Real};

/// Whether every number of every state so far is below a bound in magnitude.
#[derive(Clone, Copy)]
pub(crate) struct Watch<R> {
    bound: R,
    /// Zeros, NaN where a number was not. Places belong to the starts by turns.
    verdict: [R; WIDEST],
}

impl<R: Real> Watch<R> {
    pub(crate) fn new(bound: f64) -> Self {
        Self {
            bound: R::lit(bound),
            verdict: [R::zero(); WIDEST],
        }
    }

    /// Looks at the state with which a row begins.
    pub(crate) fn look(&mut self, program: &Program<R>, row: &[R]) {
        R::vectorize(Look {
            watch: self,
            parts: &program.layout.state,
            row,
        });
    }

    /// What was seen of each of so many starts: zero, or NaN.
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
    /// Of the state, whose places divide among the starts as lanes do: each part begins with the
    /// first.
    parts: &'a [Array],
    row: &'a [R],
}

impl<R: Real> Vectorized<R> for Look<'_, R> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        let bound = L::splat(self.watch.bound);
        // Numbers that are no lanes may record what is computed with them.
        if L::N > 1 && self.is_small::<L>(bound * bound) {
            return;
        }
        let mut below = L::Mask::splat(true);
        for part in self.parts {
            let numbers = &self.row[part.range()];
            for i in (0..numbers.len()).step_by(L::N) {
                // No NaN is less than anything.
                let x = L::load_up_to(&numbers[i..]);
                below = below & x.lt(bound) & (-bound).lt(x);
            }
        }
        let verdict = &mut self.watch.verdict;
        let nan = L::lit(f64::NAN);
        L::select(below, L::load(verdict), nan).store(verdict);
    }
}

impl<R: Real> Look<'_, R> {
    /// Whether all squares of a lane together are below one: then so is each, rounded or not.
    #[inline(always)]
    fn is_small<L: Lane<R>>(&self, square: L) -> bool {
        let mut sums = [L::zero(); 2];
        for part in self.parts {
            let numbers = &self.row[part.range()];
            let pairs = numbers.chunks_exact(2 * L::N);
            let rest = pairs.remainder();
            for pair in pairs {
                let (x, y) = (L::load(pair), L::load(&pair[L::N..]));
                sums = [x.fma(x, sums[0]), y.fma(y, sums[1])];
            }
            for rest in rest.chunks(L::N) {
                let x = L::load_up_to(rest);
                sums[0] = x.fma(x, sums[0]);
            }
        }
        (sums[0] + sums[1]).lt(square).all()
    }
}
