//! Scenes: all numbers of an experiment, as plain data in one small struct per section.
//!
//! A function takes only the section that it needs. Only what reads many sections takes the whole [`Scene`]. Units are SI. "Paper silent" marks a value that the paper does not give.
//!
//! [`settings!`](crate::settings!) declares every key once, with type, default, range, unit, source and meaning. The
//! reader of scenes, the commented template and the tables of keys in the documentation are made from these
//! declarations. The declared defaults are the values of the paper; they form the scene `stability`. Every other scene
//! lists its differences from its [`Base`]. The order of the `mod` lines is the architecture: a file imports only files
//! above it.

mod truss_file;
mod terrain;
mod item_name;
mod materials;
mod robot;
mod generator;
mod stable_step;
mod any_design;
mod design;
mod optimisation;
mod beyond;
mod layout;
mod base;
mod keys;
mod follow;
mod departures;
mod unread;
mod world;
mod data_sheet;
mod margins;
mod warnings;
mod check;
mod fit;
mod diagnostic;
mod read;
mod toml_file;
mod whole;
mod json;
mod write;
mod builtin;

pub use any_design::AnyDesign;
pub use base::Base;
pub use beyond::{GoalsSettings, MovedBody, ObjectiveSettings, RobustSettings, Scatter, TaskKind};
pub use builtin::{BUILTIN, Builtin};
pub use departures::Departure;
pub use item_name::ItemName;
pub use warnings::Finding;

pub use crate::settings::Named;
pub(crate) use data_sheet::SLENDERNESS;
pub use data_sheet::{DataSheet, DeviceLength};
pub use design::{
    BinarisationMethod, BinarisationSettings, DesignSettings, Layout, ProjectionSettings,
    StartKind, StartSettings, VolumeSettings,
};
pub use generator::edges;
pub(crate) use generator::places;
pub(crate) use json::Given;
pub use keys::{Setting, reference};
pub(crate) use layout::LAYOUT_SIDE;
pub use margins::Riser;
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

pub(crate) use stable_step::stable_step_off_bars;
pub use stable_step::{phase_limit, stable_step};
pub use terrain::{GroundSettings, ProfileKind};
pub use toml_file::TomlFile;
pub use truss_file::TrussFile;

use crate::settings;

settings! {
    /// A complete experiment. The default is the built-in scene `earth`.
    scene Scene over Base {
        /// The size and the place of the lattice.
        lattice: LatticeSettings;
        /// Time step, forces and ground.
        physics: PhysicsSettings;
        /// The library of materials.
        materials: MaterialSettings;
        /// The projections from design vectors to mixtures.
        projection: ProjectionSettings;
        /// The controller.
        controller: ControllerSettings;
        /// The design at the start.
        start: StartSettings;
        /// Requirements on layouts.
        design: DesignSettings;
        /// Bounds on the volume fractions.
        volume: VolumeSettings, read "if the initial design is not a layout" if Scene::designs;
        /// What each iteration does.
        schedule: ScheduleSettings;
        /// The augmented Lagrangian and the attraction.
        binarisation: BinarisationSettings, read "if the initial design is not a layout" if Scene::designs;
        /// The optimiser of the controller.
        adam: AdamSettings;
        /// Bounds on gradients.
        gradient: GradientSettings;
        /// The displacement loss.
        loss: LossSettings, read "without an `own_loss`" if Scene::has_task;
        /// The choice of the iterate that is delivered.
        selection: SelectionSettings;
        /// The task of the robot.
        objective: ObjectiveSettings;
        /// Random variation of robots and surroundings.
        robust: RobustSettings;
        /// How goals are drawn.
        goals: GoalsSettings, read "if goals are given" if |s: &Scene| s.controller.goals == GoalKind::Given;
    }
}
