//! The dense layer as one operation, with both orders of its weights.
//!
//! `W x` streams the weights once, and so does `W^T y_bar`; each wants them in another order, so
//! both are kept. The gradient of the weights is gathered over several steps and added as one
//! matrix product: it then touches the gradient's memory once in [`BATCH`] steps.

use super::{Array, Matrix, Operation, padded};
use crate::lanes::{Lane, Vectorized};
use crate::real::Real;

/// Steps whose outer products are added together.
const BATCH: usize = 16;
/// Lanes of rows that are worked on at once: their sums stay in registers.
const PANEL: usize = 4;

/// A matrix in panels of [`PANEL`] lanes of rows; within a panel column after column.
struct Panels<R> {
    entries: Vec<R>,
    rows: usize,
    columns: usize,
}

impl<R: Real> Panels<R> {
    fn zero(rows: usize, columns: usize) -> Self {
        Self {
            entries: vec![R::zero(); padded::<R>(rows) * columns],
            rows,
            columns,
        }
    }

    /// Calls `f(row, column, entry)` for every entry.
    fn each(&mut self, mut f: impl FnMut(usize, usize, &mut R)) {
        let (height, lanes) = (padded::<R>(self.rows), PANEL * padded::<R>(1));
        for first in (0..height).step_by(lanes) {
            let tall = lanes.min(height - first);
            let panel = &mut self.entries[first * self.columns..][..tall * self.columns];
            for (column, part) in panel.chunks_exact_mut(tall).enumerate() {
                for (row, entry) in part.iter_mut().enumerate() {
                    if first + row < self.rows {
                        f(first + row, column, entry);
                    }
                }
            }
        }
    }
}

pub(super) struct Dense<R> {
    matrix: Matrix,
    inputs: Vec<Array>,
    bias: Array,
    output: Array,
    tanh: bool,
    /// `W`, for `W x`.
    weights: Panels<R>,
    /// `W^T`, for `W^T y_bar`.
    transposed: Panels<R>,
    /// The cotangent of `W`.
    weights_bar: Panels<R>,
    /// The last steps' inputs and output cotangents that `weights_bar` still lacks.
    batch: Batch<R>,
    /// The inputs one after the other, and their cotangents.
    packed: Vec<R>,
    packed_bar: Vec<R>,
    y_bar: Vec<R>,
    active: Active,
}

/// Which cotangents are asked for.
struct Active {
    inputs: Vec<bool>,
    weights: bool,
    bias: bool,
}

struct Batch<R> {
    x: Vec<R>,
    y_bar: Vec<R>,
    len: usize,
}

impl<R: Real> Dense<R> {
    pub(super) fn new(
        matrix: Matrix,
        inputs: Vec<Array>,
        [bias, output]: [Array; 2],
        tanh: bool,
    ) -> Self {
        let Matrix { rows, columns, .. } = matrix;
        let (tall, wide) = (padded::<R>(rows), padded::<R>(columns));
        let active = Active {
            inputs: vec![true; inputs.len()],
            weights: true,
            bias: true,
        };
        Self {
            matrix,
            inputs,
            bias,
            output,
            tanh,
            weights: Panels::zero(rows, columns),
            transposed: Panels::zero(columns, rows),
            weights_bar: Panels::zero(rows, columns),
            batch: Batch {
                x: vec![R::zero(); BATCH * columns],
                y_bar: vec![R::zero(); BATCH * tall],
                len: 0,
            },
            packed: vec![R::zero(); wide],
            packed_bar: vec![R::zero(); wide],
            y_bar: vec![R::zero(); tall],
            active,
        }
    }

    fn pack(&mut self, values: &[R]) {
        let mut to = &mut self.packed[..];
        for a in &self.inputs {
            let (part, rest) = to.split_at_mut(a.len);
            part.copy_from_slice(&values[a.start..][..a.len]);
            to = rest;
        }
    }

    fn unpack_bar(&self, bars: &mut [R]) {
        let mut from = &self.packed_bar[..];
        for (a, &active) in self.inputs.iter().zip(&self.active.inputs) {
            let (part, rest) = from.split_at(a.len);
            if active {
                for (bar, &p) in bars[a.start..].iter_mut().zip(part) {
                    *bar += p;
                }
            }
            from = rest;
        }
    }

