//! A matrix in panels of as many rows as registers have room to sum, and its product with a vector.

use std::ops::RangeInclusive;

use super::aligned::Aligned;
use super::epilogue::Epilogue;
use crate::real::Real;
use crate::simd::{Lane, lanes};

/// The most registers of rows that are worked on at once: their sums stay in registers.
pub(super) const PANEL: usize = 4;
/// Independent sums per row: phase `p` sums the columns `p`, `p + 4`, `p + 8`, …, so that consecutive
/// additions do not wait for one another.
pub(super) const PHASES: usize = 4;
/// Registers of weights in a chunk, the columns of a panel that one turn of the loop takes.
const CHUNK: usize = PANEL * PHASES;
/// Chunks in a page. With the widest registers that is 4096 bytes, and numbers one page apart fall into
/// the same set of the first-level cache (L1). The last chunk of every page is a far one.
const PAGE: usize = 4;
/// The share of near chunks is given in parts of this.
const SHARES: usize = 64;
/// Bytes of near chunks, which stay in L1: six of twelve ways in three quarters of its sets. Half of
/// it is left for a step's other numbers and for the far chunks. The best of 14 to 24 kB on Zen 5, and
/// in a simulation of the cache.
const NEAR: usize = 18 << 10;
/// How many bytes of matrices are divided into near and far: fewer stay in L1 as they are, and of more
/// too small a part could.
const PARTED: RangeInclusive<usize> = 36 << 10..=128 << 10;

/// A matrix in panels, each a few registers of rows high; within a panel column after column.
///
/// The matrices of a network do not fit into L1 together, and under a least-recently-used policy data
/// that are read cyclically evict exactly what is read next. So the cache is divided by address: some
/// chunks are near, in sets where nothing evicts them, and the others pass through the remaining sets.
/// Near and far ones alternate, so that the far ones arrive from L2 while the near ones are worked on.
/// That saves a tenth of a rollout's time: `cosmic explain --measure`.
pub(super) struct Panels<R> {
    entries: Aligned<R>,
    pub(super) rows: usize,
    pub(super) columns: usize,
    pub(super) panels: Vec<Panel>,
}

/// A few registers of rows.
#[derive(Clone, Copy)]
pub(super) struct Panel {
    pub(super) first_row: usize,
    /// How many registers, at most [`PANEL`].
    pub(super) lanes: usize,
    places: ChunkPlaces,
}

/// How many columns a chunk has in a panel of this many registers: a multiple of the phases. With three
/// registers a part of the chunk is left unused.
const fn columns_of_chunk(lanes: usize) -> usize {
    PANEL / lanes * PHASES
}

/// Where a column begins in a panel of this many registers whose chunks are adjacent, in registers.
#[inline(always)]
pub(super) const fn lane_of_column(column: usize, lanes: usize) -> usize {
    let columns = columns_of_chunk(lanes);
    column / columns * CHUNK + column % columns * lanes
}

/// Where the chunks of a panel begin, counted in chunks, from one to the next. Computed, not looked up:
/// one more load for each would cost a tenth of a product.
#[derive(Clone, Copy)]
struct ChunkPlaces {
    /// How many of [`SHARES`] chunks are near; if all are, they are adjacent.
    share: usize,
    /// Grows by the share with each chunk; when it reaches [`SHARES`], a near chunk is due.
    credit: usize,
    /// Places of the next near chunk and of the next far one.
    near: usize,
    far: usize,
}

impl ChunkPlaces {
    /// From a matrix's first chunk on.
    fn new(share: usize) -> Self {
        Self {
            share,
            credit: 0,
            near: 0,
            far: PAGE - 1,
        }
    }

    #[inline(always)]
    fn next(&mut self) -> usize {
        // Bresenham's rule: every chunk adds to the credit, and a near one is due when it is full.
        self.credit += self.share;
        if self.credit < SHARES {
            self.far += PAGE;
            return self.far - PAGE;
        }
        self.credit -= SHARES;
        // The last place of a page is for far chunks: skip it.
        let place = self.near;
        let turns = self.share < SHARES && place % PAGE == PAGE - 2;
        self.near += 1 + usize::from(turns);
        place
    }
}

