//! The loss of a small language model: layers of LSTM cells without matrices, stepped through a
//! sequence of characters.
//!
//! A character is a step of a rollout: the state is every layer's hidden and cell values and the
//! loss so far, the parameters are the weights.

#[rustfmt::skip]
mod adjoints;
#[cfg(test)]
mod emission;

use autodiff::value_and_gradient;
use autodiff::{Array, Function, Kernel, Model, Program, Pullback, Real, Rollout};
use serde::Deserialize;
use serde_json::value::RawValue;
use serde_json::{Value, json};

use super::work::{Error, Prepared, Problem, flat, functions, read, require};

/// Vectors of weights and biases in a layer.
const PER_LAYER: usize = 8;

/// The input, as GradBench sends it; all rows have a number for each bit of a character.
#[derive(Deserialize)]
pub(super) struct Input {
    /// Two rows per layer: weights and biases, each of forget, input, output and change.
    main_params: Vec<Vec<f64>>,
    /// Input weight, output weight, output bias.
    extra_params: Vec<Vec<f64>>,
    /// Two rows per layer: hidden values and cells at the start.
    state: Vec<Vec<f64>>,
    sequence: Vec<Vec<f64>>,
}

/// An instance, with memory for its results.
pub(super) struct Lstm {
    loss: LanguageLoss,
    /// The layers' weights, then those of input and output.
    parameters: Vec<f64>,
    value: f64,
    gradient: Vec<f64>,
}

/// The objective as a function of the parameters.
struct LanguageLoss {
    rollout: Rollout<Cells>,
    start: Vec<f64>,
}

/// One character of the sequence.
#[derive(Clone, Debug)]
struct Cells {
    layers: usize,
    bits: usize,
}

/// `tanh((x w + b) / 2)`, of which `sigmoid(x w + b)` is [`opened`].
struct Gate;
/// `tanh(x w + b)`.
struct Change;
/// The new cell value, from the old, forget gate, input gate and change, and its `tanh`.
struct Cell;
/// The new hidden value, from output gate and the `tanh` of the new cell value.
struct Hidden;
/// A product of two.
struct Product;
/// `y = x w + b`: its exponential, and its product with the next character.
struct Prediction;
/// The loss so far, and that of a character: `sum_j x_j y_j`, `2 + sum_j exp y_j`, `sum_j x_j`.
struct Add;

/// The adjoint of a kernel of so many inputs and results: what is emitted.
macro_rules! by_emitted {
    ($inputs:literal, $results:literal) => {
        #[inline(always)]
        fn vjp<R: Real, const M: usize>(
            &self,
            at: Pullback<R, $inputs, $results, M>,
        ) -> [[R; $inputs]; M] {
            self.emitted_vjp(at)
        }
    };
}

impl Kernel<3, 1> for Gate {
    #[inline(always)]
    fn eval<R: Real>(&self, [x, weight, bias]: [R; 3]) -> [R; 1] {
        [(R::lit(0.5) * x.fma(weight, bias)).tanh()]
    }

    by_emitted! { 3, 1 }
}

/// `1 / (1 + exp(-z))`, given `tanh(z / 2)`.
#[inline(always)]
fn opened<R: Real>(gate: R) -> R {
    R::lit(0.5).fma(gate, R::lit(0.5))
}

impl Kernel<3, 1> for Change {
    #[inline(always)]
    fn eval<R: Real>(&self, [x, weight, bias]: [R; 3]) -> [R; 1] {
        [x.fma(weight, bias).tanh()]
    }

    by_emitted! { 3, 1 }
}

impl Kernel<4, 2> for Cell {
    #[inline(always)]
    fn eval<R: Real>(&self, [cell, forget, input, change]: [R; 4]) -> [R; 2] {
        let new = cell.fma(opened(forget), opened(input) * change);
        [new, new.tanh()]
    }

    by_emitted! { 4, 2 }
}

impl Kernel<2, 1> for Hidden {
    #[inline(always)]
    fn eval<R: Real>(&self, [output, squashed]: [R; 2]) -> [R; 1] {
        [opened(output) * squashed]
    }

    by_emitted! { 2, 1 }
}

impl Kernel<2, 1> for Product {
    #[inline(always)]
    fn eval<R: Real>(&self, [a, b]: [R; 2]) -> [R; 1] {
        [a * b]
    }

    by_emitted! { 2, 1 }
}

impl Kernel<4, 2> for Prediction {
    #[inline(always)]
    fn eval<R: Real>(&self, [x, weight, bias, next]: [R; 4]) -> [R; 2] {
        let y = x.fma(weight, bias);
        [y.exp(), y * next]
    }

    by_emitted! { 4, 2 }
}

