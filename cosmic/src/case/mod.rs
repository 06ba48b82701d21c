//! Cases: a robot in a scene, from a given start. [`Case::parse`] reads the file of a case, which `docs/files.md`
//! describes. It holds one rollout with all its numbers, and the expected results: lattice, positions, rest lengths,
//! velocities, design and weights all come from the file. Nothing is generated or assumed.

mod frame;
mod version_1;
mod file;
mod read;
mod results;
mod evaluate;

pub use frame::Frame;
pub use results::{CaseResults, DesignGradient, Gradient};

use crate::design::{Design, start};
use crate::error::{Error, Result};
use crate::lattice::{Lattice, State};
use crate::objective::AugmentedLagrangian;
use crate::policy::Controller;
use crate::projection::Projection;
use crate::scene::{BinarisationSettings, Scene};

/// A robot in a scene. The lengths of its lists fit one another.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// The scene. A case that was read from a file of version 1, such as a reference case, has the paper's settings for the
    /// optimisation.
    pub scene: Scene,
    /// The frame in which the file gives positions; positions of the case itself are in the world's frame. The
    /// [results](CaseResults) of the case are in the frame of its file. A case that is made from a scene has the world's
    /// frame.
    pub frame: Frame,
    /// The lattice. Its initial positions, edges and rest lengths are those of the file.
    pub lattice: Lattice,
    /// Initial positions and velocities.
    pub start: State<f64>,
    /// The design: the layout `materials` of the file if the file has one, otherwise the design vectors `z` (D7).
    pub design: Design<[f64; 3]>,
    /// The controller.
    pub controller: Controller<f64>,
    /// The projection that turns design vectors into mixtures, for the rollout and for the measures.
    pub projection: Projection,
    /// Multipliers and penalties of the augmented objective.
    pub lagrangian: AugmentedLagrangian,
    /// The thresholds of the four measures that the augmented objective bounds.
    pub thresholds: [f64; 4],
    /// The numbers of the steps whose states the file lists as results, ascending. Empty if the file has no results.
    pub listed_steps: Vec<usize>,
}

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
            scene: scene.clone(),
            frame: Frame::default(),
            start: lattice.state_at_rest(),
            lattice,
            design,
            controller,
            projection: Projection::Performance,
            lagrangian: AugmentedLagrangian::new(BinarisationSettings::PENALTY),
            thresholds: [BinarisationSettings::THRESHOLD; 4],
            listed_steps: Vec::new(),
        }
    }

    /// The steps whose states are recorded, ascending and without repetitions. They are the steps in `asked`. If
    /// `asked` is empty, they are the steps that the file lists; if the file lists none, they are 0, 1, 2, 3 and the
    /// last step.
    ///
    /// # Errors
    /// [`Error::Usage`] if a step is beyond the end of the rollout.
    pub fn recorded_steps(&self, asked: &[usize]) -> Result<Vec<usize>> {
        let last = self.scene.physics.steps;
        let mut steps = match (asked, &self.listed_steps[..]) {
            ([], []) => [0, 1, 2, 3, last].map(|step| step.min(last)).to_vec(),
            ([], listed) => listed.to_vec(),
            (asked, _) => asked.to_vec(),
        };
        steps.sort_unstable();
        steps.dedup();
        match steps.last() {
            Some(&step) if step > last => Err(Error::Usage(format!(
                "step {step} cannot be recorded: the rollout has only {last} steps"
            ))),
            _ => Ok(steps),
        }
    }
}
