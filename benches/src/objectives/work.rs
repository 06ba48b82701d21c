//! The trait of prepared functions, and helpers that prepare the functions of GradBench.

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use serde_json::value::RawValue;

/// A function of a GradBench module whose input has been read.
pub trait Work {
    /// Computes the answer, without results of earlier calls.
    fn run(&mut self);

    /// Returns the answer of the last [`run`](Self::run). Numbers that are not finite are written as null.
    fn answer(&self) -> Value;
}

/// Work that is ready to run, or the error in the request.
pub type Prepared = Result<Box<dyn Work>, Error>;

/// An error in a request.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The module or function does not exist.
    #[error("unknown {0}")]
    Unknown(String),
    /// The input does not have the format of the function.
    #[error("cannot read the input: {0}")]
    Input(#[from] serde_json::Error),
    /// The lists of the input do not have the right lengths.
    #[error("invalid input: {0}")]
    Shape(String),
    /// The answer is infinite or NaN, which JSON cannot represent.
    #[error("the answer is infinite or NaN, which JSON cannot represent")]
    NotFinite,
    /// The function panicked.
    #[error("the function panicked")]
    Panicked,
}

impl Error {
    pub(super) fn function<T>(name: &str) -> Result<T, Self> {
        Err(Self::Unknown(format!("function '{name}'")))
    }
}

/// Parses the input of a function.
pub(super) fn read<T: DeserializeOwned>(input: &RawValue) -> Result<T, Error> {
    Ok(serde_json::from_str(input.get())?)
}

/// Returns an error with the message `what` unless the condition `fits` holds.
pub(super) fn require(fits: bool, what: &str) -> Result<(), Error> {
    fits.then_some(())
        .ok_or_else(|| Error::Shape(what.to_owned()))
}

/// Concatenates the rows of a matrix. Returns an error with the message `what` unless every row has `columns` entries.
pub(super) fn flat(rows: &[Vec<f64>], columns: usize, what: &str) -> Result<Vec<f64>, Error> {
    require(rows.iter().all(|row| row.len() == columns), what)?;
    Ok(rows.concat())
}

/// A [`Work`] that consists of a state, which also holds the answer, and two closures: one changes the state, and one reads
/// the answer.
struct Function<S, Run, Answer> {
    state: S,
    run: Run,
    answer: Answer,
}

impl<S, Run: FnMut(&mut S), Answer: Fn(&S) -> Value> Work for Function<S, Run, Answer> {
    fn run(&mut self) {
        (self.run)(&mut self.state);
    }

    fn answer(&self) -> Value {
        (self.answer)(&self.state)
    }
}

/// Makes a [`Work`] whose state is reused from run to run.
pub(super) fn reusing<S: 'static>(
    state: S,
    run: impl FnMut(&mut S) + 'static,
    answer: impl Fn(&S) -> Value + 'static,
) -> Prepared {
    Ok(Box::new(Function { state, run, answer }))
}

/// Makes a [`Work`] from a closure that computes and returns the answer.
pub(super) fn work<T: Serialize + 'static>(mut compute: impl FnMut() -> T + 'static) -> Prepared {
    let run = move |answer: &mut Option<T>| *answer = Some(compute());
    reusing(None, run, |answer| serde_json::json!(answer))
}
