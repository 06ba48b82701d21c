//! The last steps of a matrix product: add the bias, apply the activation, and write each row to its position in `y`.

use crate::real::Real;
use crate::simd::Lane;

/// The last steps of a matrix product, and the vector `y` that receives the result.
pub(super) struct Epilogue<'a, R> {
    pub(super) bias: Option<&'a [R]>,
    pub(super) y: &'a mut [R],
    /// For each row of the product, the index of the register of `y` that receives its result. If the list is empty,
    /// row `k` goes to register `k`. Only used if each lane of a register belongs to a different start (initial state).
    pub(super) places: &'a [usize],
    pub(super) tanh: bool,
}

impl<'a, R: Real> Epilogue<'a, R> {
    /// Returns the last steps of a product that is added to `y`, without bias and activation.
    pub(super) fn plain(y: &'a mut [R]) -> Self {
        Self {
            bias: None,
            y,
            places: &[],
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
        self.add(at, at, even);
        if K > 1 {
            // The second register of a pair may lie entirely past the last row, so it is added separately.
            for h in 0..H {
                at[h] += L::N;
            }
            self.add(at, at, odd);
        }
    }

    /// Does the last steps for `N` rows, beginning with row `first`. Each register in `sums` holds the sums of one row,
    /// with one lane per start (initial state). Rows with the index `rows` or more do not exist and are dropped.
    #[inline(always)]
    pub(super) fn add_starts<L: Lane<R>, const N: usize>(
        &mut self,
        first: usize,
        rows: usize,
        sums: [L; N],
    ) {
        let (mut from, mut to) = ([0; N], [self.y.len(); N]);
        for n in 0..N {
            let row = first + n;
            from[n] = row * L::N;
            if row < rows {
                to[n] = self.places.get(row).copied().unwrap_or(row) * L::N;
            }
        }
        self.add(from, to, sums);
    }

    /// Adds `sums` to the bias at positions `from` (or to `y` at positions `to`, if there is no bias) and writes the
    /// result to `y` at positions `to`. Numbers past the end of `bias` or `y` are dropped.
    #[inline(always)]
    fn add<L: Lane<R>, const N: usize>(
        &mut self,
        from: [usize; N],
        to: [usize; N],
        mut sums: [L; N],
    ) {
        // Bias and `tanh` are applied here because the complete sum is still in a register.
        for n in 0..N {
            let before = match self.bias {
                Some(bias) => L::load_up_to(&bias[from[n].min(bias.len())..]),
                None => L::load_up_to(&self.y[to[n].min(self.y.len())..]),
            };
            sums[n] = before + sums[n];
        }
        if self.tanh {
            sums = L::tanh_each(sums);
        }
        for n in 0..N {
            let to = to[n].min(self.y.len());
            sums[n].store_up_to(&mut self.y[to..]);
        }
    }
}