    /// Notes this step's outer product; adds the batch up when it is full.
    fn note_weights(&mut self) {
        let Batch { x, y_bar, len } = &mut self.batch;
        let (columns, tall) = (self.matrix.columns, self.y_bar.len());
        x[*len * columns..][..columns].copy_from_slice(&self.packed[..columns]);
        y_bar[*len * tall..][..tall].copy_from_slice(&self.y_bar);
        *len += 1;
        if *len == BATCH {
            self.flush();
        }
    }

    fn flush(&mut self) {
        R::vectorize(OuterProducts {
            batch: &self.batch,
            to: &mut self.weights_bar,
        });
        self.batch.len = 0;
    }
}

impl<R: Real> Operation<R> for Dense<R> {
    fn inputs(&self) -> Vec<Array> {
        self.inputs.iter().copied().chain([self.bias]).collect()
    }
    fn outputs(&self) -> Vec<Array> {
        vec![self.output]
    }
    fn reverse_reads(&self) -> Vec<Array> {
        self.inputs.iter().copied().chain([self.output]).collect()
    }
    fn expensive(&self) -> bool {
        true
    }

    fn load(&mut self, parameters: &[&[R]]) {
        let given = parameters[self.matrix.parameter];
        let columns = self.matrix.columns;
        self.weights
            .each(|row, column, entry| *entry = given[row * columns + column]);
        self.transposed
            .each(|column, row, entry| *entry = given[row * columns + column]);
    }

    fn forward(&mut self, values: &mut [R]) {
        self.pack(values);
        let (bias, to) = (self.bias.start, self.output.start);
        values.copy_within(bias..bias + self.output.len, to);
        R::vectorize(Product {
            matrix: &self.weights,
            x: &self.packed,
            y: &mut values[to..],
            tanh: self.tanh,
        });
    }

    fn reverse(&mut self, values: &[R], bars: &mut [R]) {
        let len = self.output.len;
        self.y_bar[..len].copy_from_slice(&bars[self.output.start..][..len]);
        if self.tanh {
            let y = &values[self.output.start..][..len];
            for (bar, &y) in self.y_bar.iter_mut().zip(y) {
                *bar = R::chain((-y).fma(y, R::one()), *bar);
            }
        }
        if self.active.bias {
            for (bar, &y_bar) in bars[self.bias.start..].iter_mut().zip(&self.y_bar[..len]) {
                *bar += y_bar;
            }
        }
        if self.active.weights {
            self.pack(values);
            self.note_weights();
        }
        if self.active.inputs.contains(&true) {
            self.packed_bar.fill(R::zero());
            let (matrix, x, y) = (&self.transposed, &self.y_bar, &mut self.packed_bar);
            R::vectorize(Product {
                matrix,
                x,
                y,
                tanh: false,
            });
            self.unpack_bar(bars);
        }
    }

    fn set_active(&mut self, arrays: &[bool], parameters: &[bool]) {
        self.active = Active {
            inputs: self.inputs.iter().map(|a| arrays[a.id]).collect(),
            weights: parameters[self.matrix.parameter],
            bias: arrays[self.bias.id],
        };
        // A new sweep begins.
        self.weights_bar.entries.fill(R::zero());
        self.batch.len = 0;
    }

    fn matrix_bars(&mut self, parameter_bars: &mut [Vec<R>]) {
        self.flush();
        let (columns, bars) = (
            self.matrix.columns,
            &mut parameter_bars[self.matrix.parameter],
        );
        self.weights_bar
            .each(|row, column, entry| bars[row * columns + column] += *entry);
    }
}

/// `y += A x`, then `tanh` of it where asked. Every entry of `y` is summed in the same order at
/// every lane width: the even columns, the odd ones, then both.
struct Product<'a, R> {
    matrix: &'a Panels<R>,
    x: &'a [R],
    y: &'a mut [R],
    tanh: bool,
}

impl<R: Real> Vectorized<R> for Product<'_, R> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        let Panels {
            entries,
            rows,
            columns,
        } = self.matrix;
        let height = rows.next_multiple_of(L::N);
        let x = &self.x[..*columns];
        for first in (0..height).step_by(PANEL * L::N) {
            let panel = &entries[first * columns..];
            let y = &mut self.y[first..];
            match (height - first) / L::N {
                1 => panel_product::<R, L, 1>(panel, x, y, self.tanh),
                2 => panel_product::<R, L, 2>(panel, x, y, self.tanh),
                3 => panel_product::<R, L, 3>(panel, x, y, self.tanh),
                _ => panel_product::<R, L, PANEL>(panel, x, y, self.tanh),
            }
        }
    }
}

