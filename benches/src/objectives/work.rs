//! The interface of objectives, and the preparation of GradBench's functions.

use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use serde_json::value::RawValue;

/// An objective whose input has been read, with memory for its results.
pub trait Problem {
    /// Computes the objective from scratch, in plain floating point.
    fn objective(&mut self);

    /// Computes objective and derivative from scratch.
    fn derivative(&mut self);

    /// Returns the last results, with the names and shapes of ADBench's reference answers.
    fn answer(&self) -> Value;
}

/// A function of a GradBench module whose input has been read.
pub trait Work {
    /// Computes the answer from scratch.
    fn run(&mut self);

    /// Returns the answer of the last [`run`](Self::run). Numbers that are not finite are null.
    fn answer(&self) -> Value;
}

/// A function that is ready to run, or the error in the request.
pub type Prepared = Result<Box<dyn Work>, Error>;

/// An error in a request or an input file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The module or function does not exist.
    #[error("unknown {0}")]
    Unknown(String),
    /// The input does not have the format of the function.
    #[error("cannot read the input: {0}")]
    Input(#[from] serde_json::Error),
    /// The input has the wrong shape.
    #[error("invalid input: {0}")]
    Shape(String),
    /// The answer is infinite or NaN, which JSON cannot represent.
    #[error("the answer is infinite or NaN, which JSON cannot represent")]
    NotFinite,
    /// The function panicked.
    #[error("the function panicked")]
    Panicked,
    /// A file cannot be read or has the wrong format.
    #[error("{}: {what}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with the file.
        what: String,
    },
}

impl Error {
    /// Returns a function that makes an error about a file from a description.
    pub(crate) fn file(path: &Path) -> impl Fn(String) -> Self {
        |what| Self::File {
            path: path.to_owned(),
            what,
        }
    }

    /// Reads a text file.
    pub(crate) fn read(path: &Path) -> Result<String, Self> {
        std::fs::read_to_string(path).map_err(|error| Self::file(path)(error.to_string()))
    }

    pub(super) fn function<T>(name: &str) -> Result<T, Self> {
        Err(Self::Unknown(format!("function '{name}'")))
    }
}

/// Reads an input.
pub(super) fn read<T: DeserializeOwned>(input: &RawValue) -> Result<T, Error> {
    Ok(serde_json::from_str(input.get())?)
}

/// Returns an error unless a condition holds.
pub(super) fn require(fits: bool, what: &str) -> Result<(), Error> {
    fits.then_some(())
        .ok_or_else(|| Error::Shape(what.to_owned()))
}

/// Concatenates the rows of a matrix, which must all have `columns` entries. Otherwise returns an error with the
/// message `what`.
pub(super) fn flat(rows: &[Vec<f64>], columns: usize, what: &str) -> Result<Vec<f64>, Error> {
    require(rows.iter().all(|row| row.len() == columns), what)?;
    Ok(rows.concat())
}

/// A closure that changes a state. The state also holds the answer.
struct Function<S> {
    state: S,
    run: Box<dyn FnMut(&mut S)>,
    answer: fn(&S) -> Value,
}

impl<S> Work for Function<S> {
    fn run(&mut self) {
        (self.run)(&mut self.state);
    }

    fn answer(&self) -> Value {
        (self.answer)(&self.state)
    }
}

/// Makes a [`Work`] of a closure that returns the answer.
pub(super) fn work<T: Serialize + 'static>(mut compute: impl FnMut() -> T + 'static) -> Prepared {
    Ok(Box::new(Function {
        state: None,
        run: Box::new(move |answer: &mut Option<T>| *answer = Some(compute())),
        answer: |answer| serde_json::json!(answer),
    }))
}

/// Returns the functions `objective` and `jacobian` of a problem, with the answers that they reply with.
pub(super) fn functions<P: Problem + 'static>(
    function: &str,
    problem: P,
    [objective, jacobian]: [fn(&P) -> Value; 2],
) -> Prepared {
    let (run, answer): (fn(&mut P), _) = match function {
        "objective" => (P::objective, objective),
        "jacobian" => (P::derivative, jacobian),
        _ => return Error::function(function),
    };
    Ok(Box::new(Function {
        state: problem,
        run: Box::new(run),
        answer,
    }))
}