impl<R: Real> Panels<R> {
    /// Zeros, in adjacent chunks.
    pub(super) fn zero(rows: usize, columns: usize) -> Self {
        Self::new(rows, columns, SHARES)
    }

    /// Zeros, for a matrix whose products alternate with other matrices' products. `numbers` counts the
    /// entries of all of them.
    pub(super) fn taking_turns(numbers: usize, rows: usize, columns: usize) -> Self {
        let bytes = numbers * size_of::<R>();
        let parted = PARTED.contains(&bytes);
        let share = if parted {
            SHARES * NEAR / bytes
        } else {
            SHARES
        };
        Self::new(rows, columns, share)
    }

    fn new(rows: usize, columns: usize, share: usize) -> Self {
        let (mut panels, mut places, mut end) = (Vec::new(), ChunkPlaces::new(share), 0);
        let lanes_of_rows = rows.div_ceil(lanes::<R>());
        for first in (0..lanes_of_rows).step_by(PANEL) {
            let lanes_here = (lanes_of_rows - first).min(PANEL);
            panels.push(Panel {
                first_row: first * lanes::<R>(),
                lanes: lanes_here,
                places,
            });
            for _ in 0..columns.div_ceil(columns_of_chunk(lanes_here)) {
                end = end.max(places.next() + 1);
            }
        }
        Self {
            entries: Aligned::to_pages(end * CHUNK * lanes::<R>()),
            rows,
            columns,
            panels,
        }
    }

    pub(super) fn fill_zero(&mut self) {
        self.entries.fill(R::zero());
    }

    /// The entries of a panel, column after column, if its chunks are adjacent.
    #[inline(always)]
    pub(super) fn panel_mut<L: Lane<R>>(&mut self, panel: Panel) -> &mut [R] {
        debug_assert_eq!(panel.places.share, SHARES);
        &mut self.entries[panel.places.near * CHUNK * L::N..]
    }

    /// Calls `f(row, column, entries)` for stretches of columns that cover the matrix: `entries` are those
    /// of the column from that row on.
    pub(super) fn each(&mut self, mut f: impl FnMut(usize, usize, &mut [R])) {
        let width = lanes::<R>();
        for mut panel in self.panels.iter().copied() {
            let rows = (self.rows - panel.first_row).min(width * panel.lanes);
            let columns = columns_of_chunk(panel.lanes);
            for first in (0..self.columns).step_by(columns) {
                let chunk = &mut self.entries[panel.places.next() * CHUNK * width..];
                let parts = chunk.chunks_exact_mut(panel.lanes * width).take(columns);
                for (column, part) in (first..self.columns).zip(parts) {
                    f(panel.first_row, column, &mut part[..rows]);
                }
            }
        }
    }

    /// Gives `A x` to the output, for `K` interleaved vectors, one or two. The order of summation does not
    /// depend on the width of registers: each phase by itself, then the four sums.
    #[inline(always)]
    pub(super) fn times<L: Lane<R>, const K: usize>(&self, x: &[R], output: &mut Epilogue<R>) {
        // A constant condition: of the two branches only the one that is taken is compiled.
        if const { L::N == 1 && size_of::<L>() > size_of::<f64>() } {
            return self.times_rolled::<L>(x, output);
        }
        for &panel in &self.panels {
            match (panel.lanes, K) {
                (1, _) => self.part::<L, 1, 1, K>(panel, 0, x, output),
                (2, _) => self.part::<L, 2, 2, K>(panel, 0, x, output),
                (3, 1) => self.part::<L, 3, 3, K>(panel, 0, x, output),
                (_, 1) if cfg!(lanes = "simd128") => {
                    // Engines of WebAssembly have sixteen registers, of which factors and products need some.
                    let low = self.sums::<L, PANEL, 2, K>(panel, 0, x);
                    let high = self.sums::<L, PANEL, 2, K>(panel, 2, x);
                    output.add_rows(panel.first_row, [low[0], low[1], high[0], high[1]]);
                }
                (_, 1) => self.part::<L, PANEL, PANEL, K>(panel, 0, x, output),
                // With two vectors the registers hold the sums of half as many rows.
                (3, _) => {
                    self.part::<L, 3, 2, K>(panel, 0, x, output);
                    self.part::<L, 3, 1, K>(panel, 2, x, output);
                }
                (_, _) => {
                    self.part::<L, PANEL, 2, K>(panel, 0, x, output);
                    self.part::<L, PANEL, 2, K>(panel, 2, x, output);
                }
            }
        }
    }

