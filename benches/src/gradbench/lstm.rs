//! The loss of a small language model: [`adbench`](crate::adbench::lstm)'s.

use serde::Deserialize;
use serde_json::value::RawValue;

use super::work::{Prepared, Refusal, flat, read, require, work};
use crate::adbench::Problem;
use crate::adbench::lstm::Lstm;

#[derive(Deserialize)]
struct Input {
    main_params: Vec<Vec<f64>>,
    extra_params: Vec<Vec<f64>>,
    state: Vec<Vec<f64>>,
    sequence: Vec<Vec<f64>>,
}

impl Input {
    fn problem(self) -> Result<Lstm, Refusal> {
        let bits = self.sequence.first().map_or(0, Vec::len);
        let rows = self.main_params.len();
        let layers =
            rows.is_multiple_of(2) && self.state.len() == rows && self.extra_params.len() == 3;
        require(
            bits > 0 && self.sequence.len() > 1,
            "two characters at least",
        )?;
        require(rows > 0 && layers, "the layers do not fit one another")?;
        flat(&self.sequence, bits, "the characters differ in length")?;
        let start = flat(&self.state, bits, "the state is not as long as a character")?;
        let mut weights = flat(
            &self.main_params,
            4 * bits,
            "a gate has a weight for each bit",
        )?;
        weights.extend(flat(
            &self.extra_params,
            bits,
            "an end has a weight for each bit",
        )?);
        Ok(Lstm::new(bits, weights, start, &self.sequence))
    }
}

/// Functions `objective` and `jacobian`.
///
/// # Errors
/// If there is no such function, or the input is not in its format.
pub fn prepare(function: &str, input: &RawValue) -> Prepared {
    let mut lstm = read::<Input>(input)?.problem()?;
    match function {
        "objective" => work(move || {
            lstm.objective();
            lstm.value()
        }),
        "jacobian" => work(move || {
            lstm.derivative();
            lstm.gradient().to_vec()
        }),
        _ => Err(Refusal::Function(function.to_owned())),
    }
}
