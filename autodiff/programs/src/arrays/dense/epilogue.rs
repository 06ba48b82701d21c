//! The last steps of a matrix product: add the bias, apply the activation, and write the result to `y`.

use autodiff::Real;
use autodiff::simd::Lane;

/// The last steps of a matrix product, and the vector `y` that receives the result.
pub(super) struct Epilogue<'a, R> {
    pub(super) bias: Option<&'a [R]>,
    pub(super) y: &'a mut [R],
    pub(super) tanh: bool,
}

impl<'a, R: Real> Epilogue<'a, R> {
    /// Returns the last steps of a product that is added to `y`, without bias and activation.
    pub(super) fn plain(y: &'a mut [R]) -> Self {
        Self {
            bias: None,
            y,
            tanh: false,
        }
    }

    /// Does the last steps for the `K` vectors and for `H` registers of rows, beginning with row `first`. `sums` holds
    /// these rows of the matrix product. The results for the `K` vectors are interleaved in the output.
    #[inline(always)]
    pub(super) fn add_rows<L: Lane<R>, const H: usize, const K: usize>(
        &mut self,
        first: usize,
        sums: [[L; K]; H],
    ) {
        let (mut at, mut even, mut odd) = ([0; H], [L::zero(); H], [L::zero(); H]);
        for h in 0..H {
            at[h] = (first + h * L::N) * K;
            [even[h], odd[h]] = match K {
                1 => [sums[h][0], L::zero()],
                _ => sums[h][0].zip(sums[h][K - 1]),
            };
        }
        self.add(at, even);
        if K > 1 {
            // The second register of a pair may lie entirely past the last row, so it is added separately.
            for h in 0..H {
                at[h] += L::N;
            }
            self.add(at, odd);
        }
    }

    /// Does the last steps for `N` rows, beginning with row `first`. Each register in `sums` holds the sums of one row,
    /// with one lane per start (initial state). Rows that do not exist lie past the end of `y` and are dropped.
    #[inline(always)]
    pub(super) fn add_starts<L: Lane<R>, const N: usize>(&mut self, first: usize, sums: [L; N]) {
        let mut at = [0; N];
        for n in 0..N {
            at[n] = (first + n) * L::N;
        }
        self.add(at, sums);
    }

    /// Adds `sums` to the bias (or to `y`, if there is no bias) at positions `at` and writes the result to `y`, at the
    /// same positions. Numbers past the end of `bias` or `y` are dropped.
    #[inline(always)]
    fn add<L: Lane<R>, const N: usize>(&mut self, at: [usize; N], mut sums: [L; N]) {
        // Bias and `tanh` are applied here because the complete sum is still in a register.
        for n in 0..N {
            let before = self.bias.unwrap_or(&*self.y);
            sums[n] = L::load_up_to(&before[at[n].min(before.len())..]) + sums[n];
        }
        if self.tanh {
            sums = L::tanh_each(sums);
        }
        for n in 0..N {
            let at = at[n].min(self.y.len());
            sums[n].store_up_to(&mut self.y[at..]);
        }
    }
}
