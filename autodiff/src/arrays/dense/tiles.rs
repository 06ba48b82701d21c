//! A matrix in tiles of rows, and its product with the interleaved vectors of a register of starts.
//!
//! Each lane is a start: a weight that has been read serves all of them.

use super::aligned::Aligned;
use super::epilogue::Epilogue;
use super::panels::PHASES;
use crate::product::{Factors, Strided};
use crate::real::Real;
use crate::simd::Lane;

/// Rows that are worked on at once: their sums stay in registers. Engines of WebAssembly have sixteen, of
/// which factors and products need some.
const TILE: usize = if cfg!(lanes = "simd128") { 8 } else { 16 };
/// Rows whose results are finished at once; more would need too many registers.
const ABREAST: usize = 4;

/// A matrix in tiles of [`TILE`] rows; within a tile the columns are ordered phase by phase, see
/// [`PHASES`].
pub(super) struct Tiles<R> {
    entries: Aligned<R>,
    rows: usize,
    columns: usize,
}

impl<R: Real> Tiles<R> {
    pub(super) fn zero(rows: usize, columns: usize) -> Self {
        Self {
            entries: Aligned::zeros(rows.next_multiple_of(TILE) * columns),
            rows,
            columns,
        }
    }

    /// See [`Panels::each`](super::panels::Panels::each).
    pub(super) fn each(&mut self, mut f: impl FnMut(usize, usize, &mut [R])) {
        let tiles = self.entries.chunks_exact_mut(TILE * self.columns.max(1));
        for (first, tile) in (0..self.rows).step_by(TILE).zip(tiles) {
            let order = (0..PHASES).flat_map(|phase| (phase..self.columns).step_by(PHASES));
            for (column, part) in order.zip(tile.chunks_exact_mut(TILE)) {
                f(first, column, &mut part[..TILE.min(self.rows - first)]);
            }
        }
    }

    /// Gives `A x` to the output, summed in the order of [`Panels`](super::panels::Panels::times): each
    /// start has the bits that it has alone.
    #[inline(always)]
    pub(super) fn times<L: Lane<R>>(&self, x: &[R], output: &mut Epilogue<R>) {
        assert!(
            x.len() >= self.columns * L::N,
            "a column has no register of starts"
        );
        for first in (0..self.rows).step_by(TILE) {
            // Two phases at a time, in the order (0 + 1) + (2 + 3), which panels have too.
            let phase = |phase| self.phase::<L>(x, first, phase);
            let (mut sums, more) = (phase(0), phase(1));
            for row in 0..TILE {
                sums[row] += more[row];
            }
            let (third, last) = (phase(2), phase(3));
            for row in 0..TILE {
                sums[row] += third[row] + last[row];
            }
            let (groups, _) = sums.as_chunks::<ABREAST>();
            for (k, sums) in groups.iter().enumerate() {
                output.add_starts(first + k * ABREAST, self.rows, *sums);
            }
        }
    }

    /// The sums of one phase over a tile. One phase at a time, because then the registers hold the sums of
    /// more rows, and each load of `x` serves more multiplications.
    #[inline(always)]
    fn phase<L: Lane<R>>(&self, x: &[R], first: usize, phase: usize) -> [L; TILE] {
        let columns = self.columns;
        let before = (0..phase).map(|p| columns.saturating_sub(p).div_ceil(PHASES));
        let place = first * columns + before.sum::<usize>() * TILE;
        let count = columns.saturating_sub(phase).div_ceil(PHASES);
        let factors = Factors {
            a: Strided {
                numbers: &self.entries[place..][..count * TILE],
                row: 1,
                column: TILE,
            },
            b: &x[(phase * L::N).min(x.len())..],
            b_row: PHASES * L::N,
            depth: count,
        };
        // SAFETY: the tile has so many numbers, and `x` a register for every column.
        #[allow(unsafe_code)]
        let [sums] = unsafe { factors.sums::<L, 1, TILE, 1>(L::N) };
        sums.map(|[sum]| sum)
    }
}
