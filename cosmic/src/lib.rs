//! Co-design of truss-lattice robots: structure, material and neural control are optimised together by gradients
//! through a differentiable simulator.
//!
//! The order of the modules is the architecture: each module uses only modules above it.
//!
//! - [`scene`] has every number of an experiment, in one small struct per part of the model. [`mod@settings`] declares the
//!   keys of these structs. [`registry`] has the laws, losses, policies, lattices and scenes that a program adds to the
//!   built-in ones.
//! - [`keys`](mod@keys) declares the keys of files and the columns of tables, and [`numbers`] formats their numbers.
//! - Space: [`geometry`] has vectors, the ground and the coordinate frames.
//! - The robot: [`lattice`] has its nodes and edges, [`design`] the design vectors that an optimiser changes, and
//!   [`policy`] the controller. [`projection`] converts design vectors to materials and a body.
//! - Its motion and score: [`laws`] has the forces and the contact laws. A [`World`](world::World) is built once from a
//!   scene; its verb [`run`](world::World::run) lets [`Robot`](world::Robot)s walk over a [`Span`](world::Span) of steps.
//!   [`walk`] reads the loads of bars and the energy of a robot from a walk, and finds the step in which a walk diverged.
//!   [`objective`] computes losses from trajectories. [`inputs`] has the numbers with respect to which losses are
//!   differentiated. [`case`] is one walk with all its numbers in a file.
//! - [`judge`] says what a robot is worth: how far it walks, how surely, and in plain words whether it could be built.
//!   [`search`] is the paper's algorithm 1. [`optimiser`] is the package `cosmic-optimiser`, which does not depend on robots.
//!   [`outcome`] has the results that are saved, and [`format`](mod@format) the keys with which JSON files begin.
//! - On disk: [`record`] reads and writes the folder of a run. This module and [`parallel`] need the feature `files`, which is on by default. Without this feature the crate needs no file system
//!   and no threads, and also builds for `wasm32-unknown-unknown`.
//!
//! To read the source, begin with `world/robot.rs`, `world/span.rs` and `world/run.rs`: what walks, for how long, and the verb.
//! Then `world/step.rs` and `world/mechanics.rs` are a step, `laws/bars/hooke.rs` is a law in a file,
//! `scene/sections/robot.rs` declares the keys of a robot, `walk/loads.rs` reads a walk, and `search/iterate.rs` is one
//! iteration of algorithm 1.
//!
//! The crate `cosmic-lab` has checks, sweeps and reports. The crate `cosmic-program` is the program.

pub mod numbers;
pub mod geometry;
pub mod error;
#[cfg(feature = "files")]
pub mod parallel;
pub mod random;
pub mod registry;
pub mod reading;
pub mod format;
pub mod keys;
pub mod lattice;
pub mod settings;
pub mod laws;
pub mod scene;
pub mod design;
pub mod projection;
pub mod policy;
pub mod world;
pub mod walk;
pub mod objective;
pub mod inputs;
pub mod case;
pub mod shop;
pub mod judge;
pub mod search;
pub mod outcome;
#[cfg(feature = "files")]
pub mod record;

#[doc(inline)]
pub use autodiff_derive::{Fields, kernel};
#[doc(inline)]
pub use autodiff_programs::internal::Fields;
pub use cosmic_optimiser as optimiser;
pub use error::{Error, Result};
pub use registry::Registry;

/// Compiles and runs the code in the README as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
