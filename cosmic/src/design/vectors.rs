//! Operations on design vectors, the variables of the design's optimiser.

use autodiff::Real;

use super::{Material, Mixture};
use crate::geometry::mean;

/// The design vectors that give these mixtures after the performance projection with sharpness `beta`: `z_k = 1/3 + (ln
/// m_k - mean ln m) / beta`, clamped to `[0, 1]`. All shares must be above 0.
pub(super) fn vectors_of_mixture(mixtures: &[Mixture<f64>], beta: f64) -> Vec<[f64; 3]> {
    let vector = |m: &Mixture<f64>| {
        let log = m.0.map(f64::ln);
        let mean = (log[0] + log[1] + log[2]) / 3.0;
        log.map(|l| 1.0 / 3.0 + (l - mean) / beta)
    };
    let mut z: Vec<_> = mixtures.iter().map(vector).collect();
    clamp(&mut z);
    z
}

/// Gives the edges of each group in `ties` the mean of their design vectors.
pub(crate) fn average_tied<R: Real>(z: &mut [[R; 3]], ties: &[Vec<usize>]) {
    for tie in ties {
        let own: Vec<[R; 3]> = tie.iter().map(|&edge| z[edge]).collect();
        let shared = mean(&own).array();
        tie.iter().for_each(|&edge| z[edge] = shared);
    }
}

/// Clamps every entry to `[0, 1]`.
pub fn clamp(z: &mut [[f64; 3]]) {
    for entry in z.as_flattened_mut() {
        *entry = entry.clamp(0.0, 1.0);
    }
}

/// One step of attraction. If the largest share in an edge's mixture exceeds `confidence`, the material with that share
/// is favoured: its entry in the design vector grows by `nudge`, and the other two entries fall by `nudge / 2` each.
/// Entries stay within `[0, 1]`.
pub fn attract(z: &mut [[f64; 3]], mixtures: &[Mixture<f64>], confidence: f64, nudge: f64) {
    for (vector, mixture) in z.iter_mut().zip(mixtures) {
        let chosen = mixture.dominant();
        if mixture[chosen] > confidence {
            for (material, entry) in Material::ALL.into_iter().zip(vector) {
                *entry += if material == chosen {
                    nudge
                } else {
                    -0.5 * nudge
                };
            }
        }
    }
    clamp(z);
}
