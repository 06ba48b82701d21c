//! A policy without feedback (open loop): every bar has its own rhythm.
//!
//! `cargo run --release -p cosmic-program --example rhythm -- optimize --iterations 8 --out runs/rhythm`

use std::process::ExitCode;

use autodiff::{Array, Kernel, Real};
use cosmic::policy::{Block, Policy, PolicyStep, Sizes};
use cosmic_program::Program;

/// The policy: every edge has the activation `tanh(a sin(omega t) + b cos(omega t) + c)` with its own numbers `a`, `b`
/// and `c`.
#[derive(Debug)]
struct Rhythm;

#[derive(Clone)]
struct Wave;

impl Kernel<5, 1> for Wave {
    #[inline(always)]
    fn eval<R: Real>(&self, [sin, cos, a, b, c]: [R; 5]) -> [R; 1] {
        [(a * sin + b * cos + c).tanh()]
    }
}

impl Policy for Rhythm {
    fn parameters(&self, robot: &Sizes) -> Vec<Block> {
        vec![
            Block::drawn("sine", robot.edges, 4.0),
            Block::drawn("cosine", robot.edges, 4.0),
            Block::biases("shift", robot.edges),
        ]
    }

    fn record(&self, step: &mut PolicyStep) -> Array {
        let clock = step.clock();
        let [sin, cos] = [0, 1].map(|k| step.for_every_edge(clock, k));
        let [a, b, c] = ["sine", "cosine", "shift"].map(|name| step.per_edge(name));
        step.program().map(Wave, [sin, cos, a, b, c])[0]
    }
}

fn main() -> ExitCode {
    let scene = "base = \"stability\"\n[controller]\npolicy = \"rhythm\"";
    Program::new()
        .with_policy("rhythm", Rhythm)
        .scene("rhythm", scene)
        .run()
}
