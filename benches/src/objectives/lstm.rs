//! The loss of a small language model: layers of LSTM cells with diagonal weights, over a sequence of characters.
//!
//! Each character is one step of a rollout. The state consists of the hidden and cell values of every layer, and the
//! sum of the losses so far. The parameters are the weights.

use autodiff::{Function, Real, gradient};
use autodiff_programs::{Array, Kernel, Model, Program, Rollout};
use cosmic::kernel;
use serde::Deserialize;
use serde_json::value::RawValue;

use super::work::{Error, Prepared, flat, read, require, work};

/// The number of weight and bias vectors in a layer.
const PER_LAYER: usize = 8;

/// The input from GradBench. Every row of a list has one number for each bit of a character.
#[derive(Deserialize)]
struct Input {
    /// Two rows per layer: the weights and the biases, each for the gates forget, input, output and change.
    main_params: Vec<Vec<f64>>,
    /// The input weight, the output weight and the output bias.
    extra_params: Vec<Vec<f64>>,
    /// Two rows per layer: the hidden and the cell values at the start.
    state: Vec<Vec<f64>>,
    sequence: Vec<Vec<f64>>,
}

/// The loss as a function of the parameters.
struct LanguageLoss {
    rollout: Rollout<Cells>,
    start: Vec<f64>,
}

/// The model of one step, which processes one character of the sequence.
#[derive(Clone, Debug)]
struct Cells {
    layers: usize,
    bits: usize,
}

/// A kernel that computes `tanh(s (x w + b))` for a scale `s`. With `s = 1/2`, [`opened`] turns the result into
/// `sigmoid(x w + b)`.
struct Gate(f64);
/// A kernel that computes the new cell and hidden values from the old cell value and from the gates forget, input,
/// output and change.
struct Cell;
/// A kernel that multiplies two numbers.
struct Product;
/// A kernel that computes the exponential of `y = x w + b`, and the product of `y` with the next character.
struct Prediction;
/// A kernel that adds the loss of a character, given `sum_j x_j y_j`, `2 + sum_j exp y_j` and `sum_j x_j`.
struct Add;

#[kernel]
impl Kernel<3, 1> for Gate {
    fn eval<R: Real>(&self, [x, weight, bias]: [R; 3], _: &[R]) -> [R; 1] {
        [(R::lit(self.0) * x.fma(weight, bias)).tanh()]
    }
}

/// Returns the sigmoid `1 / (1 + exp(-z))`, given `tanh(z / 2)`.
#[inline(always)]
fn opened<R: Real>(gate: R) -> R {
    R::lit(0.5).fma(gate, R::lit(0.5))
}

#[kernel]
impl Kernel<5, 2> for Cell {
    fn eval<R: Real>(&self, [cell, forget, input, output, change]: [R; 5], _: &[R]) -> [R; 2] {
        let new = cell.fma(opened(forget), opened(input) * change);
        [new, opened(output) * new.tanh()]
    }
}

#[kernel]
impl Kernel<2, 1> for Product {
    fn eval<R: Real>(&self, [a, b]: [R; 2], _: &[R]) -> [R; 1] {
        [a * b]
    }
}

#[kernel]
impl Kernel<4, 2> for Prediction {
    fn eval<R: Real>(&self, [x, weight, bias, next]: [R; 4], _: &[R]) -> [R; 2] {
        let y = x.fma(weight, bias);
        [y.exp(), y * next]
    }
}

#[kernel]
impl Kernel<4, 1> for Add {
    fn eval<R: Real>(&self, [loss, matched, normaliser, ones]: [R; 4], _: &[R]) -> [R; 1] {
        [loss + matched - ones * normaliser.ln()]
    }
}

