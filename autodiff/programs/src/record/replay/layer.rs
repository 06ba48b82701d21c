//! Computes a network's layers as matrix products during a replay.

use autodiff::Real;
use autodiff::internal::{Cotangents, Product, Strided, Transpose};
use autodiff::simd::Lane;

use super::block::{Block, load, store};
use super::buffers::ReplayBuffers;
use super::plan::ReplayedLayer;

impl<R: Real, L: Lane<R>, const W: usize> ReplayBuffers<R, L, W> {
    /// Copies the own inputs of a layer (those that differ from point to point) to adjacent memory.
    #[inline(always)]
    fn gather_own(&mut self, layer: ReplayedLayer) {
        self.own.make_room(layer.columns * W * L::N);
        for j in 0..layer.columns {
            store(&mut self.own, j, self.values[layer.own.at(j).at()]);
        }
    }

    /// Computes all rows of a layer.
    #[inline(always)]
    pub(super) fn forward_layer(&mut self, layer: ReplayedLayer, shared: &[R]) {
        self.gather_own(layer);
        let (memory, points) = (self, W * L::N);
        memory.rows.make_room(layer.rows * points);
        memory.rows[..layer.rows * points].fill(R::zero());
        let product = Product {
            a: layer.matrix(shared),
            b: &memory.own,
            b_row: points,
            to: &mut memory.rows,
            to_row: points,
            rows: layer.rows,
            depth: layer.columns,
            columns: points,
        };
        product.add();
        for row in 0..layer.rows {
            memory.values[layer.place(row)] = load(&memory.rows, row);
        }
    }

    /// Pulls back the cotangents of all rows of layer `number`. Inputs of the recording, which have places below
    /// `inputs`, get no cotangents.
    #[inline(always)]
    pub(super) fn reverse_layer(
        &mut self,
        (layer, number): (ReplayedLayer, usize),
        shared: &[R],
        inputs: usize,
    ) {
        let (memory, points) = (self, W * L::N);
        let numbers = layer.columns * points;
        memory.rows.make_room(layer.rows * points);
        for row in 0..layer.rows {
            let bar = std::mem::replace(&mut memory.bars[layer.place(row)], [L::zero(); W]);
            store(&mut memory.rows, row, bar);
        }
        memory.gather_own(layer);
        if layer.own.at(layer.columns - 1).at() >= inputs {
            memory.own_bars.make_room(numbers);
            memory.own_bars[..numbers].fill(R::zero());
            let product = Product {
                a: layer.matrix(shared).transposed(),
                b: &memory.rows,
                b_row: points,
                to: &mut memory.own_bars,
                to_row: points,
                rows: layer.columns,
                depth: layer.rows,
                columns: points,
            };
            product.add_chained(Cotangents::B, memory.finite[number]);
            for j in 0..layer.columns {
                let part: Block<L, W> = load(&memory.own_bars, j);
                let bar = &mut memory.bars[layer.own.at(j).at()];
                for w in 0..W {
                    bar[w] += part[w];
                }
            }
        }
        memory.by_point.make_room(numbers);
        R::vectorize(Transpose {
            from: &memory.own,
            from_row: points,
            rows: layer.columns,
            columns: points,
            to: &mut memory.by_point,
            to_row: layer.columns,
        });
        let by_point = Strided::by_rows(&memory.by_point, layer.columns);
        let finite = by_point.all_finite([points, layer.columns]);
        let product = Product {
            a: Strided::by_rows(&memory.rows, points),
            b: &memory.by_point,
            b_row: layer.columns,
            to: &mut memory.gradient[layer.weights..],
            to_row: layer.stride,
            rows: layer.rows,
            depth: points,
            columns: layer.columns,
        };
        product.add_chained(Cotangents::A, finite);
    }
}
