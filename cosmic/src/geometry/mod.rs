//! Vectors and shapes. Only this module accesses components of vectors; all other code uses the operators and methods
//! of [`Vector`].
//!
//! The first axis points along the ground in the direction of `+x`, the second across, and the last up, or out of the ground.
//! All code but the kernels of a step computes with vectors of space; the points of a planar robot are 0 across. Kernels are
//! written for any dimension `D` and compiled for 2 and 3. [`Dimension`] says which numbers of points are in files and arrays.
//!
//! # Frames
//!
//! There are two frames: the world's frame and the frame of the [`Ground`]. In the ground's frame, a point is below
//! flat ground if its last coordinate is negative.
//!
//! - These are in the *world's* frame: states, trajectories and a lattice's `positions`, both in memory and in files;
//!   also the inputs of losses and controllers.
//! - These are in the *ground's* frame: scenes, truss files, a lattice's `places`, and everything inside a rollout,
//!   including the inputs of laws.
//!
//! Only [`State::to_ground`](crate::lattice::State::to_ground) and [`State::to_world`](crate::lattice::State::to_world)
//! convert states. The simulator converts once at the start of a rollout and once for every observed state, but never
//! within a step.

mod vector;
mod dimension;
mod operators;
mod points;
mod matrix;
mod symmetric;
mod rotation;
mod plane;
mod ground;
mod profile;
mod range;
mod segment;

pub(crate) use dimension::explicit_in;
pub use dimension::{Axes, Dimension, Row};
pub use ground::Ground;
pub use matrix::Matrix;
pub use plane::Plane;
pub(crate) use points::weighted_mean;
pub use points::{Bounds, mean};
pub(crate) use profile::Wall;
pub use profile::{MOST_POINTS, Profile};
pub use range::Range;
pub use rotation::Rotation;
pub use segment::{Segment, crossings};
pub use symmetric::Symmetric;
pub use vector::{Along, Vector};
