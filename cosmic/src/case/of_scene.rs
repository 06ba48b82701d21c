//! A robot of a scene as a case.

use super::Case;
use crate::design::{Material, layout_materials, start_vectors};
use crate::error::Result;
use crate::lattice::Lattice;
use crate::objective::AugmentedLagrangian;
use crate::policy::Controller;
use crate::projection::Projection;
use crate::scene::{Scene, StartKind};

impl Case {
    /// The robot that a scene starts from: its start's design through the performance projection, or
    /// exactly one-hot if that is a layout, and a controller drawn from a seed.
    ///
    /// # Errors
    /// Where the scene's layout is drawn for another lattice.
    pub fn of_scene(scene: &Scene, seed: u64) -> Result<Self> {
        let lattice = Lattice::new(&scene.lattice, &scene.physics);
        let z = start_vectors(&scene.start, &lattice, scene.projection.beta, seed)?;
        let frozen = match scene.start.kind {
            StartKind::Layout => Some(layout_materials(scene.start.layout, &lattice)?),
            _ => None,
        };
        let controller = Controller::xavier(&scene.controller, &lattice, seed);
        Ok(Self::of_robot(scene, z, frozen, controller))
    }

    /// A design and a controller in a scene, at rest; the layout where it is frozen. Thresholds
    /// are those that the scene comes down to, multipliers zero.
    pub fn of_robot(
        scene: &Scene,
        z: Vec<[f64; 3]>,
        frozen: Option<Vec<Material>>,
        controller: Controller<f64>,
    ) -> Self {
        let lattice = Lattice::new(&scene.lattice, &scene.physics);
        Self {
            layout: scene.lattice.fitted(lattice.nodes()),
            start: lattice.state_at_rest(),
            lattice,
            physics: scene.physics.clone(),
            materials: scene.materials.clone(),
            sharpness: scene.projection.clone(),
            design: scene.design.clone(),
            observation: scene.controller.clone(),
            z,
            frozen,
            controller,
            projection: Projection::Performance,
            lagrangian: AugmentedLagrangian::new(scene.binarisation.penalty),
            thresholds: [scene.binarisation.threshold; 4],
            listed_steps: Vec::new(),
        }
    }
}
