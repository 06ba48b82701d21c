//! Co-design of truss-lattice robots: structure, material and neural control optimised together by
//! gradients through a differentiable simulator.
//!
//! The order of the modules is the architecture: each uses only those above it.
//!
//! - [`scene`] has every number of an experiment, in one small struct for each of the others; [`registry`] has the laws,
//!   losses, policies, lattices and scenes that a program adds.
//! - [`keys`] declares the keys of files and the columns of tables.
//! - Space: [`geometry`], with vectors, the ground and the frames.
//! - The robot: [`lattice`], [`design`] (what an optimiser moves), [`projection`] (from there to
//!   materials and a body), [`policy`].
//! - Its motion and score: [`simulator`], [`objective`]; [`inputs`], the numbers that losses are
//!   differentiated by, and [`task`], which joins all of these; [`domain`] draws other robots and
//!   surroundings; [`case`] is one rollout with all its numbers in a file.
//! - How it is found: [`optimiser`], which knows no robot, and [`codesign`], the paper's algorithm 1.
//! - On disk: [`record`], the folder of a run. All of it but the text of a design, and [`parallel`], are
//!   behind the feature `files`, which is on by default; without it the model needs no file system and no
//!   threads, and builds for `wasm32-unknown-unknown` too.
//!
//! The crate `cosmic-lab` has checks, studies and reports; the program is `cosmic-program`.

pub mod geometry;
pub mod error;
#[cfg(feature = "files")]
pub mod parallel;
pub mod random;
pub mod registry;
pub mod reading;
pub mod keys;
pub mod lattice;
pub mod settings;
pub mod laws;
pub mod scene;
pub mod generator;
pub mod design;
pub mod projection;
pub mod policy;
pub mod simulator;
pub mod objective;
pub mod inputs;
pub mod task;
pub mod domain;
pub mod optimiser;
pub mod case;
pub mod codesign;
pub mod record;

pub use error::{Error, Result};
pub use registry::Registry;

/// The README's code, compiled and run with the documentation's.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
