//! Checks, studies, sweeps and reports of designs and runs of [`cosmic`].
//!
//! The order of the modules is the architecture: a module uses only those above it.
//!
//! - [`table`]: the one writer of tables.
//! - [`robustness`]: designs in randomly drawn worlds.
//! - [`report`]: pages, plots and pictures of runs.
//! - [`export`]: robots for other programs: a model for MuJoCo, files for the workshop.
//! - [`verify`]: error against run time, errors of gradients, stability of extreme robots.
//! - [`sweep`]: many runs from a frozen plan.
//! - [`study`]: experiments of a data file, beside published numbers.

mod files;
mod child;
mod statistics;
pub mod table;
pub mod robustness;
pub mod report;
pub mod export;
mod measure;
pub mod verify;
pub mod sweep;
pub mod study;

pub use cosmic::{Error, Result};

/// The README's code, compiled and run with the documentation's.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
