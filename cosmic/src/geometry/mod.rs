//! Vectors and shapes. Only this module accesses components of vectors; all other code uses the operators and methods
//! of [`Vector`].
//!
//! The first axis points along the ground in the direction of `+x`, the last axis up or out of the ground. Code that
//! needs only these two axes is written for any dimension `D`. Robots are planar today, so `D` is 2 by default.
//!
//! # Frames
//!
//! There are two frames: the world's frame and the frame of the [`Ground`]. In the ground's frame, a point is below
//! flat ground if its last coordinate is negative.
//!
//! - In the *world's* frame are states, trajectories and the positions of a lattice, in memory and in files, and the
//!   inputs of losses and controllers.
//! - In the *ground's* frame are scenes, truss files, the places of a lattice, and everything inside a rollout,
//!   including laws.
//!
//! Only [`State::to_ground`](crate::lattice::State::to_ground) and [`State::to_world`](crate::lattice::State::to_world)
//! convert states. The simulator converts once at the start of a rollout and once for every observed state, but never
//! within a step.

mod vector;
mod operators;
mod points;
mod matrix;
mod rotation;
mod plane;
mod ground;
mod profile;
mod range;
mod segment;

pub use ground::Ground;
pub use matrix::Matrix;
pub use plane::Plane;
pub use points::{Bounds, columns, fill, flat, from_columns, from_flat, mean, weighted_mean};
pub use profile::{MOST_POINTS, Profile};
pub use range::Range;
pub use rotation::Rotation;
pub use segment::{Segment, crossings};
pub use vector::Vector;
