//! A robot of a scene as a case.

use super::Case;
use crate::design::{Design, start};
use crate::error::Result;
use crate::lattice::Lattice;
use crate::objective::AugmentedLagrangian;
use crate::policy::Controller;
use crate::projection::Projection;
use crate::scene::Scene;

impl Case {
    /// The robot that a scene starts from: the start's design, in the performance projection, and a
    /// controller drawn from a seed.
    ///
    /// # Errors
    /// Where the scene's layout is drawn for another lattice.
    pub fn of_scene(scene: &Scene, seed: u64) -> Result<Self> {
        let lattice = Lattice::new(&scene.lattice, &scene.physics);
        let design = start(&scene.start, &lattice, scene.projection.beta, seed)?;
        let controller = Controller::xavier(&scene.controller, &lattice, seed);
        Ok(Self::of_robot(scene, design, controller))
    }

    /// A design and a controller in a scene, at rest. Thresholds are those that the scene comes down to,
    /// multipliers are zero.
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
