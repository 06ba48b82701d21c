//! Vectors, and the shapes that they span. Only this module touches components; all other code uses the
//! operators and methods of [`Vector`].
//!
//! The last axis points up, or out of the ground. The first axis points along the ground in the direction
//! of `+x`. Code that needs no other axes is written for any dimension `D`. Robots are planar today, so
//! `D` is 2 wherever a type does not say otherwise.
//!
//! # Frames
//!
//! There are two frames: the world's, and the frame of the [`Ground`]. In the ground's frame contact is the
//! sign of one coordinate.
//!
//! - The *world's* frame: states, trajectories and lattice positions, in memory and in files; what losses and
//!   the controller see.
//! - The *ground's* frame: scenes, truss files and places of a lattice; everything inside a rollout, which
//!   includes what laws see.
//!
//! [`State::to_ground`](crate::lattice::State::to_ground) and
//! [`State::to_world`](crate::lattice::State::to_world) are the only two crossings of states. The simulator
//! crosses once at the start of a rollout and once for every observed state; a step changes no frame.

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
