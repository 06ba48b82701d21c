//! The dense layer as one operation, with two copies of its weights.
//!
//! The forward product `W x` and the reverse product `W^T y_bar` each read the weights once, from first to last.
//! They need different orders of the weights, so both orders are stored.

use super::super::array::{Array, Matrix};
use super::super::operation::Operation;
use super::super::row::{Bars, StepValues, joined};
use super::aligned::Aligned;
use super::epilogue::Epilogue;
use super::outer::Pending;
use super::product::{MatrixProduct, PackedMatrix};
use crate::real::Real;
use crate::simd::{Lane, Vectorized, lanes};

/// The declaration of a layer.
pub(crate) struct Layer<'a> {
    pub(crate) matrix: Matrix,
    pub(crate) x: &'a [Array],
    pub(crate) bias: Array,
    pub(crate) output: Array,
    /// Whether each place of the output is a row of the matrix. Other places are zero.
    pub(crate) places: &'a [bool],
    pub(crate) tanh: bool,
}

pub(crate) struct DenseLayer<R> {
    matrix: Matrix,
    /// The inputs; adjacent arrays are joined. A single array is read in place.
    inputs: Vec<Array>,
    inputs_active: Vec<usize>,
    bias: Array,
    output: Array,
    /// The zeros among the rows of the output, if there are any.
    spread: Option<Spread<R>>,
    tanh: bool,
    /// `W`, for `W x`.
    weights: PackedMatrix<R>,
    /// `W^T`, for `W^T y_bar`.
    transposed: PackedMatrix<R>,
    /// The cotangent of `W`, row by row.
    weights_bar: Vec<R>,
    /// The inputs and output cotangents of the last steps, which are not yet part of `weights_bar`.
    batch: Pending<R>,
    /// Several inputs as one array, or their cotangents.
    packed: Vec<R>,
    active: Active,
}

/// An output with zeros among its rows.
struct Spread<R> {
    lanes: Vec<LaneOfRows>,
    /// If a register holds all starts of one row: the registers of the output that are rows.
    places: Vec<usize>,
    /// Otherwise: the values of the rows without the zeros, with room for a register past the last.
    y: Aligned<R>,
}

/// A register of the output: its first row, and a bit for each place that is a row.
#[derive(Clone, Copy)]
struct LaneOfRows {
    first: usize,
    bits: u16,
}

/// Which cotangents are needed.
struct Active {
    inputs: bool,
    weights: bool,
    bias: bool,
}

impl<R: Real> Spread<R> {
    /// `None` if every place is a row.
    fn new(places: &[bool], starts: usize) -> Option<Self> {
        let count = |places: &[bool]| places.iter().filter(|row| **row).count();
        let (width, rows) = (lanes::<R>(), count(places));
        let lane = |(k, part): (usize, &[bool])| LaneOfRows {
            first: count(&places[..k * width]),
            bits: part
                .iter()
                .rev()
                .fold(0, |bits, &row| bits << 1 | u16::from(row)),
        };
        if rows == places.len() {
            return None;
        }
        let lanes: Vec<_> = places.chunks(width).enumerate().map(lane).collect();
        let is_row = |&k: &usize| starts > 1 && starts == width && lanes[k].bits != 0;
        Some(Self {
            places: (0..lanes.len()).filter(is_row).collect(),
            lanes,
            y: Aligned::zeros(rows + width),
        })
    }
}

impl<R: Real> DenseLayer<R> {
    pub(crate) fn new(layer: Layer) -> Self {
        let (matrix, starts) = (layer.matrix, layer.output.starts);
        let columns = matrix.columns;
        Self {
            inputs: joined(layer.x),
            inputs_active: layer.x.iter().map(|a| a.id).collect(),
            spread: Spread::new(layer.places, starts),
            matrix,
            bias: layer.bias,
            output: layer.output,
            tanh: layer.tanh,
            weights: PackedMatrix::zero(matrix.rows, columns, starts),
            transposed: PackedMatrix::zero(columns, matrix.rows, starts),
            weights_bar: vec![R::zero(); matrix.rows * columns],
            batch: Pending::new(starts, matrix.rows, columns),
            packed: Vec::with_capacity(columns * starts),
            active: Active {
                inputs: true,
                weights: true,
                bias: true,
            },
        }
    }

