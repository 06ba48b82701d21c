//! The dense layer as one operation, with both orders of its weights.
//!
//! `W x` streams the weights once, and so does `W^T y_bar`; each wants them in another order, so
//! both are kept.

use super::panels::{Batch, OuterProducts, Panels, Product};
use super::row::{Frame, joined};
use super::{Aligned, Array, Bars, Matrix, Operation, lanes};
use crate::lanes::{Lane, Vectorized};
use crate::real::Real;

pub(super) struct Dense<R> {
    matrix: Matrix,
    /// The inputs, neighbours joined. A single stretch is read in place.
    inputs: Vec<Array>,
    inputs_active: Vec<usize>,
    bias: Array,
    output: Array,
    /// Where the output is not just the rows in their order.
    spread: Option<Spread<R>>,
    tanh: bool,
    /// `W`, for `W x`.
    weights: Panels<R>,
    /// `W^T`, for `W^T y_bar`.
    transposed: Panels<R>,
    /// The cotangent of `W`.
    weights_bar: Panels<R>,
    /// The last steps' inputs and output cotangents that `weights_bar` still lacks.
    batch: Batch<R>,
    /// Inputs of several stretches one after the other, or their cotangents.
    packed: Vec<R>,
    active: Active,
}

/// An output in which the rows are set out among zeros.
struct Spread<R> {
    /// For each lane of the output, which of its places have a row.
    bits: Vec<u16>,
    /// The rows' values, and the cotangents of what `tanh` is taken of, at the rows' places in
    /// the output. With room for a lane past the last.
    y: Aligned<R>,
    bar: Aligned<R>,
}

/// Which cotangents are asked for.
struct Active {
    inputs: bool,
    weights: bool,
    bias: bool,
}

impl<R: Real> Spread<R> {
    /// `None` where there are no gaps.
    fn new(places: &[bool]) -> Option<Self> {
        let bits = |places: &[bool]| {
            let set = places.iter().rev();
            set.fold(0, |bits, &row| bits << 1 | u16::from(row))
        };
        let lanes = lanes::<R>();
        let rows = places.iter().filter(|row| **row).count();
        (rows < places.len()).then(|| Self {
            bits: places.chunks(lanes).map(bits).collect(),
            y: Aligned::zeros(rows + 2 * lanes),
            bar: Aligned::zeros(places.len() + lanes),
        })
    }
}

impl<R: Real> Dense<R> {
    pub(super) fn new(
        (matrix, bias): (Matrix, Array),
        x: &[Array],
        (output, places): (Array, &[bool]),
        tanh: bool,
    ) -> Self {
        let (columns, starts) = (matrix.columns, output.starts);
        Self {
            inputs: joined(x),
            inputs_active: x.iter().map(|a| a.id).collect(),
            spread: Spread::new(places),
            matrix,
            bias,
            output,
            tanh,
            weights: Panels::for_starts(starts, matrix.rows, columns),
            transposed: Panels::for_starts(starts, columns, matrix.rows),
            weights_bar: Panels::zero(matrix.rows, columns),
            batch: Batch::new(starts, matrix.rows, columns),
            packed: Vec::with_capacity(columns * starts),
            active: Active {
                inputs: true,
                weights: true,
                bias: true,
            },
        }
    }

    /// Adds `W^T y_bar` to the cotangents of the inputs.
    fn reverse_inputs(&mut self, bars: &mut Bars<R>) {
        self.transposed.back ^= true;
        let mut product = Product {
            matrix: &self.transposed,
            x: self.batch.under_way(),
            start: None,
            y: &mut [],
            tanh: false,
        };
        if let &[input] = &self.inputs[..] {
            product.y = bars.get_mut(input);
            return R::vectorize(product);
        }
        self.packed.clear();
        for &input in &self.inputs {
            self.packed
                .extend_from_slice(&bars.part(input)[input.range()]);
        }
        product.y = &mut self.packed;
        R::vectorize(product);
        let mut packed = &self.packed[..];
        for &input in &self.inputs {
            let (here, rest) = packed.split_at(input.len);
            bars.get_mut(input).copy_from_slice(here);
            packed = rest;
        }
    }

    /// Notes this step's outer product; adds the batch up when it is full.
    fn reverse_weights(&mut self, values: Frame<R>) {
        let x = input(&self.inputs, &mut self.packed, values);
        if self.batch.note(x) {
            self.flush();
        }
    }

    fn flush(&mut self) {
        R::vectorize(OuterProducts {
            batch: &self.batch,
            to: &mut self.weights_bar,
        });
        self.batch.clear();
    }
}

/// The inputs in one slice: where they lie, or packed.
#[inline(always)]
fn input<'a, R: Real>(inputs: &[Array], packed: &'a mut Vec<R>, values: Frame<'a, R>) -> &'a [R] {
    if let &[input] = inputs {
        return values.get(input);
    }
    packed.clear();
    for &input in inputs {
        packed.extend_from_slice(values.get(input));
    }
    packed
}

