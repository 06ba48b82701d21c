//! The gradient of one step of springs, on the tape and through kernels: what `--bench tapes` times.

#[rustfmt::skip]
mod adjoints;
#[cfg(test)]
mod emission;
pub mod kernels;
pub mod step;

use autodiff::Tape;
use step::{EDGES, NODES, SpringLattice};

/// Differentiates the step: its value and gradient. Keeps its memory.
pub type Gradient = Box<dyn FnMut(&SpringLattice, &[f64]) -> (f64, Vec<f64>)>;

/// The step alone, as plain numbers.
pub fn plain() -> Gradient {
    Box::new(|lattice, inputs| (lattice.step(inputs), Vec::new()))
}

/// The step on the tape.
pub fn on_tape() -> Gradient {
    let mut tape = Tape::new();
    Box::new(move |lattice, inputs| {
        let sum = tape.record(inputs, |inputs| lattice.step(inputs));
        (sum.value(), tape.pullback(&[sum], &[1.0]).to_vec())
    })
}

/// Positions, velocities (a few of them into the ground) and stiffness, as for
/// [`SpringLattice::step`](step::SpringLattice::step).
pub fn inputs() -> Vec<f64> {
    let wobble = |i: usize| ((i * 7919) % 97) as f64 / 97.0 - 0.5;
    let node = |i: usize| {
        let (row, column, w) = ((i / 6) as f64, (i % 6) as f64, wobble(i));
        let (x, y) = (0.1 * column + 0.01 * w, 0.1 * row + 3e-4 + 2e-4 * w);
        [x, y, 0.3 * w, -0.4 + 0.2 * w]
    };
    let stiffness = (0..EDGES).map(|e| 100.0 + e as f64);
    (0..NODES).flat_map(node).chain(stiffness).collect()
}
