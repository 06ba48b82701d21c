//! Converts the library's errors to exceptions. Messages name Python calls instead of the program's commands.

use cosmic::Error as Library;
use pyo3::prelude::*;
use pyo3::{PyErr, import_exception};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

import_exception!(cosmic._errors, DivergedError);
import_exception!(cosmic._errors, Error);
import_exception!(cosmic._errors, FileError);
import_exception!(cosmic._errors, InputError);
import_exception!(cosmic._errors, InternalError);
import_exception!(cosmic._errors, InterruptedError);
import_exception!(cosmic._errors, OutOfMemoryError);
import_exception!(cosmic._errors, UnstableStepError);

/// Converts an error of the library to an exception.
pub(crate) fn raised(error: Library) -> PyErr {
    of_class(&error, in_python(error.within()))
}

/// Makes an exception with the message `says`. The kind of the library's error decides the class of the exception.
pub(crate) fn of_class(error: &Library, says: String) -> PyErr {
    match error {
        Library::Diverged { .. } | Library::NotFinite(_) | Library::NoFigure(_) => {
            DivergedError::new_err(says)
        }
        Library::UnstableStep { .. } | Library::UnstableRun { .. } => {
            UnstableStepError::new_err(says)
        }
        Library::NoScene { .. }
        | Library::Read { .. }
        | Library::Write { .. }
        | Library::Taken(_)
        | Library::Claimed { .. } => FileError::new_err(says),
        Library::Interrupted { .. } | Library::Stopped { .. } => InterruptedError::new_err(says),
        // The library's own message names Rust functions, so it is not used.
        Library::OwnLoss { file, .. } => InputError::new_err(format!(
            "{file}: this run has a loss in Python; pass it to cosmic.resume as `loss`"
        )),
        Library::Malformed { .. } | Library::Misfit { .. } | Library::Usage(_) => {
            InputError::new_err(says)
        }
        // If several runs failed, the first error decides the class.
        Library::PassedOver { error, .. } => of_class(error, says),
        Library::CheckFailed { .. } => Error::new_err(says),
        _ => Error::new_err(says),
    }
}

/// Replaces the program's commands in a message by calls of the Python package.
pub(crate) fn in_python(says: String) -> String {
    let translate = |py: Python| -> PyResult<String> {
        let errors = py.import("cosmic._errors")?;
        errors.call_method1("in_python", (&says,))?.extract()
    };
    Python::attach(translate).unwrap_or(says)
}

/// Runs work of the library without the interpreter's lock. Errors and panics become exceptions.
pub(crate) fn unlocked<T: Send>(
    py: Python,
    work: impl FnOnce() -> cosmic::error::Result<T> + Send,
) -> PyResult<T> {
    caught(|| py.detach(work).map_err(raised))
}

/// Runs the body of a function that Python calls. A panic of the library becomes an exception.
pub(crate) fn caught<T>(entry: impl FnOnce() -> PyResult<T>) -> PyResult<T> {
    catch_unwind(AssertUnwindSafe(entry)).unwrap_or_else(|panic| Err(panicked(&*panic)))
}

/// Converts a panic to an exception.
pub(crate) fn panicked(panic: &(dyn Any + Send)) -> PyErr {
    InternalError::new_err(bug(panic))
}

/// Describes a panic.
pub(crate) fn bug(panic: &(dyn Any + Send)) -> String {
    let says = panic.downcast_ref::<String>().map(String::as_str);
    let says = says.or(panic.downcast_ref::<&str>().copied());
    let says = says.unwrap_or("no message");
    format!("bug in the library: {says}; please report it, together with the call that caused it")
}
