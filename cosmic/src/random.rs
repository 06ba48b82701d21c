//! Random numbers. There is an independent stream for every seed and purpose.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// The purpose of random numbers. Each purpose has its own stream. So drawing more numbers for one purpose does not
/// change the numbers for others. The number of a purpose selects its stream and must never be reused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Initial weights of a controller.
    Weights = 0,
    /// Perturbed initial states by which the result of a run is chosen.
    Selection = 1,
    /// Perturbed initial states by which the result of a run is judged. They differ from the states by which it was
    /// chosen.
    Judgement = 2,
    /// Perturbed initial states, directions and random lattices for the command `check`.
    Verification = 3,
    /// The side of a tilted initial design that gets less material.
    Tilt = 5,
    /// Random variations of the robot and its surroundings, for gradients and for choosing controllers.
    DomainRandomisation = 6,
    /// Random variations of the robot and its surroundings, for judging robustness.
    Robustness = 7,
    /// The heights of rough ground.
    Terrain = 8,
    /// Small variations of the robot and its surroundings, by which the reliability of a result is judged.
    Variation = 9,
    /// Small variations of the robot and its surroundings, by which robots are ranked during an optimisation.
    Ranking = 10,
    /// Goals of the rollouts that gradients are computed from.
    Goals = 11,
    /// Sequences of goals by which robots are ranked, chosen and judged.
    Errands = 12,
    /// Random variations of the robots with which a controller learns in windows.
    Windows = 13,
    /// Bootstrap resampling, to estimate the uncertainty of statistics.
    Bootstrap = 16,
    /// Changes of robots in an evolution.
    Mutation = 17,
}

/// The stream of random numbers for a seed and a purpose. It is the same on every platform.
pub fn stream(seed: u64, purpose: Purpose) -> ChaCha8Rng {
    stream_of(seed, purpose, 0)
}

/// One of the many streams for a seed and a purpose, given by its number. Number 0 is the stream of [`stream`].
pub(crate) fn stream_of(seed: u64, purpose: Purpose, number: u64) -> ChaCha8Rng {
    let mut key = [0; 32];
    key[..8].copy_from_slice(&seed.to_le_bytes());
    key[8..16].copy_from_slice(&number.to_le_bytes());
    let mut stream = ChaCha8Rng::from_seed(key);
    stream.set_stream(purpose as u64);
    stream
}

/// Draws a number uniformly from `[-limit, limit)`.
pub fn symmetric(stream: &mut ChaCha8Rng, limit: f64) -> f64 {
    (2.0 * stream.random::<f64>() - 1.0) * limit
}
