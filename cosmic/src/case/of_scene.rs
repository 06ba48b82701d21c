//! Makes a case from a robot in a scene.

use super::Case;
use crate::design::{Design, start};
use crate::error::Result;
use crate::lattice::Lattice;
use crate::objective::AugmentedLagrangian;
use crate::policy::Controller;
use crate::projection::Projection;
use crate::scene::{BinarisationSettings, Scene};

impl Case {
    /// Makes a case from the robot with which an optimisation of `scene` begins. It has the initial design, in the
    /// performance projection, and a random controller drawn with `seed`.
    ///
    /// # Errors
    /// If the layout in `scene.start` does not fit the lattice.
    pub fn of_scene(scene: &Scene, seed: u64) -> Result<Self> {
        let lattice = Lattice::new(&scene.lattice, &scene.physics);
        let design = start(&scene.start, &lattice, scene.projection.beta, seed)?;
        let controller = Controller::xavier(&scene.controller, &lattice, seed);
        Ok(Self::of_robot(scene, design, controller))
    }

    /// Makes a case from a robot, given by its design and its controller, at rest in `scene`. The thresholds of the
    /// case are the final thresholds of the scene, and its multipliers are zero.
    pub fn of_robot(scene: &Scene, design: Design<[f64; 3]>, controller: Controller<f64>) -> Self {
        let lattice = Lattice::new(&scene.lattice, &scene.physics);
        Self {
            layout: scene.lattice.fitted(lattice.nodes()),
            start: lattice.state_at_rest(),
            lattice,
            physics: scene.physics.clone(),
            materials: scene.materials.clone(),
            sharpness: scene.projection.clone(),
            rules: scene.design.clone(),
            moved: scene.objective.body,
            observation: scene.controller.clone(),
            design,
            controller,
            projection: Projection::Performance,
            lagrangian: AugmentedLagrangian::new(BinarisationSettings::PENALTY),
            thresholds: [BinarisationSettings::THRESHOLD; 4],
            listed_steps: Vec::new(),
        }
    }
}
