//! Checks, studies, sweeps and reports for the designs and runs of [`cosmic`].
//!
//! The order of the modules is the architecture: a module uses only those above it.
//!
//! - [`child`]: child processes that can be stopped.
//! - [`statistics`]: statistics of a sample with their standard errors.
//! - [`table`]: tables, and how they are written.
//! - [`robustness`]: designs in randomly drawn worlds.
//! - [`walk`]: robots that walk to the goals that they are given.
//! - [`report`]: pages, plots and pictures of runs.
//! - [`export`]: files of a robot for other programs: MuJoCo and the workshop.
//! - [`measure`]: measurements of finished runs: in changed scenes, on the way to unseen goals, and in MuJoCo.
//! - [`check`]: the plan of a step, gradients, distances, errors against run time, and extreme robots.
//! - [`sweep`]: many runs from a frozen plan.
//! - [`study`]: the experiments that a TOML file describes, compared with published numbers.

mod files;
pub mod child;
pub mod statistics;
pub mod table;
pub mod robustness;
pub mod walk;
pub mod report;
pub mod export;
pub mod measure;
pub mod check;
pub mod sweep;
pub mod study;

pub use cosmic::{Error, Result};

/// Compiles and runs the code of the README as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
