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
/// The most lanes of rows that are worked on at once: their sums stay in registers.
const PANEL: usize = 4;
/// Columns that are summed up apart, so that no sum waits for the one before.
const PHASES: usize = 4;

/// A matrix in panels of some lanes of rows; within a panel column after column.
///
/// Two matrices of a controller do not fit the first cache together. So they are read in panels
/// forth and back in turns: what the last product read at its end is what the next one reads
/// first. That a sixth of a rollout's time is saved says `cosmic explain --measure`.
struct Panels<R> {
    entries: Aligned<R>,
    rows: usize,
    columns: usize,
    /// Lanes of rows in a panel; the last one may have fewer.
    tall: usize,
    /// Whether the next product begins at the end.
    back: bool,
}

impl<R: Real> Panels<R> {
    fn zero(rows: usize, columns: usize) -> Self {
        let lanes_of_rows = rows.div_ceil(lanes::<R>());
        Self {
            entries: Aligned::zeros(lanes_of_rows * lanes::<R>() * columns),
            rows,
            columns,
            // Two panels at least, or there is nothing to turn round.
            tall: lanes_of_rows.div_ceil(2).min(PANEL),
            back: false,
        }
    }

    /// Calls `f(row, column, entry)` for every entry.
    fn each(&mut self, mut f: impl FnMut(usize, usize, &mut R)) {
        let lanes = lanes::<R>();
        let (height, lanes) = (self.rows.next_multiple_of(lanes), self.tall * lanes);
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
        self.transposed.back ^= true;
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
        self.weights.back ^= true;
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
/// of `y` is summed in the same order at every lane width: every fourth column, then those sums.
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
        let height = self.matrix.rows.div_ceil(L::N);
        let tall = self.matrix.tall;
        let panels = height.div_ceil(tall);
        for panel in 0..panels {
            let first = tall * if self.matrix.back { panels - 1 - panel } else { panel };
            match tall.min(height - first) {
                1 => self.panel::<L, 1>(first * L::N),
                2 => self.panel::<L, 2>(first * L::N),
                3 => self.panel::<L, 3>(first * L::N),
                _ => self.panel::<L, PANEL>(first * L::N),
            }
        }
    }
}

impl<R: Real> Product<'_, R> {
    /// `W` lanes of rows.
    #[inline(always)]
    fn panel<L: Lane<R>, const W: usize>(&mut self, first: usize) {
        let columns = self.matrix.columns;
        let x = &self.x[..columns];
        let mut sums = [[L::zero(); W]; PHASES];
        let panel = &self.matrix.entries[first * columns..][..columns * W * L::N];
        let whole = columns / PHASES * PHASES;
        let (body, rest) = panel.split_at(whole * W * L::N);
        let columns = body.chunks_exact(PHASES * W * L::N);
        for (weights, x) in columns.zip(x.chunks_exact(PHASES)) {
            for phase in 0..PHASES {
                let x = L::splat(x[phase]);
                for w in 0..W {
                    let weights = L::load(&weights[(phase * W + w) * L::N..]);
                    sums[phase][w] = weights.fma(x, sums[phase][w]);
                }
            }
        }
        let columns = rest.chunks_exact(W * L::N);
        for ((weights, &x), sums) in columns.zip(&x[whole..]).zip(&mut sums) {
            for w in 0..W {
                sums[w] = L::load(&weights[w * L::N..]).fma(L::splat(x), sums[w]);
            }
        }
        for w in 0..W {
            let row = first + w * L::N;
            let start = match self.start {
                Some(start) => L::load_up_to(&start[row..]),
                None => L::load_up_to(&self.y[row..]),
            };
            let sum = start + ((sums[0][w] + sums[1][w]) + (sums[2][w] + sums[3][w]));
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
            tall,
            ..
        } = self.to;
        let height = rows.next_multiple_of(L::N);
        for first in (0..height).step_by(*tall * L::N) {
            let panel = &mut entries[first * *columns..];
            let part = BatchRows {
                batch: self.batch,
                columns: *columns,
                height,
                first,
            };
            match (*tall).min((height - first) / L::N) {
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