    /// [`times`](Self::times) for numbers too large for a register: duals, variables, double-doubles.
    /// Unrolling the loops for each of these types, as for registers, does not make them faster, and
    /// was a quarter of the time it took to compile a program with a network.
    fn times_rolled<L: Lane<R>>(&self, x: &[R], output: &mut Epilogue<R>) {
        for panel in &self.panels {
            let (mut sums, mut places) = ([[L::zero(); PANEL]; PHASES], panel.places);
            for x in x.chunks(columns_of_chunk(panel.lanes)) {
                let weights = &self.entries[places.next() * CHUNK..][..CHUNK];
                let weights = weights.chunks_exact(panel.lanes);
                for (column, (&x, weights)) in x.iter().zip(weights).enumerate() {
                    for (sum, &weight) in sums[column % PHASES].iter_mut().zip(weights) {
                        *sum = L::splat(weight).fma(L::splat(x), *sum);
                    }
                }
            }
            for h in 0..panel.lanes {
                let all = (sums[0][h] + sums[1][h]) + (sums[2][h] + sums[3][h]);
                output.add_rows(panel.first_row + h, [[all]]);
            }
        }
    }

    /// The product of `H` registers of rows, from the register `from` on, in a panel of `W` of them.
    #[inline(always)]
    fn part<L: Lane<R>, const W: usize, const H: usize, const K: usize>(
        &self,
        panel: Panel,
        from: usize,
        x: &[R],
        output: &mut Epilogue<R>,
    ) {
        let all = self.sums::<L, W, H, K>(panel, from, x);
        output.add_rows(panel.first_row + from * L::N, all);
    }

    #[inline(always)]
    fn sums<L: Lane<R>, const W: usize, const H: usize, const K: usize>(
        &self,
        panel: Panel,
        from: usize,
        x: &[R],
    ) -> [[L; K]; H] {
        // All sums stay in registers from the first column to the last.
        let mut sums = [[[L::zero(); K]; H]; PHASES];
        let chunks = x[..self.columns * K].chunks_exact(const { columns_of_chunk(W) * K });
        let (mut places, rest) = (panel.places, chunks.remainder());
        for x in chunks {
            self.add_chunk::<L, W, H, K>(places.next(), from, x, &mut sums);
        }
        if !rest.is_empty() {
            self.add_chunk::<L, W, H, K>(places.next(), from, rest, &mut sums);
        }
        let mut all = [[L::zero(); K]; H];
        for h in 0..H {
            for k in 0..K {
                all[h][k] = (sums[0][h][k] + sums[1][h][k]) + (sums[2][h][k] + sums[3][h][k]);
            }
        }
        all
    }