impl<R: Real> Operation<R> for Dense<R> {
    fn outputs(&self) -> Vec<Array> {
        vec![self.output]
    }

    fn load(&mut self, parameters: &[&[R]]) {
        let given = parameters[self.matrix.parameter];
        let columns = self.matrix.columns;
        self.weights
            .each(|row, column, entry| *entry = given[row * columns + column]);
        self.transposed
            .each(|column, row, entry| *entry = given[row * columns + column]);
    }

    fn forward(&mut self, parameters: &[R], row: &mut [R]) {
        self.weights.back ^= true;
        let (row, output) = row.split_at_mut(self.output.start);
        let values = Frame { parameters, row };
        let output = &mut output[..self.output.len];
        let mut product = Product {
            matrix: &self.weights,
            x: input(&self.inputs, &mut self.packed, values),
            start: Some(values.get(self.bias)),
            y: &mut [],
            tanh: self.tanh,
        };
        match &mut self.spread {
            None => {
                product.y = output;
                R::vectorize(product);
            }
            Some(Spread { bits, y, .. }) => {
                product.y = &mut y[..self.bias.len];
                R::vectorize(product);
                R::vectorize(SetOut { bits, y, output });
            }
        }
    }

    fn reverse(&mut self, values: Frame<R>, bars: &mut Bars<R>) {
        let rows = self.bias.len;
        let y_bar = self.batch.under_way_mut();
        let (y, bar, tanh) = (
            values.get(self.output),
            &bars.row[self.output.range()],
            self.tanh,
        );
        match &mut self.spread {
            None => R::vectorize(Incoming {
                y,
                bar,
                tanh,
                y_bar: &mut y_bar[..rows],
            }),
            Some(Spread { bits, bar: all, .. }) => {
                R::vectorize(Incoming {
                    y,
                    bar,
                    tanh,
                    y_bar: &mut all[..y.len()],
                });
                R::vectorize(PickUp {
                    bits,
                    from: all,
                    to: y_bar,
                });
            }
        }
        if self.active.bias {
            R::vectorize(AddTo {
                to: bars.get_mut(self.bias),
                bar: self.batch.under_way(),
            });
        }
        if self.active.inputs {
            self.reverse_inputs(bars);
        }
        if self.active.weights {
            self.reverse_weights(values);
        }
    }

    fn set_active(&mut self, arrays: &[bool], parameters: &[bool]) {
        self.active = Active {
            inputs: self.inputs_active.iter().any(|&id| arrays[id]),
            weights: parameters[self.matrix.parameter],
            bias: arrays[self.bias.id],
        };
        // A new sweep begins.
        self.weights_bar.entries.fill(R::zero());
        self.batch.clear();
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

/// Writes rows to their places in the output.
struct SetOut<'a, R> {
    bits: &'a [u16],
    y: &'a [R],
    output: &'a mut [R],
}

impl<R: Real> Vectorized<R> for SetOut<'_, R> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        let mut row = 0;
        for (lane, &bits) in self.bits.iter().enumerate() {
            let rows = L::load(&self.y[row..]).expand(bits);
            rows.store_up_to(&mut self.output[lane * L::N..]);
            row += bits.count_ones() as usize;
        }
    }
}

/// Collects rows from their places in the output. Every lane is written whole; the next one
/// begins where its rows end.
struct PickUp<'a, R> {
    bits: &'a [u16],
    from: &'a [R],
    to: &'a mut [R],
}

impl<R: Real> Vectorized<R> for PickUp<'_, R> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        let mut row = 0;
        for (lane, &bits) in self.bits.iter().enumerate() {
            let rows = L::load(&self.from[lane * L::N..]).compress(bits);
            rows.store(&mut self.to[row..]);
            row += bits.count_ones() as usize;
        }
    }
}

/// The cotangent of `W x` from that of the output.
struct Incoming<'a, R> {
    y: &'a [R],
    bar: &'a [R],
    tanh: bool,
    y_bar: &'a mut [R],
}

impl<R: Real> Vectorized<R> for Incoming<'_, R> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        for i in (0..self.y.len()).step_by(L::N) {
            let (y, mut bar) = (L::load_up_to(&self.y[i..]), L::load_up_to(&self.bar[i..]));
            if self.tanh {
                bar = L::chain((-y).fma(y, L::one()), bar);
            }
            bar.store_up_to(&mut self.y_bar[i..]);
        }
    }
}

struct AddTo<'a, R> {
    to: &'a mut [R],
    bar: &'a [R],
}

impl<R: Real> Vectorized<R> for AddTo<'_, R> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        for i in (0..self.bar.len()).step_by(L::N) {
            let to = &mut self.to[i..];
            (L::load_up_to(to) + L::load_up_to(&self.bar[i..])).store_up_to(to);
        }
    }
}
