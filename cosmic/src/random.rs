//! Random numbers: one independent stream for every seed and purpose.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// What random numbers are drawn for. Each purpose has its own stream, so that drawing more for one
/// changes nothing for another. The stream follows from the purpose's number, which is therefore
/// never given to another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Initial weights of a controller.
    Weights = 0,
    /// Perturbed starts by which results are chosen.
    Selection = 1,
    /// Perturbed starts by which results are judged: never those that chose them.
    Judgement = 2,
    /// Perturbed starts and directions of a verification, and lattices that it makes up.
    Verification = 3,
    /// The side towards which a start thins out.
    Tilt = 5,
    /// Robots and surroundings around the nominal ones: for gradients, and to choose controllers
    /// by.
    DomainRandomisation = 6,
    /// Robots and surroundings by which robustness is judged.
    Robustness = 7,
    /// Heights of rough ground.
    Terrain = 8,
    /// Samples drawn again from a sample, to see how far its statistics are to be trusted.
    Bootstrap = 16,
}

/// The stream of a seed and a purpose, the same on every platform.
pub fn stream(seed: u64, purpose: Purpose) -> ChaCha8Rng {
    stream_of(seed, purpose, 0)
}

/// One of many streams of a seed and a purpose, by its number; that of 0 is [`stream`]'s.
pub fn stream_of(seed: u64, purpose: Purpose, number: u64) -> ChaCha8Rng {
    let mut key = [0; 32];
    key[..8].copy_from_slice(&seed.to_le_bytes());
    key[8..16].copy_from_slice(&number.to_le_bytes());
    let mut stream = ChaCha8Rng::from_seed(key);
    stream.set_stream(purpose as u64);
    stream
}

/// A number drawn uniformly from `[-limit, limit)`.
pub fn symmetric(stream: &mut ChaCha8Rng, limit: f64) -> f64 {
    (2.0 * stream.random::<f64>() - 1.0) * limit
}

#[cfg(test)]
mod tests {
    use super::{Purpose, stream, symmetric};

    #[test]
    fn streams_repeat_and_differ() {
        let draw = |seed, purpose| {
            let mut stream = stream(seed, purpose);
            [(); 4].map(|()| symmetric(&mut stream, 1.0))
        };
        assert_eq!(draw(7, Purpose::Weights), draw(7, Purpose::Weights));
        assert_ne!(draw(7, Purpose::Weights), draw(8, Purpose::Weights));
        assert_ne!(draw(7, Purpose::Selection), draw(7, Purpose::Judgement));
    }

    #[test]
    fn draws_fill_their_range() {
        let mut stream = stream(0, Purpose::Weights);
        let draws: Vec<f64> = (0..4000).map(|_| symmetric(&mut stream, 0.5)).collect();
        assert!(draws.iter().all(|x| x.abs() <= 0.5));
        // The standard deviation of the mean of 4000 draws is 0.5 / sqrt(3 * 4000) = 0.0046.
        assert!(draws.iter().sum::<f64>().abs() / 4000.0 < 0.02);
        assert!(draws.iter().any(|&x| x > 0.49) && draws.iter().any(|&x| x < -0.49));
    }
}
