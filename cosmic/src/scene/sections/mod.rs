//! The settings of a scene, one struct per section, and what they describe directly: a truss, a lattice, a layout.

mod truss_file;
mod terrain;
mod item_name;
mod materials;
mod robot;
mod generator;
mod design;
mod layout;
mod optimisation;
mod beyond;

pub use beyond::{GoalsSettings, MovedBody, ObjectiveSettings, RobustSettings, Scatter, TaskKind};
pub use design::{
    BinarisationMethod, BinarisationSettings, DesignSettings, Layout, ProjectionSettings,
    StartKind, StartSettings, VolumeSettings,
};
pub use generator::edges;
pub(crate) use generator::places;
pub use item_name::ItemName;
pub(crate) use layout::LAYOUT_SIDE;
pub use materials::{
    ActuatorPart, BarNumbers, MaterialSettings, PartMaterial, PartsSettings, SkeletonPart,
    StockMaterial,
};
pub use optimisation::{
    AdamSettings, GradientPrecision, GradientSettings, LossKind, LossSettings, ScheduleSettings,
    SelectionKind, SelectionSettings,
};
pub(crate) use robot::MOST_SUBSTEPS;
pub use robot::{
    ClockKind, ControllerSettings, GoalKind, Integrator, LatticeKind, LatticeSettings,
    PhysicsSettings, Senses, UnstableStep, VoidEdges,
};
pub(super) use terrain::MOST_STEPS;
pub use terrain::{GroundSettings, ProfileKind};
pub use truss_file::TrussFile;
