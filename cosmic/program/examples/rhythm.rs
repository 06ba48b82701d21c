//! Two policies: every bar has its own rhythm, without and with a reflex to what the bar feels.
//!
//! `cargo run --release -p cosmic-program --example rhythm -- optimize --iterations 8 --out runs/rhythm`

use std::process::ExitCode;

use autodiff::Real;
use autodiff_programs::{Array, Kernel};
use cosmic::kernel;
use cosmic::policy::{Block, Policy, PolicyStep, Sizes};
use cosmic_program::Program;

/// The policy without feedback (open loop): every edge has the activation `tanh(a sin(omega t) + b cos(omega t) + c)` with
/// its own numbers `a`, `b` and `c`.
#[derive(Debug)]
struct Rhythm;

#[derive(Clone)]
struct Wave;

#[kernel]
impl Kernel<5, 1> for Wave {
    fn eval<R: Real>(&self, [sin, cos, a, b, c]: [R; 5], _: &[R]) -> [R; 1] {
        [(a * sin + b * cos + c).tanh()]
    }
}

fn blocks(robot: &Sizes) -> Vec<Block> {
    vec![
        Block::drawn("sine", robot.edges, 4.0),
        Block::drawn("cosine", robot.edges, 4.0),
        Block::biases("shift", robot.edges),
    ]
}

impl Policy for Rhythm {
    fn parameters(&self, robot: &Sizes) -> Vec<Block> {
        blocks(robot)
    }

    fn record(&self, step: &mut PolicyStep) -> Array {
        let clock = step.clock();
        let [sin, cos] = [0, 1].map(|k| step.for_every_edge(clock, k));
        let [a, b, c] = ["sine", "cosine", "shift"].map(|name| step.per_edge(name));
        step.program().map(Wave, [sin, cos, a, b, c], &[])[0]
    }
}

/// The policy with reflexes: to the sum of [`Rhythm`] it adds `d` times what the bar [feels](Feel) of its length, and `e`
/// times what it feels of the ground. Each edge has its own numbers `d` and `e`.
#[derive(Debug)]
struct Reflex;

/// What a bar feels, from the positions of its ends and its rest length (m): how much longer it is than at rest, in
/// tenths of its rest length, and for each end a number that is 1 on the ground and fades within a centimetre above it.
#[derive(Clone)]
struct Feel;

#[kernel]
impl Kernel<5, 2> for Feel {
    fn eval<R: Real>(&self, [x0, y0, x1, y1, rest]: [R; 5], _: &[R]) -> [R; 2] {
        let ([dx, dy], tiny) = ([x1 - x0, y1 - y0], R::lit(1e-6));
        let length = (dx * dx + dy * dy + tiny).sqrt();
        let touch = (R::lit(-100.0) * y0).exp() + (R::lit(-100.0) * y1).exp();
        [R::lit(10.0) * (length - rest) / (rest + tiny), touch]
    }
}

#[derive(Clone)]
struct WaveWithReflex;

#[kernel]
impl Kernel<9, 1> for WaveWithReflex {
    fn eval<R: Real>(&self, [sin, cos, a, b, c, d, e, stretch, touch]: [R; 9], _: &[R]) -> [R; 1] {
        [(a * sin + b * cos + c + d * stretch + e * touch).tanh()]
    }
}

impl Policy for Reflex {
    fn parameters(&self, robot: &Sizes) -> Vec<Block> {
        let reflexes = ["stretch", "touch"].map(|name| Block::biases(name, robot.edges));
        blocks(robot).into_iter().chain(reflexes).collect()
    }

    fn record(&self, step: &mut PolicyStep) -> Array {
        let clock = step.clock();
        let [sin, cos] = [0, 1].map(|k| step.for_every_edge(clock, k));
        let [tail, head] = step.ends().map(|end| end.x.array::<2>());
        let rest = step.rest_lengths();
        let inputs = [tail[0], tail[1], head[0], head[1], rest];
        let [stretch, touch] = step.program().map(Feel, inputs, &[]);
        let names = ["sine", "cosine", "shift", "stretch", "touch"];
        let [a, b, c, d, e] = names.map(|name| step.per_edge(name));
        let inputs = [sin, cos, a, b, c, d, e, stretch, touch];
        step.program().map(WaveWithReflex, inputs, &[])[0]
    }
}

fn main() -> ExitCode {
    let scene = "base = \"stability\"\n[controller]\npolicy = \"rhythm\"";
    Program::new()
        .with_policy("rhythm", Rhythm)
        .with_policy("reflex", Reflex)
        .with_scene("rhythm", scene)
        .run()
}
