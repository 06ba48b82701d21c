//! A user's own objective: robots that get far, but do not shake their payload.
//!
//! `cargo run --release -p cosmic-program --example ride -- optimize --out runs/ride`

use std::process::ExitCode;

use autodiff::Real;
use cosmic::objective::Loss;
use cosmic::world::Trajectory;
use cosmic_program::Program;

/// The loss: the mean square of the payload's vertical speed, in m²/s², minus the distance that the payload covers, in
/// metres.
pub(crate) struct Ride;

impl Loss for Ride {
    fn observed(&self, steps: usize) -> Vec<usize> {
        (0..steps).step_by(16).chain([steps]).collect()
    }

    // The payload is always among the nodes of a state, so any other node will do.
    fn nodes(&self) -> usize {
        1
    }

    fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
        let states = 0..trajectory.states.len();
        let speeds = states.map(|k| trajectory.payload(k).v.up());
        let squares: Vec<R> = speeds.map(|speed| speed.powi(2)).collect();
        let [start, end] = [0, squares.len() - 1].map(|k| trajectory.payload(k).x.forward());
        R::sum_of(&squares) * R::lit(1.0 / squares.len() as f64) - (end - start)
    }
}

fn main() -> ExitCode {
    let scene = "base = \"stability\"\n[objective]\nown_loss = \"ride\"";
    Program::new()
        .with_loss("ride", Ride)
        .with_scene("ride", scene)
        .run()
}
