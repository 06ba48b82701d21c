//! Scenes: all numbers of an experiment, as plain data in one small struct per section.
//!
//! A function takes only the section that it needs. Only a function that reads many sections takes the whole [`Scene`].
//! Units are SI. "Paper silent" marks a value that the paper does not give.
//!
//! [`settings!`](crate::settings!) declares every key once, with type, default, range, unit, source and meaning. The
//! reader of scenes, the commented template and the tables of keys in the documentation are made from these
//! declarations. The declared defaults are the values of the paper; they form the scene `stability`. Every other scene
//! lists its differences from its [`Base`].
//!
//! The folder `sections` declares the keys. `derived` has what follows from them, `checks` finds contradictions and
//! probable mistakes, and `text` reads and writes scenes. The order of the `mod` lines is the architecture: a file imports only
//! files above it.

mod sections;
mod base;
mod diagnostic;
mod keys;
mod departures;
mod derived;
mod checks;
mod fit;
mod text;
mod builtin;

pub use base::Base;
pub use builtin::{BUILTIN, Builtin};
pub use checks::Finding;
pub use departures::Departure;
pub use derived::{AnyDesign, DataSheet, DeviceLength, Riser, phase_limit, stable_step};
pub(crate) use derived::{SLENDERNESS, STABLE_SHARE, stable_step_off_bars};
pub use keys::{Setting, reference};
pub use sections::{
    ActuatorPart, AdamSettings, BarNumbers, BinarisationMethod, BinarisationSettings, ClockKind,
    ControllerSettings, DesignSettings, GoalKind, GoalsSettings, GradientPrecision,
    GradientSettings, GroundSettings, Integrator, ItemName, LatticeKind, LatticeSettings, Layout,
    LossKind, LossSettings, MaterialSettings, MovedBody, ObjectiveSettings, PartMaterial,
    PartsSettings, PhysicsSettings, ProfileKind, ProjectionSettings, RobustSettings, Scatter,
    ScheduleSettings, SelectionKind, SelectionSettings, Senses, SkeletonPart, StartKind,
    StartSettings, StockMaterial, TaskKind, TrussFile, UnstableStep, VoidEdges, VolumeSettings,
    edges,
};
pub(crate) use sections::{LAYOUT_SIDE, MOST_SUBSTEPS, places};
pub(crate) use text::JsonSetting;
pub use text::TomlFile;

use crate::settings;
pub use crate::settings::Named;

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
