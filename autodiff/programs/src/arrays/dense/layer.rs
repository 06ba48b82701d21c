//! The dense layer as one operation, with two copies of its weights.
//!
//! The forward product `W x` and the reverse product `W^T y_bar` each read all weights once, in memory order. They need
//! the weights in different orders, so both orders are stored.

use autodiff::Real;
use autodiff::simd::{Lane, Vectorized};

use super::super::array::{Array, Matrix};
use super::super::operation::Operation;
use super::super::row::{Bars, StepValues, joined};
use super::epilogue::Epilogue;
use super::outer::Pending;
use super::product::{MatrixProduct, PackedMatrix};

/// The declaration of a dense layer in a step.
#[allow(missing_docs)] // Only `cosmic-gpu` reads it.
pub struct Layer {
    pub matrix: Matrix,
    pub x: Vec<Array>,
    pub bias: Array,
    pub output: Array,
    pub tanh: bool,
}

pub(crate) struct DenseLayer<R> {
    layer: Layer,
    /// The inputs, with adjacent arrays joined. If one array remains, it is read in place.
    inputs: Vec<Array>,
    /// `W`, stored for the product `W x`.
    weights: PackedMatrix<R>,
    /// `W^T`, stored for the product `W^T y_bar`.
    transposed: PackedMatrix<R>,
    /// The cotangent of `W`, in row-major order.
    weights_bar: Vec<R>,
    /// The inputs and output cotangents of recent steps that have not been added to `weights_bar` yet.
    batch: Pending<R>,
    /// A buffer that joins several inputs, or their cotangents, into one array.
    packed: Vec<R>,
    active: Active,
}

/// Which cotangents the reverse sweep of the layer must compute.
struct Active {
    inputs: bool,
    weights: bool,
    bias: bool,
}

impl Layer {
    /// The inputs, with adjacent arrays joined.
    pub fn inputs(&self) -> Vec<Array> {
        joined(&self.x)
    }
}

impl<R: Real> DenseLayer<R> {
    pub(crate) fn new(layer: Layer) -> Self {
        let (matrix, starts) = (layer.matrix, layer.output.starts);
        let columns = matrix.columns;
        Self {
            inputs: layer.inputs(),
            layer,
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
        // The whole product is computed before any part of it is added, because an input may occur twice.
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

    /// Stores this step's inputs for the outer product. When the batch is full, adds the
    /// outer products of the batch to `weights_bar`.
    fn reverse_weights(&mut self, values: StepValues<R>) {
        let x = input(&self.inputs, &mut self.packed, values);
        if self.batch.keep(x) {
            self.batch.flush(&mut self.weights_bar);
        }
    }
}

/// Returns the inputs as one slice: in place if they are adjacent, otherwise copied to `packed`.
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
        vec![self.layer.output]
    }

    /// Copies the matrix, which is row-major in the parameters, into both packed copies.
    fn load(&mut self, parameters: &[&[R]]) {
        let Matrix {
            parameter, columns, ..
        } = self.layer.matrix;
        let given = parameters[parameter];
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

    fn matrix_bars(&mut self, parameter_bars: &mut [Vec<R>]) {
        self.batch.flush(&mut self.weights_bar);
        R::vectorize(AddTo {
            to: &mut parameter_bars[self.layer.matrix.parameter],
            bar: &self.weights_bar,
        });
    }

    fn forward(&mut self, parameters: &[R], row: &mut [R]) {
        let (values, y) = StepValues::and_outputs(parameters, row, &[self.layer.output]);
        let product = MatrixProduct {
            matrix: &self.weights,
            x: input(&self.inputs, &mut self.packed, values),
            output: Epilogue {
                bias: Some(values.get(self.layer.bias)),
                y,
                tanh: self.layer.tanh,
            },
        };
        product.run();
    }

    fn reverse(&mut self, values: &StepValues<R>, bars: &mut Bars<R>) {
        let start = self.layer.output.start;
        let (y, bar) = (&values.row[start..], &bars.row[start..]);
        R::vectorize(BeforeTanh {
            y,
            bar,
            tanh: self.layer.tanh,
            y_bar: self.batch.current_mut(),
        });
        if self.active.bias {
            R::vectorize(AddTo {
                to: bars.get_mut(self.layer.bias),
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

    fn set_active(&mut self, arrays: &[bool], parameters: &[bool]) -> bool {
        self.active = Active {
            inputs: self.layer.x.iter().any(|x| arrays[x.id]),
            weights: parameters[self.layer.matrix.parameter],
            bias: arrays[self.layer.bias.id],
        };
        // `set_active` is called at the beginning of each sweep, so the sums over the steps start at zero here.
        self.weights_bar.fill(R::zero());
        self.batch.clear();
        true
    }
}

/// Computes the cotangent of `W x + bias` from the cotangent of the output.
struct BeforeTanh<'a, R> {
    y: &'a [R],
    bar: &'a [R],
    tanh: bool,
    /// A buffer for the computed cotangents, one for each row.
    y_bar: &'a mut [R],
}

impl<R: Real> Vectorized<R> for BeforeTanh<'_, R> {
    const USE_THE_ATTRIBUTE_KERNEL: () = ();
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        let both = self.y.chunks_exact(L::N).zip(self.bar.chunks_exact(L::N));
        for (to, (y, bar)) in self.y_bar.chunks_mut(L::N).zip(both) {
            before_tanh::<R, L>(self.tanh, y, bar).store_up_to(to);
        }
    }
}

/// Returns the cotangent of the argument of `tanh`, given the output `y` and the output's cotangent `bar`. Without
/// `tanh` the result is `bar`.
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
    const USE_THE_ATTRIBUTE_KERNEL: () = ();
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        let both = self.to.chunks_mut(L::N).zip(self.bar.chunks(L::N));
        for (to, bar) in both {
            (L::load_up_to(to) + L::load_up_to(bar)).store_up_to(to);
        }
    }
}
