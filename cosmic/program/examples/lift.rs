//! A user's own objective: robots that carry their payload high.
//!
//! `cargo run --release -p cosmic-program --example lift -- optimize --iterations 8 --out runs/lift`

use std::process::ExitCode;

use autodiff::Real;
use cosmic::objective::Loss;
use cosmic::simulator::Trajectory;
use cosmic_program::Program;

/// The loss: minus the payload's mean height over the second half of the rollout, in metres.
struct Lift;

impl Loss for Lift {
    fn observed(&self, steps: usize) -> Vec<usize> {
        (steps / 2..steps).step_by(32).chain([steps]).collect()
    }

    fn nodes(&self) -> usize {
        1
    }

    fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
        let observed = self.observed(trajectory.last_step());
        let height = |&step: &usize| trajectory.at(step).x[0].up();
        let heights: Vec<R> = observed.iter().map(height).collect();
        R::sum_of(&heights) * R::lit(-1.0 / heights.len() as f64)
    }
}

fn main() -> ExitCode {
    let scene = "base = \"stability\"\n[objective]\nown_loss = \"lift\"";
    Program::new()
        .with_loss("lift", Lift)
        .scene("lift", scene)
        .run()
}
