//! Scenes: every number of an experiment, as plain data in one small struct per consumer.
//!
//! A function takes the section it needs; only the co-design and what stands above it see the whole
//! [`Scene`]. Units are SI. "Paper silent" marks a value that the paper leaves open.
//!
//! `table` names every key once, with its range; reading, checking and writing all go through it.

mod beyond;
mod builtin;
mod check;
mod departures;
mod design;
mod diagnostic;
mod field;
mod layout;
mod optimisation;
mod read;
mod robot;
mod table;
mod write;

pub use beyond::{ObjectiveSettings, RobustSettings, SearchSettings, TaskKind};
pub use builtin::{BUILTIN, Builtin, fault};
pub use departures::Departure;

pub use design::{
    BinarisationMethod, BinarisationSettings, Layout, ProjectionSettings, StartKind, StartSettings,
    VolumeSettings,
};
pub use field::Named;
pub use layout::LAYOUT_SIDE;
pub use optimisation::{
    AdamSettings, GradientPrecision, GradientSettings, HorizonMode, LossKind, LossSettings,
    MmaSettings, Pass, ScheduleSettings, SelectionKind, SelectionSettings,
};
pub use robot::{
    Contact, ControllerSettings, Integrator, LatticeSettings, MaterialSettings, PhysicsSettings,
    UnstableStep, VoidEdges,
};
pub(crate) use table::allowed_instead;

use serde::Serialize;

#[cfg(test)]
mod tests;

/// A complete experiment. The default is the paper's design b (stability start, flat ground).
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Scene {
    /// The lattice's size and place.
    pub lattice: LatticeSettings,
    /// Time step, forces and ground.
    pub physics: PhysicsSettings,
    /// Library of materials.
    pub materials: MaterialSettings,
    /// Design vector to mixture.
    pub projection: ProjectionSettings,
    /// The neural controller.
    pub controller: ControllerSettings,
    /// The design at the start.
    pub start: StartSettings,
    /// Bounds on the volume fractions.
    pub volume: VolumeSettings,
    /// Which iteration does what.
    pub schedule: ScheduleSettings,
    /// Augmented Lagrangian and attraction.
    pub binarisation: BinarisationSettings,
    /// Optimiser of the design vectors.
    pub mma: MmaSettings,
    /// Optimiser of the controller.
    pub adam: AdamSettings,
    /// Bounds on gradients.
    pub gradient: GradientSettings,
    /// The displacement loss.
    pub loss: LossSettings,
    /// Which iterate is delivered.
    pub selection: SelectionSettings,
    /// What the robot is to do.
    pub objective: ObjectiveSettings,
    /// Scatter of robots and surroundings.
    pub robust: RobustSettings,
    /// Which starts go on.
    pub search: SearchSettings,
}
