//! `cosmic gradcheck`.

use crate::arguments::{seed, whole};
use crate::output::print;
use crate::source::{Source, SourceArguments};
use autodiff::check::Options;
use clap::Args;
use cosmic::Registry;
use cosmic::error::{Error, Result};
use cosmic_lab::verify::check_gradients;

/// Compare the gradient with finite differences and forward mode
///
/// The loss is that of the scene; a design uses the scene beside it. For a reference case the loss is the displacement
/// of the payload after the last step.
///
/// A robot that stands still has no gradient, because its feet stick to the ground. Then the slopes are those of the
/// same robot thrown up and forward, and the output says so. If a group of parameters has no gradient even then, nothing
/// could be compared, and the check fails.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    robot: SourceArguments,
    /// Maximum number of steps of the rollout. The motion is chaotic, so finite differences are meaningless over
    /// thousands of steps
    #[arg(long, value_name = "N", default_value_t = 256)]
    steps: usize,
    /// Number of random directions in each group of parameters
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = whole(1..=u16::MAX), allow_negative_numbers = true)]
    directions: u16,
    /// Seed of the random directions
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = seed, allow_negative_numbers = true)]
    seed: u64,
}

impl Arguments {
    pub(super) fn run(&self, registry: &Registry) -> Result<()> {
        let Source { mut case, scene } = self.robot.read(registry)?;
        case.physics.steps = self.steps.min(case.physics.steps);
        if let Some(divergence) = case.divergence() {
            return Err(Error::from(&divergence));
        }
        let options = Options {
            directions: self.directions.into(),
            seed: self.seed,
            // Near a contact, the slope is constant only over less than a nanometre, so differences need such short
            // steps.
            smallest_step: 1e-12,
            ..Options::default()
        };
        let check = check_gradients(&case, scene.as_ref(), self.steps, &options);
        let (name, steps) = (&self.robot.source, check.steps);
        let of = scene.map_or("the displacement", |_| "its scene's loss");
        print(&format!(
            "gradient of {name} over {steps} steps, of {of} (the motion is chaotic: over thousands of steps \
             finite differences are meaningless)\n{check}\n"
        ))?;
        let failures = check.failures();
        if failures.is_empty() {
            return Ok(());
        }
        Err(Error::CheckFailed {
            what: failures.join(", "),
            failed: failures.len(),
            total: check.total(),
        })
    }
}
