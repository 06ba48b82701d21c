//! The library's errors as exceptions. Messages are the library's own.

use cosmic::Error;
use pyo3::exceptions::PyRuntimeError;
use pyo3::{PyErr, import_exception};

import_exception!(cosmic._errors, DivergedError);
import_exception!(cosmic._errors, FileError);
import_exception!(cosmic._errors, InputError);
import_exception!(cosmic._errors, UnstableStepError);
import_exception!(cosmic._errors, InterruptedError);

/// The exception of an error.
pub(crate) fn raised(error: Error) -> PyErr {
    let says = error.within();
    match error {
        Error::Diverged { .. } | Error::NotFinite { .. } | Error::NoFigure(_) => {
            DivergedError::new_err(says)
        }
        Error::UnstableStep { .. } | Error::UnstableRun { .. } => UnstableStepError::new_err(says),
        Error::NoScene { .. } | Error::Read { .. } | Error::Write { .. } | Error::Taken(_) => {
            FileError::new_err(says)
        }
        Error::Interrupted { .. } => InterruptedError::new_err(says),
        // The library's words name what a program in Rust calls.
        Error::OwnLoss { file, .. } => InputError::new_err(format!(
            "{file}: the run is for a loss of Python: give it to cosmic.resume as `loss`"
        )),
        Error::Malformed { .. } | Error::Misfit { .. } | Error::Usage(_) => {
            InputError::new_err(says)
        }
        _ => PyRuntimeError::new_err(says),
    }
}

/// An exception about an argument.
pub(crate) fn refused(says: String) -> PyErr {
    InputError::new_err(says)
}
