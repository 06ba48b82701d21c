//! In place of `device.rs` in a wheel without GPU support.

use crate::asked::Asked;
use crate::errors::InputError;
use cosmic::world::Trajectory;
use pyo3::prelude::*;
use std::sync::Arc;

/// A GPU, which this wheel cannot use: there is no value of this type.
pub(crate) enum Device {}

impl Device {
    /// Whether this wheel has GPU support.
    pub(crate) const IS_SUPPORTED: bool = false;

    pub(crate) fn shared() -> PyResult<Arc<Self>> {
        Err(InputError::new_err(
            "device: \"gpu\": this package has no GPU support; build the one that has, cosmic-codesign-gpu, from the source \
             by python/gpu-wheel.sh, and install it in place of cosmic-codesign",
        ))
    }

    pub(crate) fn failed(&self, _: &str) -> PyErr {
        match *self {}
    }

    pub(crate) fn rollouts<R>(&self, _: &Asked<R>) -> Result<Vec<Trajectory<R>>, String> {
        match *self {}
    }

    pub(crate) fn pulled<R>(
        &self,
        _: &Asked<R>,
        _: [&[R]; 2],
    ) -> Result<Vec<(bool, Vec<R>)>, String> {
        match *self {}
    }
}
