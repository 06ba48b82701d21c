//! Materials, and design vectors of them.

use serde::{Deserialize, Serialize};

/// The material of an edge; 0, 1 and 2 in files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "u8", into = "u8")]
pub enum Material {
    /// Next to nothing: the edge is left out of the robot.
    Void = 0,
    /// Stiff and passive.
    Skeleton = 1,
    /// Soft and heavy, changes its length on command.
    Actuator = 2,
}

impl Material {
    /// All of them, in the order of a design vector's entries.
    pub const ALL: [Self; 3] = [Self::Void, Self::Skeleton, Self::Actuator];

    /// Whether the edge counts in the volume.
    pub fn is_solid(self) -> bool {
        self != Self::Void
    }
}

impl From<Material> for u8 {
    fn from(material: Material) -> u8 {
        material as u8
    }
}

impl TryFrom<u8> for Material {
    type Error = String;

    fn try_from(number: u8) -> Result<Self, String> {
        let material = Self::ALL.get(usize::from(number)).copied();
        material
            .ok_or_else(|| format!("{number} is no material: 0 is void, 1 skeleton, 2 actuator"))
    }
}

/// The material with the largest entry; at a tie the first of them.
pub fn dominant(vector: &[f64; 3]) -> Material {
    let larger = |best: usize, k: usize| if vector[k] > vector[best] { k } else { best };
    Material::ALL[larger(larger(0, 1), 2)]
}

/// Design vectors of a layout: one in the entry of its material, zero in the others.
pub fn one_hot(materials: &[Material]) -> Vec<[f64; 3]> {
    let vector = |&material| Material::ALL.map(|m| f64::from(u8::from(m == material)));
    materials.iter().map(vector).collect()
}

/// Design vectors whose performance projection is the given mixture, for entries above zero:
/// `z_k = 1/3 + (ln m_k - mean ln m) / beta`, clamped to `[0, 1]`.
pub fn vectors_of_mixture(mixture: &[[f64; 3]], beta: f64) -> Vec<[f64; 3]> {
    let vector = |m: &[f64; 3]| {
        let log = m.map(f64::ln);
        let mean = (log[0] + log[1] + log[2]) / 3.0;
        log.map(|l| 1.0 / 3.0 + (l - mean) / beta)
    };
    let mut z: Vec<_> = mixture.iter().map(vector).collect();
    clamp(&mut z);
    z
}

/// Brings every entry back into `[0, 1]`.
pub fn clamp(z: &mut [[f64; 3]]) {
    for entry in z.as_flattened_mut() {
        *entry = entry.clamp(0.0, 1.0);
    }
}

/// One step of attraction: where the largest entry of an edge's mixture exceeds `confidence`,
/// its design entry grows by `nudge` and the others fall by half of it, within `[0, 1]`.
pub fn attract(z: &mut [[f64; 3]], mixture: &[[f64; 3]], confidence: f64, nudge: f64) {
    for (vector, mixture) in z.iter_mut().zip(mixture) {
        let chosen = dominant(mixture) as usize;
        if mixture[chosen] > confidence {
            for (k, entry) in vector.iter_mut().enumerate() {
                *entry += if k == chosen { nudge } else { -0.5 * nudge };
            }
        }
    }
    clamp(z);
}

#[cfg(test)]
mod tests {
    use super::{attract, vectors_of_mixture};

    #[test]
    fn vectors_keep_the_ratios_of_the_mixture() {
        let mixture = [[0.6, 0.3, 0.1]];
        let [z] = vectors_of_mixture(&mixture, 20.0)[..] else {
            panic!("one edge in, one edge out")
        };
        // exp(20 x) multiplies the rounding of z, 1e-16, by 20.
        let ratio = |k: usize, l: usize| (20.0 * (z[k] - z[l])).exp();
        assert!((ratio(0, 1) - 2.0).abs() < 1e-13 && (ratio(0, 2) - 6.0).abs() < 1e-13);
        assert!((z.iter().sum::<f64>() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn attraction_moves_only_decided_edges_and_stays_in_range() {
        let mut z = [[0.5, 0.3, 0.2], [0.4, 0.4, 0.2], [0.0, 0.999, 0.001]];
        let mixture = [[0.95, 0.04, 0.01], [0.5, 0.49, 0.01], [0.0, 1.0, 0.0]];
        attract(&mut z, &mixture, 0.9, 0.004);
        assert_eq!(z[0], [0.5 + 0.004, 0.3 - 0.002, 0.2 - 0.002]);
        assert_eq!(z[1], [0.4, 0.4, 0.2]);
        assert_eq!(z[2], [0.0, 1.0, 0.0]);
    }
}
