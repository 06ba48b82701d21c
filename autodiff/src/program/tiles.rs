//! A matrix in tiles of rows, and its product with the vectors of several starts.
//!
//! The lanes are starts: every weight serves all of them once it is read.

use super::Aligned;
use super::panels::PHASES;
use super::product::Output;
use crate::lanes::Lane;
use crate::real::Real;

/// Rows that are worked on at once.
const TILE: usize = 16;
/// Rows of which results are made at once; more need more registers than they save time.
const ABREAST: usize = 4;

/// A matrix in tiles of some rows; within a tile the columns of one phase after the other.
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

    /// Calls `f(row, column, entries)` for all entries, in stretches of a column from some row on.
    pub(super) fn each(&mut self, mut f: impl FnMut(usize, usize, &mut [R])) {
        let tiles = self.entries.chunks_exact_mut(TILE * self.columns.max(1));
        for (first, tile) in (0..self.rows).step_by(TILE).zip(tiles) {
            let order = (0..PHASES).flat_map(|phase| (phase..self.columns).step_by(PHASES));
            for (column, part) in order.zip(tile.chunks_exact_mut(TILE)) {
                f(first, column, &mut part[..TILE.min(self.rows - first)]);
            }
        }
    }

    /// Gives `A x` to the output: each sum has the order that it has in
    /// [`Panels`](super::panels::Panels).
    #[inline(always)]
    pub(super) fn times<L: Lane<R>>(&self, x: &[R], output: &mut Output<R>) {
        for first in (0..self.rows).step_by(TILE) {
            let phase = |phase| self.phase::<L>(x, (first, phase));
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
                output.add_starts((first + k * ABREAST, self.rows), *sums);
            }
        }
    }

    /// The sums of every fourth column. One phase at a time, as the registers hold more rows that
    /// way: what is read for a multiplication is then little more than its weight.
    #[inline(always)]
    fn phase<L: Lane<R>>(&self, x: &[R], (first, phase): (usize, usize)) -> [L; TILE] {
        let columns = self.columns;
        let before = (0..phase).map(|p| columns.saturating_sub(p).div_ceil(PHASES));
        let place = first * columns + before.sum::<usize>() * TILE;
        let count = columns.saturating_sub(phase).div_ceil(PHASES);
        let weights = self.entries[place..][..count * TILE].chunks_exact(TILE);
        let x = x[(phase * L::N).min(x.len())..].chunks(PHASES * L::N);
        let mut sums = [L::zero(); TILE];
        for (weights, x) in weights.zip(x) {
            let x = L::load(x);
            for row in 0..TILE {
                sums[row] = L::splat(weights[row]).fma(x, sums[row]);
            }
        }
        sums
    }
}
