//! The extension module `cosmic._core`: the library behind the package `cosmic`.
//!
//! This module computes nothing itself. It passes arrays from Python to the library, which works without the
//! interpreter's lock, and returns arrays. Code that needs no speed is written in Python, in `cosmic/*.py`, which checks
//! all arguments before they come here.

mod errors;
mod work;
mod arrays;
mod scene;
mod kind;
mod asked;
#[cfg_attr(not(feature = "gpu"), path = "no_device.rs")]
mod device;
mod rollouts;
mod simulator;
mod planned;
mod ffi;
mod environment;
mod loss;
mod optimise;
mod program;
mod run;
mod sweep;

/// The extension module.
#[pyo3::pymodule]
mod _core {
    #[pymodule_export]
    use crate::environment::{Driven, animate};
    #[pymodule_export]
    use crate::ffi::xla_handler;
    #[pymodule_export]
    use crate::optimise::{deliver_so_far, optimise, resume};
    #[pymodule_export]
    use crate::planned::Planned;
    #[pymodule_export]
    const STATES: i32 = crate::planned::STATES;
    #[pymodule_export]
    const PUSHED: i32 = crate::planned::PUSHED;
    #[pymodule_export]
    const PULLED: i32 = crate::planned::PULLED;
    #[pymodule_export]
    use crate::program::program;
    #[pymodule_export]
    use crate::run::{load, player_page, report};
    #[pymodule_export]
    use crate::scene::{Scene, scenes, truss};
    /// The version of this package.
    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");
    /// Whether this wheel has GPU support.
    #[pymodule_export]
    const GPU: bool = crate::device::Device::IS_SUPPORTED;
    #[pymodule_export]
    const GRADIENTS: [&str; 5] = crate::arrays::GRADIENTS;
    #[pymodule_export]
    use crate::simulator::Simulator;
    #[pymodule_export]
    use crate::sweep::{sweep_count, sweep_merge, sweep_run};
    #[pymodule_export]
    use crate::work::usual_threads;
}