impl Model for Cells {
    /// The parameters are the vectors of the file in order, and then three constants that the sums need: a row of ones,
    /// a two and a zero. The state has the hidden and cell values of each layer, then the loss. The inputs are the
    /// character, the next character, and the number of ones in the next character.
    fn record(&self, program: &mut Program) {
        let weights: Vec<Array> = (0..PER_LAYER * self.layers + 3)
            .map(|_| program.parameter(self.bits))
            .collect();
        let ones = program.matrix(1, self.bits);
        let (two, zero) = (program.parameter(1), program.parameter(1));
        let states: Vec<Array> = (0..2 * self.layers)
            .map(|_| program.state(self.bits))
            .collect();
        let loss = program.state(1);
        let character = program.input(self.bits);
        let next = program.input(self.bits);
        let count = program.input(1);

        let (layers, ends) = weights.split_at(PER_LAYER * self.layers);
        let [mut x] = program.map(Product, [character, ends[0]], &[]);
        for (weights, state) in layers.chunks(PER_LAYER).zip(states.chunks(2)) {
            x = layer(program, x, [weights, state]);
        }
        let [exponential, matched] = program.map(Prediction, [x, ends[1], ends[2], next], &[]);
        let normaliser = program.dense(ones, &[exponential], two);
        let matched = program.dense(ones, &[matched], zero);
        let [total] = program.map(Add, [loss, matched, normaliser, count], &[]);
        program.advance(loss, total);
    }
}

/// Records the step of one layer and returns its new hidden values.
fn layer(program: &mut Program, x: Array, [weights, state]: [&[Array]; 2]) -> Array {
    let (hidden, cell) = (state[0], state[1]);
    let mut gate = |scale, from, k: usize| {
        let [gate] = program.map(Gate(scale), [from, weights[k], weights[k + 4]], &[]);
        gate
    };
    let (forget, input) = (gate(0.5, x, 0), gate(0.5, hidden, 1));
    let (output, change) = (gate(0.5, x, 2), gate(1.0, hidden, 3));
    let next = program.map(Cell, [cell, forget, input, output, change], &[]);
    program.advance(cell, next[0]);
    program.advance(hidden, next[1]);
    next[1]
}

impl Function for LanguageLoss {
    fn eval<R: Real>(&self, parameters: &[R]) -> R {
        let Cells { bits, .. } = self.rollout.model;
        let constants = |values: &[f64]| values.iter().map(|&v| R::lit(v)).collect::<Vec<R>>();
        let sums = [vec![1.0; bits], vec![2.0], vec![0.0]].map(|values| constants(&values));
        let all: Vec<&[R]> = parameters
            .chunks(bits)
            .chain(sums.each_ref().map(|s| &s[..]))
            .collect();
        let end = self.rollout.run(&constants(&self.start), &all);
        let terms = (self.rollout.steps * bits) as f64;
        -end[end.len() - 1] / R::lit(terms)
    }
}

impl Input {
    /// Returns the loss and all parameters: the weights of the layers, then those of the input and the output.
    fn loss(&self) -> Result<(LanguageLoss, Vec<f64>), Error> {
        let sequence = &self.sequence;
        require(
            sequence.len() > 1,
            "`sequence` must have at least two characters",
        )?;
        let (bits, rows) = (sequence[0].len(), self.main_params.len());
        let layers = rows.is_multiple_of(2) && rows > 0 && self.state.len() == rows;
        let fits = bits > 0 && layers && self.extra_params.len() == 3;
        require(
            fits,
            "`main_params` and `state` must have two rows per layer, and `extra_params` three rows",
        )?;
        flat(
            sequence,
            bits,
            "all characters of `sequence` must have the same length",
        )?;
        let mut start = flat(
            &self.state,
            bits,
            "each row of `state` must have one number for each bit of a character",
        )?;
        start.push(0.0);
        let what = "each row of `main_params` must have four numbers for each bit of a character";
        let mut parameters = flat(&self.main_params, 4 * bits, what)?;
        let what = "each row of `extra_params` must have one number for each bit of a character";
        parameters.extend(flat(&self.extra_params, bits, what)?);
        let inputs = sequence.windows(2).flat_map(|pair| {
            let count = pair[1].iter().sum();
            [&pair[0][..], &pair[1], &[count]].concat()
        });
        let layers = rows / 2;
        let rollout = Rollout {
            inputs: inputs.collect(),
            ..Rollout::new(Cells { layers, bits }, sequence.len() - 1)
        };
        Ok((LanguageLoss { rollout, start }, parameters))
    }
}

pub(super) fn prepare(function: &str, input: &RawValue) -> Prepared {
    let (loss, parameters) = read::<Input>(input)?.loss()?;
    match function {
        "objective" => work(move || loss.eval(&parameters)),
        "jacobian" => work(move || gradient(|x| loss.eval(x), &parameters)),
        _ => Error::function(function),
    }
}
