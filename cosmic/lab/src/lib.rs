//! Checks, sweeps and reports for the designs and runs of [`cosmic`].
//!
//! The order of the modules is the architecture: a module uses only those above it.
//!
//! - [`statistics`]: statistics of a sample with the standard error of the median.
//! - [`table`]: tables, and how they are written.
//! - [`robustness`]: designs in randomly drawn worlds.
//! - [`walk`]: robots that walk to the goals that they are given.
//! - [`report`]: pages, plots and pictures of runs.
//! - [`export`]: files of a robot for other programs: MuJoCo and the workshop.
//! - [`check`]: the plan of a step, gradients, distances, errors against run time, and extreme robots.
//! - [`sweep`]: a run for every combination of scenes, settings and seeds, and the table of the results.

mod files;
pub mod statistics;
pub mod table;
pub mod robustness;
pub mod walk;
pub mod report;
pub mod export;
pub mod check;
pub mod sweep;

pub use cosmic::{Error, Result};

/// Compiles and runs the code of the README as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
