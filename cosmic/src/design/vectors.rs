//! Operations on design vectors, the variables of the design's optimiser.

use super::{Material, Mixture};

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

#[cfg(test)]
mod tests {
    use super::{attract, vectors_of_mixture};
    use crate::design::Mixture;

    #[test]
    fn vectors_keep_the_ratios_of_the_mixture() {
        let [z] = vectors_of_mixture(&[Mixture([0.6, 0.3, 0.1])], 20.0)[..] else {
            panic!("expected one edge")
        };
        // exp(20 x) multiplies the rounding error of z, 1e-16, by 20.
        let ratio = |k: usize, l: usize| (20.0 * (z[k] - z[l])).exp();
        assert!((ratio(0, 1) - 2.0).abs() < 1e-13 && (ratio(0, 2) - 6.0).abs() < 1e-13);
        assert!((z.iter().sum::<f64>() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn attraction_moves_edges_with_a_clear_material_within_the_range() {
        let mut z = [[0.5, 0.3, 0.2], [0.4, 0.4, 0.2], [0.0, 0.999, 0.001]];
        let mixtures = [[0.95, 0.04, 0.01], [0.5, 0.49, 0.01], [0.0, 1.0, 0.0]].map(Mixture);
        attract(&mut z, &mixtures, 0.9, 0.004);
        assert_eq!(z[0], [0.5 + 0.004, 0.3 - 0.002, 0.2 - 0.002]);
        assert_eq!(z[1], [0.4, 0.4, 0.2]);
        assert_eq!(z[2], [0.0, 1.0, 0.0]);
    }
}
