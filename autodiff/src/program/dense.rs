//! The dense layer as one operation, with both orders of its weights.
//!
//! `W x` streams the weights once, and so does `W^T y_bar`; each wants them in another order, so
//! both are kept. The gradient of the weights is gathered over several steps and added as one
//! matrix product: it then touches the gradient's memory once in [`BATCH`] steps.

use std::ops::Range;

use super::{Aligned, Array, Matrix, Operation, copy_in, copy_out, joined, lanes};
use crate::lanes::{Lane, Vectorized};
use crate::real::Real;

/// Steps whose outer products are added together.
const BATCH: usize = 16;
/// Lanes of rows that are worked on at once: their sums stay in registers.
const PANEL: usize = 4;

/// A matrix in panels of [`PANEL`] lanes of rows; within a panel column after column.
struct Panels<R> {
    entries: Aligned<R>,
    rows: usize,
    columns: usize,
}

impl<R: Real> Panels<R> {
    fn zero(rows: usize, columns: usize) -> Self {
        Self {
            entries: Aligned::zeros(rows.next_multiple_of(lanes::<R>()) * columns),
            rows,
            columns,
        }
    }

    /// Calls `f(row, column, entry)` for every entry.
    fn each(&mut self, mut f: impl FnMut(usize, usize, &mut R)) {
        let lanes = lanes::<R>();
        let (height, lanes) = (self.rows.next_multiple_of(lanes), PANEL * lanes);
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
    /// Where the inputs lie, neighbours joined. One range is read in place.
    ranges: Vec<Range<usize>>,
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
    /// Inputs of several ranges one after the other, or their cotangents.
    packed: Vec<R>,
    /// The cotangent of `W x`.
    y_bar: Aligned<R>,
    active: Active,
}

/// Which cotangents are asked for.
struct Active {
    inputs: bool,
    weights: bool,
    bias: bool,
}

struct Batch<R> {
    x: Vec<R>,
    /// In whole lanes.
    y_bar: Aligned<R>,
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
        let tall = rows.next_multiple_of(lanes::<R>());
        Self {
            ranges: joined(inputs.iter().copied()),
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
                y_bar: Aligned::zeros(BATCH * tall),
                len: 0,
            },
            packed: Vec::with_capacity(columns),
            y_bar: Aligned::zeros(tall),
            active: Active {
                inputs: true,
                weights: true,
                bias: true,
            },
        }
    }

    /// The inputs in one slice: where they lie, or packed.
    fn x<'a>(ranges: &[Range<usize>], packed: &'a mut Vec<R>, values: &'a [R]) -> &'a [R] {
        if let [range] = ranges {
            return &values[range.clone()];
        }
        packed.clear();
        copy_out(ranges, values, packed);
        packed
    }

    /// Adds `W^T y_bar` to the cotangents of the inputs.
    fn reverse_inputs(&mut self, bars: &mut [R]) {
        let (matrix, x) = (&self.transposed, &self.y_bar[..self.matrix.rows]);
        if let [range] = &self.ranges[..] {
            let y = &mut bars[range.clone()];
            return R::vectorize(Product {
                matrix,
                x,
                start: None,
                y,
                tanh: false,
            });
        }
        self.packed.clear();
        copy_out(&self.ranges, bars, &mut self.packed);
        R::vectorize(Product {
            matrix,
            x,
            start: None,
            y: &mut self.packed,
            tanh: false,
        });
        copy_in(&self.ranges, bars, &self.packed);
    }

    /// Notes this step's outer product; adds the batch up when it is full.
    fn reverse_weights(&mut self, values: &[R]) {
        let x = Self::x(&self.ranges, &mut self.packed, values);
        let Batch {
            x: all_x,
            y_bar: all_y_bar,
            len,
        } = &mut self.batch;
        all_x[*len * x.len()..][..x.len()].copy_from_slice(x);
        all_y_bar[*len * self.y_bar.len()..][..self.y_bar.len()].copy_from_slice(&self.y_bar);
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
        // The output was declared after everything it is computed from.
        let (before, output) = values.split_at_mut(self.output.start);
        R::vectorize(Product {
            matrix: &self.weights,
            x: Self::x(&self.ranges, &mut self.packed, before),
            start: Some(&before[self.bias.range()]),
            y: &mut output[..self.output.len],
            tanh: self.tanh,
        });
    }

    fn reverse(&mut self, values: &[R], bars: &mut [R]) {
        let (before, output) = bars.split_at_mut(self.output.start);
        R::vectorize(Incoming {
            y: &values[self.output.range()],
            bar: &output[..self.output.len],
            tanh: self.tanh,
            y_bar: &mut self.y_bar[..self.output.len],
            bias_bar: self.active.bias.then(|| &mut before[self.bias.range()]),
        });
        if self.active.weights {
            self.reverse_weights(values);
        }
        if self.active.inputs {
            self.reverse_inputs(bars);
        }
    }

    fn set_active(&mut self, arrays: &[bool], parameters: &[bool]) {
        self.active = Active {
            inputs: self.inputs.iter().any(|a| arrays[a.id]),
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

/// The cotangent of `W x` from that of the output, added to the bias's.
struct Incoming<'a, R> {
    y: &'a [R],
    bar: &'a [R],
    tanh: bool,
    y_bar: &'a mut [R],
    bias_bar: Option<&'a mut [R]>,
}

impl<R: Real> Vectorized<R> for Incoming<'_, R> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(mut self) {
        for i in (0..self.y.len()).step_by(L::N) {
            let (y, mut bar) = (L::load_up_to(&self.y[i..]), L::load_up_to(&self.bar[i..]));
            if self.tanh {
                bar = L::chain((-y).fma(y, L::one()), bar);
            }
            bar.store_up_to(&mut self.y_bar[i..]);
            if let Some(bias_bar) = &mut self.bias_bar {
                let to = &mut bias_bar[i..];
                (L::load_up_to(to) + bar).store_up_to(to);
            }
        }
    }
}

