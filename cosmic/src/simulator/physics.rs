//! The settings of a step.

use serde::{Deserialize, Serialize};

/// The world that a robot moves in, and how finely its time is cut.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Physics {
    /// Length of a step, s.
    pub time_step: f64,
    /// Acceleration towards `-y` of the world, also on an incline, m/s^2.
    pub gravity: f64,
    /// Rate at which velocities decay, 1/s.
    pub damping: f64,
    /// What the ground does to a node that touches it.
    pub contact: Contact,
    /// Coefficient of friction; Coulomb contact alone uses it.
    pub friction: f64,
}

/// What the ground does to a node that touches it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Contact {
    /// The node stops.
    Infinite,
    /// The node stops across the ground and is braked along it.
    Coulomb,
}
