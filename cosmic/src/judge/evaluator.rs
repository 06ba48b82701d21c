//! The evaluator of a scene: it has the world, the loss and the start of the scene.

use std::sync::Arc;

use crate::design::{Design, Mixture};
use crate::error::Result;
use crate::lattice::{Lattice, State};
use crate::objective::AnyLoss;
use crate::projection::Projection;
use crate::scene::Scene;
use crate::world::{Span, StepCheck, World};

/// Evaluates robots of one scene: simulates them, differentiates their losses and measures their displacement. It has
/// no state that changes between evaluations.
#[derive(Clone)]
pub struct Evaluator {
    /// The scene.
    pub scene: Scene,
    /// The world of the scene.
    pub world: World,
    /// The loss of a rollout.
    pub loss: Arc<dyn AnyLoss>,
    /// The unperturbed start.
    pub start: State<f64>,
    /// What all rollouts have in common: the memory that gradients may use, the flag that stops rollouts, and whether robots
    /// have feedback. Its steps are not read.
    pub(crate) rollouts: Span,
    /// The time step, s, below which every design of the lattice is stable.
    stable_step_of_any_design: f64,
}

impl Evaluator {
    /// Creates the evaluator of a scene for the given loss.
    ///
    /// # Errors
    /// The errors of [`Scene::check`].
    pub fn new(scene: &Scene, loss: Arc<dyn AnyLoss>) -> Result<Self> {
        // A run writes its scene and reads it again, so the scene must be valid as a file.
        scene.check()?;
        let lattice = Lattice::new(&scene.lattice, &scene.physics);
        let start = lattice.state_at_rest();
        let world = World::new(lattice, scene);
        Ok(Self {
            stable_step_of_any_design: world.stable_step_of_any_design(scene.robust.faster()),
            loss,
            start,
            world,
            rollouts: Span {
                memory: scene.gradient.budget(),
                ..Span::of_steps(0)
            },
            scene: scene.clone(),
        })
    }

    /// A copy of this evaluator that simulates robots in another world, such as one with shorter time steps.
    pub(crate) fn in_world(&self, world: World) -> Self {
        Self {
            world,
            ..self.clone()
        }
    }

    /// A copy of this evaluator for robots without feedback, which see the unperturbed start in every step.
    #[must_use]
    pub fn in_open_loop(&self) -> Self {
        let mut other = self.clone();
        other.rollouts.open_loop = Some(self.start.clone());
        other
    }

    /// True if robots are ranked by their displacement; see [`Loss::is_far`](crate::objective::Loss::is_far).
    pub fn is_far(&self) -> bool {
        self.loss.is_far()
    }

    /// The form of a design that is simulated: its design vectors after the performance projection, or its layout (D7).
    pub fn simulated(&self, design: &Design<[f64; 3]>) -> Design<Mixture<f64>> {
        (self.world.projector()).projected(Projection::Performance, design)
    }

    /// Compares the time step with the vibrations of a design. Random variations of the robot, which domain
    /// randomisation may draw, are included.
    pub(crate) fn step_check_of(&self, design: &Design<Mixture<f64>>) -> StepCheck {
        let (faster, any_design) = (self.scene.robust.faster(), self.stable_step_of_any_design);
        (self.world).step_check(design, &self.start.x, faster, any_design)
    }
}
