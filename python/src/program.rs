//! The program `cosmic`.

use crate::errors::caught;
use cosmic_program::Program;
use pyo3::prelude::*;
use std::ffi::OsString;

/// Runs a command of the program, and returns its exit code. The first argument is the program's name.
#[pyfunction]
pub(crate) fn program(py: Python, arguments: Vec<OsString>) -> PyResult<u8> {
    caught(|| Ok(py.detach(|| Program::new().run_with(arguments))))
}