    /// Loads the matrix from the parameters, row by row.
    pub(crate) fn load(&mut self, parameters: &[&[R]]) {
        let given = parameters[self.matrix.parameter];
        let columns = self.matrix.columns;
        self.weights.each(|row, column, entries| {
            let below = given[row * columns + column..].iter().step_by(columns);
            for (entry, &weight) in entries.iter_mut().zip(below) {
                *entry = weight;
            }
        });
        self.transposed.each(|column, row, entries| {
            let beside = &given[row * columns + column..][..entries.len()];
            entries.copy_from_slice(beside);
        });
    }

    /// Adds the cotangent of the matrix, row by row, after the last step of a sweep.
    pub(crate) fn matrix_bars(&mut self, parameter_bars: &mut [Vec<R>]) {
        self.batch.flush(&mut self.weights_bar);
        R::vectorize(AddTo {
            to: &mut parameter_bars[self.matrix.parameter],
            bar: &self.weights_bar,
        });
    }

    /// Adds `W^T y_bar` to the cotangents of the inputs.
    fn reverse_inputs(&mut self, bars: &mut Bars<R>) {
        let mut product = MatrixProduct {
            matrix: &self.transposed,
            x: self.batch.current(),
            output: Epilogue::plain(&mut []),
        };
        if let &[input] = &self.inputs[..] {
            product.output.y = bars.get_mut(input);
            return product.run();
        }
        // The whole product comes first, because an input may occur twice.
        self.packed.clear();
        self.packed
            .resize(self.inputs.iter().map(|input| input.len).sum(), R::zero());
        product.output.y = &mut self.packed;
        product.run();
        let mut packed = &self.packed[..];
        for &input in &self.inputs {
            let (bar, rest) = packed.split_at(input.len);
            let to = bars.get_mut(input);
            R::vectorize(AddTo { to, bar });
            packed = rest;
        }
    }

    /// Keeps this step's outer product for later, and adds up the batch when it is full.
    fn reverse_weights(&mut self, values: StepValues<R>) {
        let x = input(&self.inputs, &mut self.packed, values);
        if self.batch.keep(x) {
            self.batch.flush(&mut self.weights_bar);
        }
    }
}

/// The inputs as one slice: in place if they are adjacent, otherwise copied to `packed`.
#[inline(always)]
fn input<'a, R: Real>(
    inputs: &[Array],
    packed: &'a mut Vec<R>,
    values: StepValues<'a, R>,
) -> &'a [R] {
    if let &[input] = inputs {
        return values.get(input);
    }
    packed.clear();
    for &input in inputs {
        packed.extend_from_slice(values.get(input));
    }
    packed
}

impl<R: Real> Operation<R> for DenseLayer<R> {
    fn outputs(&self) -> Vec<Array> {
        vec![self.output]
    }

    fn forward(&mut self, parameters: &[R], row: &mut [R]) {
        let (row, output) = row.split_at_mut(self.output.start);
        let values = StepValues { parameters, row };
        let mut product = MatrixProduct {
            matrix: &self.weights,
            x: input(&self.inputs, &mut self.packed, values),
            output: Epilogue {
                bias: Some(values.get(self.bias)),
                tanh: self.tanh,
                ..Epilogue::plain(&mut [])
            },
        };
        match &mut self.spread {
            None => {
                product.output.y = &mut output[..self.output.len];
                product.run();
            }
            Some(Spread { lanes, places, .. }) if !places.is_empty() => {
                (product.output.y, product.output.places) =
                    (&mut output[..self.output.len], places);
                product.run();
                R::vectorize(Gaps { lanes, output });
            }
            Some(Spread { lanes, y, .. }) => {
                product.output.y = &mut y[..self.bias.len];
                product.run();
                R::vectorize(SetOut { lanes, y, output });
            }
        }
    }

