//! The review of a scene before it is optimised: errors and warnings.

use serde::Serialize;

use super::begin::CoDesign;
use crate::error::Result;
use crate::scene::{Finding, Scene};

/// The errors and warnings about a scene.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Review {
    /// The errors with which an optimisation of the scene would refuse to begin.
    pub refusals: Vec<Finding>,
    /// The warnings that an optimisation gives at its start, and settings that are probably a mistake.
    pub warnings: Vec<Finding>,
}

impl Review {
    /// Checks the scene as [`CoDesign::begin`] does for a seed, but draws no controller. An unstable time step is
    /// reported in `refusals`.
    ///
    /// # Errors
    /// The errors of [`CoDesign::new`]; [`Error::Usage`](crate::Error::Usage) if the initial design is a layout for
    /// another lattice.
    pub fn new(scene: &Scene, seed: u64) -> Result<Self> {
        const STEP: [&str; 2] = ["physics.dt", "physics.substeps"];
        let check = CoDesign::new(scene)?.step_check_at_start(seed)?;
        let (mut refusals, mut warnings) = (Vec::new(), scene.warnings());
        match check.accept(&scene.physics) {
            Err(error) => {
                let remedy = error.remedy().unwrap_or_default();
                refusals.push(Finding::new(scene, &STEP, error.without_remedy(), remedy));
            }
            Ok(()) => {
                let step = [check.of_other_designs(), Some(check.to_string())];
                let step = step.into_iter().flatten().filter(|says| !says.is_empty());
                warnings.extend(step.map(|says| Finding::new(scene, &STEP, says, String::new())));
            }
        }
        Ok(Review { refusals, warnings })
    }
}