#[inline(always)]
fn panel_product<R: Real, L: Lane<R>, const W: usize>(
    panel: &[R],
    x: &[R],
    y: &mut [R],
    tanh: bool,
) {
    let mut even = [L::zero(); W];
    let mut odd = [L::zero(); W];
    let pairs = x.len() / 2;
    let (body, last) = panel[..x.len() * W * L::N].split_at(pairs * 2 * W * L::N);
    for (weights, x) in body.chunks_exact(2 * W * L::N).zip(x.chunks_exact(2)) {
        let (x0, x1) = (L::splat(x[0]), L::splat(x[1]));
        for w in 0..W {
            even[w] = L::load(&weights[w * L::N..]).fma(x0, even[w]);
            odd[w] = L::load(&weights[(W + w) * L::N..]).fma(x1, odd[w]);
        }
    }
    if x.len() % 2 == 1 {
        let x0 = L::splat(x[x.len() - 1]);
        for w in 0..W {
            even[w] = L::load(&last[w * L::N..]).fma(x0, even[w]);
        }
    }
    for w in 0..W {
        let to = &mut y[w * L::N..];
        let sum = L::load(to) + (even[w] + odd[w]);
        (if tanh { sum.tanh() } else { sum }).store(to);
    }
}

/// `W_bar += sum over the batch of y_bar x^T`.
struct OuterProducts<'a, R> {
    batch: &'a Batch<R>,
    to: &'a mut Panels<R>,
}

impl<R: Real> Vectorized<R> for OuterProducts<'_, R> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        let Panels {
            entries,
            rows,
            columns,
        } = self.to;
        let height = rows.next_multiple_of(L::N);
        for first in (0..height).step_by(PANEL * L::N) {
            let panel = &mut entries[first * *columns..];
            let part = BatchRows {
                batch: self.batch,
                columns: *columns,
                height,
                first,
            };
            match (height - first) / L::N {
                1 => part.add::<L, 1>(panel),
                2 => part.add::<L, 2>(panel),
                3 => part.add::<L, 3>(panel),
                _ => part.add::<L, PANEL>(panel),
            }
        }
    }
}

/// The rows of a batch that belong to one panel.
struct BatchRows<'a, R> {
    batch: &'a Batch<R>,
    columns: usize,
    height: usize,
    first: usize,
}

impl<R: Real> BatchRows<'_, R> {
    #[inline(always)]
    fn add<L: Lane<R>, const W: usize>(&self, panel: &mut [R]) {
        let Batch { x, y_bar, len } = self.batch;
        let mut column = 0;
        // Two columns at once: every load of a cotangent serves both.
        while column + 2 <= self.columns {
            let mut sums = [[L::zero(); W]; 2];
            for s in 0..*len {
                let x = &x[s * self.columns + column..][..2];
                let (x0, x1) = (L::splat(x[0]), L::splat(x[1]));
                let y_bar = &y_bar[s * self.height + self.first..];
                for w in 0..W {
                    let y_bar = L::load(&y_bar[w * L::N..]);
                    sums[0][w] = y_bar.fma(x0, sums[0][w]);
                    sums[1][w] = y_bar.fma(x1, sums[1][w]);
                }
            }
            for sum in sums {
                add_to::<R, L, W>(&mut panel[column * W * L::N..], sum);
                column += 1;
            }
        }
        if column < self.columns {
            let mut sum = [L::zero(); W];
            for s in 0..*len {
                let x0 = L::splat(x[s * self.columns + column]);
                let y_bar = &y_bar[s * self.height + self.first..];
                for w in 0..W {
                    sum[w] = L::load(&y_bar[w * L::N..]).fma(x0, sum[w]);
                }
            }
            add_to::<R, L, W>(&mut panel[column * W * L::N..], sum);
        }
    }
}

#[inline(always)]
fn add_to<R: Real, L: Lane<R>, const W: usize>(to: &mut [R], sum: [L; W]) {
    for w in 0..W {
        let to = &mut to[w * L::N..];
        (L::load(to) + sum[w]).store(to);
    }
}
