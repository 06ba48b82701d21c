//! Makes a case from a robot in a scene.

use super::Case;
use crate::design::{Design, start};
use crate::error::Result;
use crate::lattice::Lattice;
use crate::objective::AugmentedLagrangian;
use crate::policy::Controller;
use crate::projection::Projection;
use crate::scene::Scene;

impl Case {
    /// The robot at the start of an optimisation: the design of the start, in the performance projection, and a random
    /// controller.
    ///
    /// # Errors
    /// If the layout of the scene belongs to another lattice.
    pub fn of_scene(scene: &Scene, seed: u64) -> Result<Self> {
        let lattice = Lattice::new(&scene.lattice, &scene.physics);
        let design = start(&scene.start, &lattice, scene.projection.beta, seed)?;
        let controller = Controller::xavier(&scene.controller, &lattice, seed);
        Ok(Self::of_robot(scene, design, controller))
    }

    /// A design and a controller in a scene, at rest. The thresholds are the final ones of the scene. Multipliers are
    /// zero.
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
            observation: scene.controller.clone(),
            design,
            controller,
            projection: Projection::Performance,
            lagrangian: AugmentedLagrangian::new(scene.binarisation.penalty),
            thresholds: [scene.binarisation.threshold; 4],
            listed_steps: Vec::new(),
        }
    }
}
