//! The materials that an edge can have.

use serde::{Deserialize, Serialize};

/// The material of an edge. Files store it as 0, 1 or 2.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "u8", into = "u8")]
pub enum Material {
    /// Almost no stiffness and mass: the robot has no bar there.
    Void = 0,
    /// Stiff and passive.
    Skeleton = 1,
    /// Soft and heavy; it changes its length on command.
    Actuator = 2,
}

impl Material {
    /// All materials, in the order of the entries of a design vector.
    pub const ALL: [Self; 3] = [Self::Void, Self::Skeleton, Self::Actuator];

    /// True for skeleton and actuator. An edge with one of these materials is a bar and counts in the volume.
    pub fn is_solid(self) -> bool {
        self != Self::Void
    }

    /// Picks the entry of this material from a list with one entry per material.
    pub fn of<T: Copy>(self, entries: &[T; 3]) -> T {
        entries[self as usize]
    }

    /// The material with the largest entry; the first one if several are equal.
    pub fn dominant(entries: &[f64; 3]) -> Self {
        let larger = |best: Self, m: Self| {
            if m.of(entries) > best.of(entries) {
                m
            } else {
                best
            }
        };
        Self::ALL.into_iter().fold(Self::Void, larger)
    }

    /// The one-hot design vector of this material.
    pub fn one_hot(self) -> [f64; 3] {
        Self::ALL.map(|m| f64::from(u8::from(m == self)))
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
        material.ok_or_else(|| {
            format!("{number} is not a material; use 0 for void, 1 for skeleton or 2 for actuator")
        })
    }
}