impl Kernel<4, 1> for Add {
    #[inline(always)]
    fn eval<R: Real>(&self, [loss, matched, normaliser, ones]: [R; 4]) -> [R; 1] {
        [loss + matched - ones * normaliser.ln()]
    }

    by_emitted! { 4, 1 }
}

impl Model for Cells {
    /// Parameters: the vectors of the file in order; a row of ones, a two and a zero, to sum with.
    /// State: per layer hidden and cell values, then the loss. Inputs: the character, the next
    /// one, and how many ones are in that.
    fn record<R: Real>(&self, program: &mut Program<R>) {
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
        let [mut x] = program.map(Product, [character, ends[0]]);
        for (weights, state) in layers.chunks(PER_LAYER).zip(states.chunks(2)) {
            x = layer(program, x, [weights, state]);
        }
        let [exponential, matched] = program.map(Prediction, [x, ends[1], ends[2], next]);
        let normaliser = program.dense(ones, &[exponential], two);
        let matched = program.dense(ones, &[matched], zero);
        let [total] = program.map(Add, [loss, matched, normaliser, count]);
        program.advance(loss, total);
    }
}

/// Steps a layer and returns its new hidden values.
fn layer<R: Real>(program: &mut Program<R>, x: Array, [weights, state]: [&[Array]; 2]) -> Array {
    let (hidden, cell) = (state[0], state[1]);
    let [forget] = program.map(Gate, [x, weights[0], weights[4]]);
    let [input] = program.map(Gate, [hidden, weights[1], weights[5]]);
    let [output] = program.map(Gate, [x, weights[2], weights[6]]);
    let [change] = program.map(Change, [hidden, weights[3], weights[7]]);
    let [new_cell, squashed] = program.map(Cell, [cell, forget, input, change]);
    let [new_hidden] = program.map(Hidden, [output, squashed]);
    program.advance(cell, new_cell);
    program.advance(hidden, new_hidden);
    new_hidden
}

impl Function for LanguageLoss {
    fn eval<R: Real>(&self, parameters: &[R]) -> R {
        let Cells { bits, .. } = self.rollout.model;
        let constants = |values: &[f64]| values.iter().map(|&v| R::lit(v)).collect::<Vec<R>>();
        let (ones, two, zero) = (
            constants(&vec![1.0; bits]),
            constants(&[2.0]),
            constants(&[0.0]),
        );
        let mut all: Vec<&[R]> = parameters.chunks(bits).collect();
        all.extend([&ones[..], &two, &zero]);
        let end = self.rollout.run(&constants(&self.start), &all);
        let terms = (self.rollout.steps * bits) as f64;
        -end[end.len() - 1] / R::lit(terms)
    }
}

impl Lstm {
    pub(super) fn new(input: Input) -> Result<Self, Error> {
        let Input { sequence, .. } = &input;
        require(
            sequence.len() > 1,
            "`sequence` must have at least two characters",
        )?;
        let (bits, rows) = (sequence[0].len(), input.main_params.len());
        let layers = rows.is_multiple_of(2) && rows > 0 && input.state.len() == rows;
        let fits = bits > 0 && layers && input.extra_params.len() == 3;
        require(
            fits,
            "a layer must have two rows of weights and two of state, the ends three",
        )?;
        flat(sequence, bits, "the characters differ in length")?;
        let mut start = flat(
            &input.state,
            bits,
            "a row of `state` must have a number for each bit",
        )?;
        start.push(0.0);
        let mut parameters = flat(
            &input.main_params,
            4 * bits,
            "a gate must have a weight for each bit",
        )?;
        parameters.extend(flat(
            &input.extra_params,
            bits,
            "an end must have a weight for each bit",
        )?);
        let inputs = sequence.windows(2).flat_map(|pair| {
            let count = pair[1].iter().sum();
            [&pair[0][..], &pair[1], &[count]].concat()
        });
        let layers = rows / 2;
        let rollout = Rollout {
            inputs: inputs.collect(),
            ..Rollout::new(Cells { layers, bits }, sequence.len() - 1)
        };
        Ok(Self {
            loss: LanguageLoss { rollout, start },
            parameters,
            value: 0.0,
            gradient: Vec::new(),
        })
    }
}

impl Problem for Lstm {
    fn objective(&mut self) {
        self.value = self.loss.eval(&self.parameters);
    }

    fn derivative(&mut self) {
        (self.value, self.gradient) = value_and_gradient(|x| self.loss.eval(x), &self.parameters);
    }

    fn answer(&self) -> Value {
        json!({ "objective": self.value, "gradient": self.gradient })
    }
}

pub(super) fn prepare(function: &str, input: &RawValue) -> Prepared {
    let lstm = Lstm::new(read(input)?)?;
    functions(
        function,
        lstm,
        [|lstm| json!(lstm.value), |lstm| json!(lstm.gradient)],
    )
}