/// `y = start + A x`, or `y += A x` without a start; then `tanh` of it where asked. Every entry
/// of `y` is summed in the same order at every lane width: the even columns, the odd ones, both.
struct Product<'a, R> {
    matrix: &'a Panels<R>,
    x: &'a [R],
    start: Option<&'a [R]>,
    y: &'a mut [R],
    tanh: bool,
}

impl<R: Real> Vectorized<R> for Product<'_, R> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(mut self) {
        let height = self.matrix.rows.next_multiple_of(L::N);
        for first in (0..height).step_by(PANEL * L::N) {
            match (height - first) / L::N {
                1 => self.panel::<L, 1>(first),
                2 => self.panel::<L, 2>(first),
                3 => self.panel::<L, 3>(first),
                _ => self.panel::<L, PANEL>(first),
            }
        }
    }
}

impl<R: Real> Product<'_, R> {
    /// `W` lanes of rows.
    #[inline(always)]
    fn panel<L: Lane<R>, const W: usize>(&mut self, first: usize) {
        let Panels {
            entries, columns, ..
        } = self.matrix;
        let x = &self.x[..*columns];
        let mut even = [L::zero(); W];
        let mut odd = [L::zero(); W];
        let panel = &entries[first * columns..][..columns * W * L::N];
        let (body, last) = panel.split_at(columns / 2 * 2 * W * L::N);
        for (weights, x) in body.chunks_exact(2 * W * L::N).zip(x.chunks_exact(2)) {
            let (x0, x1) = (L::splat(x[0]), L::splat(x[1]));
            for w in 0..W {
                even[w] = L::load(&weights[w * L::N..]).fma(x0, even[w]);
                odd[w] = L::load(&weights[(W + w) * L::N..]).fma(x1, odd[w]);
            }
        }
        if columns % 2 == 1 {
            let x0 = L::splat(x[columns - 1]);
            for w in 0..W {
                even[w] = L::load(&last[w * L::N..]).fma(x0, even[w]);
            }
        }
        for w in 0..W {
            let row = first + w * L::N;
            let start = match self.start {
                Some(start) => L::load_up_to(&start[row..]),
                None => L::load_up_to(&self.y[row..]),
            };
            let sum = start + (even[w] + odd[w]);
            (if self.tanh { sum.tanh() } else { sum }).store_up_to(&mut self.y[row..]);
        }
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
