//! The gradient of one step of springs, on our tape, on those of other crates and through our
//! kernels: what `--bench tapes` times.

#[rustfmt::skip]
mod adjoints;
#[cfg(test)]
mod emission;
pub mod kernels;
pub mod rivals;
pub mod step;

use step::{EDGES, NODES};

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
