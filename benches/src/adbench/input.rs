//! Reading files of numbers.

use std::path::{Path, PathBuf};
use std::str::{FromStr, SplitAsciiWhitespace};

/// Why a case cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// It cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It is not in the format of its problem.
    #[error("{}: {what}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// The fault.
        what: String,
    },
    /// The answer is out of tolerance: it is not worth timing.
    #[error("{name}: '{field}' is off by {error:e}, allowed are {tolerance:e}")]
    Wrong {
        /// The case.
        name: String,
        /// The field that is furthest off.
        field: String,
        /// The error of that field.
        error: f64,
        /// The error that is allowed.
        tolerance: f64,
    },
}

/// The whole of a file.
pub(super) fn read(path: &Path) -> Result<String, Error> {
    std::fs::read_to_string(path).map_err(|source| Error::Unreadable {
        path: path.to_owned(),
        source,
    })
}

/// The tokens of a file, separated by any white space.
pub(super) struct Tokens<'a> {
    path: &'a Path,
    rest: SplitAsciiWhitespace<'a>,
    taken: usize,
}

impl<'a> Tokens<'a> {
    pub(super) fn new(path: &'a Path, text: &'a str) -> Self {
        Self {
            path,
            rest: text.split_ascii_whitespace(),
            taken: 0,
        }
    }

    pub(super) fn error(&self, what: impl Into<String>) -> Error {
        Error::Malformed {
            path: self.path.to_owned(),
            what: what.into(),
        }
    }

    /// The next token as a number.
    pub(super) fn next<T: FromStr>(&mut self) -> Result<T, Error> {
        self.taken += 1;
        let place = self.taken;
        let token = self.rest.next();
        let token = token.ok_or_else(|| self.error(format!("ends before number {place}")))?;
        let number = token.parse();
        number.map_err(|_| self.error(format!("'{token}', number {place}, is out of place")))
    }

    /// The next token as a count of things: at least one, and no more than memory is likely to
    /// hold.
    pub(super) fn count(&mut self) -> Result<usize, Error> {
        const MOST: usize = 1 << 24;
        match self.next()? {
            count @ 1..=MOST => Ok(count),
            count => Err(self.error(format!(
                "number {}, {count}, is a count, which lies between 1 and {MOST}",
                self.taken
            ))),
        }
    }

    /// The next `len` tokens.
    pub(super) fn numbers(&mut self, len: usize) -> Result<Vec<f64>, Error> {
        (0..len).map(|_| self.next()).collect()
    }

    /// The next `N` tokens.
    pub(super) fn array<const N: usize>(&mut self) -> Result<[f64; N], Error> {
        let mut array = [0.0; N];
        for number in &mut array {
            *number = self.next()?;
        }
        Ok(array)
    }

    /// Nothing may follow.
    pub(super) fn end(mut self) -> Result<(), Error> {
        match self.rest.next() {
            None => Ok(()),
            Some(token) => Err(self.error(format!("goes on after its last number: '{token}'"))),
        }
    }
}