    /// Adds the columns of a chunk, as many as `x` has numbers for.
    #[inline(always)]
    fn add_chunk<L: Lane<R>, const W: usize, const H: usize, const K: usize>(
        &self,
        place: usize,
        from: usize,
        x: &[R],
        sums: &mut [[[L; K]; H]; PHASES],
    ) {
        let weights = &self.entries[place * CHUNK * L::N..][..CHUNK * L::N];
        for group in 0..const { columns_of_chunk(W) / PHASES } {
            for phase in 0..PHASES {
                let column = group * PHASES + phase;
                // The last chunk may have fewer columns.
                if column * K >= x.len() {
                    return;
                }
                // One number of `x` in all lanes, times a column of weights.
                let mut of_vectors = [L::zero(); K];
                for k in 0..K {
                    of_vectors[k] = L::splat(x[column * K + k]);
                }
                for h in 0..H {
                    let weights = L::load(&weights[(column * W + from + h) * L::N..]);
                    for k in 0..K {
                        sums[phase][h][k] = weights.fma(of_vectors[k], sums[phase][h][k]);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::epilogue::Epilogue;
    use super::super::product::{MatrixProduct, PackedMatrix};
    use super::{CHUNK, ChunkPlaces, PAGE, Panels, SHARES};
    use crate::simd::{Level, at_most, lanes, level};

    #[test]
    fn chunks_have_places_of_their_own() {
        for share in [1, 24, 34, 63] {
            let mut next = ChunkPlaces::new(share);
            let mut places: Vec<usize> = (0..200).map(|_| next.next()).collect();
            let is_near = |place: &&usize| **place % PAGE < PAGE - 1;
            // As many of them as asked for, from the first page on without a gap.
            let nears = 200 * share / SHARES;
            assert_eq!(places.iter().filter(is_near).count(), nears);
            let last = places.iter().filter(is_near).max();
            assert!(last.is_none_or(|&last| last < nears.div_ceil(PAGE - 1) * PAGE));
            places.sort_unstable();
            places.dedup();
            assert_eq!(places.len(), 200);
        }
        let mut all = ChunkPlaces::new(SHARES);
        assert!((0..200).all(|chunk| all.next() == chunk));
    }

    /// `0.5 + A x` of interleaved vectors, with numbers of a few digits, so that every sum is exact.
    fn product(share: usize, (rows, columns): (usize, usize), vectors: usize) -> Vec<f64> {
        let mut panels = Panels::<f64>::new(rows, columns, share);
        let mut seen = 0;
        panels.each(|first, column, entries| {
            for (row, entry) in (first..).zip(&mut *entries) {
                *entry = entry_at(row, column);
            }
            seen += entries.len();
        });
        assert_eq!(seen, rows * columns);
        assert!(panels.entries.len() >= CHUNK);
        let matrix = match vectors {
            1 => PackedMatrix::One(panels),
            _ => PackedMatrix::Two(panels),
        };
        let side_by_side = |column| (0..vectors).map(move |k| x_at(column, k));
        let x: Vec<f64> = (0..columns).flat_map(side_by_side).collect();
        let (bias, mut y) = (vec![0.5; rows * vectors], vec![0.0; rows * vectors]);
        let output = Epilogue {
            bias: Some(&bias),
            y: &mut y,
            places: &[],
            tanh: false,
        };
        let product = MatrixProduct {
            matrix: &matrix,
            x: &x,
            output,
        };
        product.run();
        y
    }

    fn entry_at(row: usize, column: usize) -> f64 {
        (row * 7 % 11) as f64 - (column * 5 % 13) as f64
    }

    fn x_at(column: usize, vector: usize) -> f64 {
        (column * (3 + vector) % 7) as f64 - 2.0
    }

    #[test]
    fn products_are_those_of_rows_wherever_chunks_lie() {
        for shape in [(1, 1), (3, 5), (32, 144), (110, 32), (13, 17), (27, 31)] {
            for (share, vectors) in [(1, 1), (24, 1), (40, 2), (SHARES, 1), (SHARES, 2)] {
                let sum = |row: usize, k: usize| {
                    let products = (0..shape.1).map(|c| entry_at(row, c) * x_at(c, k));
                    0.5 + products.sum::<f64>()
                };
                let side_by_side = |row| (0..vectors).map(move |k| sum(row, k));
                let expected: Vec<f64> = (0..shape.0).flat_map(side_by_side).collect();
                for cap in [Level::Baseline, Level::Avx2, level()] {
                    // One lane has no room for two.
                    if vectors > at_most(cap, lanes::<f64>) {
                        continue;
                    }
                    let given = at_most(cap, || product(share, shape, vectors));
                    assert_eq!(given, expected, "{shape:?} {share} {vectors} {cap:?}");
                }
            }
        }
    }
}