    fn reverse(&mut self, values: &StepValues<R>, bars: &mut Bars<R>) {
        let start = self.output.start;
        let (y, bar) = (&values.row[start..], &bars.row[start..]);
        R::vectorize(BeforeTanh {
            y,
            bar,
            rows: self.output.len,
            lanes: self.spread.as_ref().map(|spread| &spread.lanes[..]),
            tanh: self.tanh,
            y_bar: self.batch.current_mut(),
        });
        if self.active.bias {
            R::vectorize(AddTo {
                to: bars.get_mut(self.bias),
                bar: self.batch.current(),
            });
        }
        if self.active.inputs {
            self.reverse_inputs(bars);
        }
        if self.active.weights {
            self.reverse_weights(*values);
        }
    }

    fn set_active(&mut self, arrays: &[bool], parameters: &[bool]) {
        self.active = Active {
            inputs: self.inputs_active.iter().any(|&id| arrays[id]),
            weights: parameters[self.matrix.parameter],
            bias: arrays[self.bias.id],
        };
        // A new sweep begins.
        self.weights_bar.fill(R::zero());
        self.batch.clear();
    }
}

/// Writes rows and zeros to the output, up to the end of its last register.
struct SetOut<'a, R> {
    lanes: &'a [LaneOfRows],
    y: &'a [R],
    output: &'a mut [R],
}

impl<R: Real> Vectorized<R> for SetOut<'_, R> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        for (lane, output) in self.lanes.iter().zip(self.output.chunks_exact_mut(L::N)) {
            let rows = L::load(&self.y[lane.first..]).expand(lane.bits);
            rows.store(output);
        }
    }
}

/// Writes the zeros among the rows if a register holds all starts of one row.
struct Gaps<'a, R> {
    lanes: &'a [LaneOfRows],
    output: &'a mut [R],
}

impl<R: Real> Vectorized<R> for Gaps<'_, R> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        for (lane, output) in self.lanes.iter().zip(self.output.chunks_exact_mut(L::N)) {
            if lane.bits == 0 {
                L::zero().store(output);
            }
        }
    }
}

/// Computes the cotangent of `W x + bias`, row by row, from the output's cotangent.
struct BeforeTanh<'a, R> {
    y: &'a [R],
    bar: &'a [R],
    /// The length of an output without gaps.
    rows: usize,
    /// The registers of an output with gaps.
    lanes: Option<&'a [LaneOfRows]>,
    tanh: bool,
    /// The result, with room for a register past the last.
    y_bar: &'a mut [R],
}

impl<R: Real> Vectorized<R> for BeforeTanh<'_, R> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        let both = self.y.chunks_exact(L::N).zip(self.bar.chunks_exact(L::N));
        match self.lanes {
            None => {
                let to = self.y_bar[..self.rows].chunks_mut(L::N);
                for (to, (y, bar)) in to.zip(both) {
                    before_tanh::<R, L>(self.tanh, y, bar).store_up_to(to);
                }
            }
            // Whole registers are written. The next register overwrites the numbers past the rows of this one.
            Some(lanes) => {
                for (lane, (y, bar)) in lanes.iter().zip(both) {
                    let rows = before_tanh::<R, L>(self.tanh, y, bar).compress(lane.bits);
                    rows.store(&mut self.y_bar[lane.first..]);
                }
            }
        }
    }
}

/// The cotangent of the argument of `tanh`, from the output `y` and its cotangent. Without `tanh` it is the
/// output's cotangent.
#[inline(always)]
fn before_tanh<R: Real, L: Lane<R>>(tanh: bool, y: &[R], bar: &[R]) -> L {
    let (y, bar) = (L::load(y), L::load(bar));
    if tanh {
        L::chain((-y).fma(y, L::one()), bar)
    } else {
        bar
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
        let both = self.to.chunks_mut(L::N).zip(self.bar.chunks(L::N));
        for (to, bar) in both {
            (L::load_up_to(to) + L::load_up_to(bar)).store_up_to(to);
        }
    }
}
