//! Scenes: every number of an experiment, as plain data in one small struct per consumer.
//!
//! A function takes the section it needs; only the co-design and what stands above it see the whole
//! [`Scene`]. Units are SI. "Paper silent" marks a value that the paper leaves open.
//!
//! `settings!` declares every key once: type, default, range, unit, source and meaning. The reader,
//! the commented template and the tables in `docs/files.md` follow from the declarations. The order of
//! `mod` is the architecture: a file imports files above it.

mod limits;
mod pass;
mod value;
mod field;
mod settings;
mod robot;
mod design;
mod optimisation;
mod beyond;
mod layout;
mod keys;
mod departures;
mod doubts;
mod check;
mod diagnostic;
mod read;
mod write;
mod builtin;

pub use beyond::{ObjectiveSettings, RobustSettings, SearchSettings, TaskKind};
pub use builtin::{BUILTIN, Builtin, fault};
pub use departures::Departure;
pub use doubts::Finding;

pub use design::{
    BinarisationMethod, BinarisationSettings, Layout, ProjectionSettings, StartKind, StartSettings,
    VolumeSettings,
};
pub(crate) use keys::allowed_instead;
pub use keys::{Setting, reference};
pub(crate) use layout::LAYOUT_SIDE;
pub use optimisation::{
    AdamSettings, GradientPrecision, GradientSettings, HorizonMode, LossKind, LossSettings,
    MmaSettings, ScheduleSettings, SelectionKind, SelectionSettings,
};
pub use pass::Pass;
pub use robot::{
    Contact, ControllerSettings, Integrator, LatticeSettings, MaterialSettings, PhysicsSettings,
    UnstableStep, VoidEdges,
};
pub use value::Named;

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
