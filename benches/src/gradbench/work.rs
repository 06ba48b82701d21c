//! What is timed: a function with its input read.

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::value::RawValue;

/// A function of an evaluation with its input read, and memory for its answer.
pub trait Work {
    /// Computes the answer, from scratch.
    fn run(&mut self);

    /// The answer of the last [`run`](Self::run), as JSON.
    ///
    /// # Errors
    /// If it cannot be written.
    fn answer(&self) -> serde_json::Result<String>;
}

/// What reading an input ends in.
pub type Prepared = Result<Box<dyn Work>, Refusal>;

/// Why a request is refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Refusal {
    /// The evaluation has no function of this name.
    #[error("there is no function '{0}'")]
    Function(String),
    /// The input is not in the format of the function.
    #[error("the input does not read: {0}")]
    Input(#[from] serde_json::Error),
    /// The parts of the input do not fit one another.
    #[error("the input does not fit: {0}")]
    Shape(String),
    /// The answer is infinite or NaN, which JSON does not know.
    #[error("the answer is not finite")]
    NotFinite,
}

/// Reads an input.
pub(super) fn read<T: DeserializeOwned>(input: &RawValue) -> Result<T, Refusal> {
    Ok(serde_json::from_str(input.get())?)
}

/// Refuses an input unless a condition holds.
pub(super) fn require(fits: bool, what: &str) -> Result<(), Refusal> {
    if fits {
        Ok(())
    } else {
        Err(Refusal::Shape(what.to_owned()))
    }
}

/// The rows of a matrix one after the other, which all have the same length.
pub(super) fn flat(rows: &[Vec<f64>], columns: usize, what: &str) -> Result<Vec<f64>, Refusal> {
    require(rows.iter().all(|row| row.len() == columns), what)?;
    Ok(rows.concat())
}

/// Work that a closure does.
pub(super) fn work<T: Serialize + 'static>(compute: impl FnMut() -> T + 'static) -> Prepared {
    Ok(Box::new(Closure {
        compute,
        answer: None,
    }))
}

/// A closure and what it returned last.
struct Closure<F, T> {
    compute: F,
    answer: Option<T>,
}

impl<T: Serialize, F: FnMut() -> T> Work for Closure<F, T> {
    fn run(&mut self) {
        self.answer = Some((self.compute)());
    }

    fn answer(&self) -> serde_json::Result<String> {
        serde_json::to_string(&self.answer)
    }
}
