//! The design of a robot. Before the snap, the materials of its edges are undecided; after the snap, it is a layout
//! with one material per edge.

use std::borrow::Cow;

use autodiff::Real;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{Material, Mixture};

/// The design of a robot. Before the snap, it is undecided and has an element of type `E` for every edge. After the
/// snap, it is a layout: it has one material for every edge.
///
/// The optimiser works on design vectors, `Design<[f64; 3]>`. A [projection](crate::projection::Projection) turns them
/// into mixtures, `Design<Mixture<R>>`, which determine the body of the robot. Projections do not change a layout (D7).
#[derive(Clone, Debug, PartialEq)]
pub enum Design<E> {
    /// One element for every edge: the design vector or the mixture of that edge.
    Undecided(Vec<E>),
    /// One material for every edge.
    Layout(Vec<Material>),
}

impl<E> Design<E> {
    /// The number of edges.
    pub fn edges(&self) -> usize {
        match self {
            Self::Undecided(elements) => elements.len(),
            Self::Layout(layout) => layout.len(),
        }
    }

    /// The material of every edge; `None` if the design is undecided.
    pub fn layout(&self) -> Option<&[Material]> {
        match self {
            Self::Undecided(_) => None,
            Self::Layout(layout) => Some(layout),
        }
    }

    /// Applies a function to every element of an undecided design.
    pub fn map<F>(&self, f: impl Fn(&E) -> F) -> Design<F> {
        match self {
            Self::Undecided(elements) => Design::Undecided(elements.iter().map(f).collect()),
            Self::Layout(layout) => Design::Layout(layout.clone()),
        }
    }

    /// The elements of an undecided design, mutable; `None` for a layout.
    pub fn undecided_mut(&mut self) -> Option<&mut [E]> {
        match self {
            Self::Undecided(elements) => Some(elements),
            Self::Layout(_) => None,
        }
    }
}

impl Design<[f64; 3]> {
    /// The design with the design vectors `z`. It is a layout if every vector is one-hot (one entry is 1, the others
    /// are 0).
    pub fn of_vectors(z: Vec<[f64; 3]>) -> Self {
        let layout: Vec<_> = z.iter().map(Material::dominant).collect();
        if one_hot(&layout) == z {
            Self::Layout(layout)
        } else {
            Self::Undecided(z)
        }
    }

    /// The design vectors. The vectors of a layout are one-hot.
    pub fn vectors(&self) -> Cow<'_, [[f64; 3]]> {
        match self {
            Self::Undecided(z) => z.into(),
            Self::Layout(layout) => one_hot(layout).into(),
        }
    }
}

impl<R: Real> Design<Mixture<R>> {
    /// Computes a number for every edge. For an undecided design, `of_mixture` computes it from the index of the edge and
    /// its mixture; for a layout, `of_material` computes it from the index and the material.
    pub fn each(
        &self,
        of_mixture: impl Fn(usize, &Mixture<R>) -> R,
        of_material: impl Fn(usize, Material) -> f64,
    ) -> Vec<R> {
        match self {
            Self::Undecided(mixtures) => {
                let mixtures = mixtures.iter().enumerate();
                mixtures
                    .map(|(edge, mixture)| of_mixture(edge, mixture))
                    .collect()
            }
            Self::Layout(layout) => {
                let layout = layout.iter().enumerate();
                layout
                    .map(|(edge, &material)| R::lit(of_material(edge, material)))
                    .collect()
            }
        }
    }

    /// An undecided design with the given shares of void, skeleton and actuator for every edge.
    pub fn of_shares(shares: &[[R; 3]]) -> Self {
        Self::Undecided(shares.iter().map(|&shares| Mixture(shares)).collect())
    }

    /// The mixture of every edge. In a layout, the mixture has only the material of the edge, with the share 1.
    pub fn mixtures(&self) -> Cow<'_, [Mixture<R>]> {
        match self {
            Self::Undecided(mixtures) => mixtures.into(),
            Self::Layout(layout) => {
                let whole = |material: &Material| Mixture(material.one_hot().map(R::lit));
                layout.iter().map(whole).collect()
            }
        }
    }
}

impl Design<Mixture<f64>> {
    /// The material of every edge. For an undecided design, it is the dominant material, which has the largest share.
    pub fn materials(&self) -> Vec<Material> {
        match self {
            Self::Undecided(mixtures) => mixtures.iter().map(Mixture::dominant).collect(),
            Self::Layout(layout) => layout.clone(),
        }
    }

    /// Converts the design to another number type. The shares become constants, which have no derivatives.
    pub fn lift<R: Real>(&self) -> Design<Mixture<R>> {
        self.map(|mixture| Mixture(mixture.0.map(R::lit)))
    }
}

/// The design vectors of a layout.
fn one_hot(layout: &[Material]) -> Vec<[f64; 3]> {
    layout.iter().map(|material| material.one_hot()).collect()
}

/// The form in which files store a design: its design vectors and, for a layout, the materials.
#[derive(Serialize, Deserialize)]
struct Saved {
    z: Vec<[f64; 3]>,
    materials: Option<Vec<Material>>,
}

impl Serialize for Design<[f64; 3]> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let saved = Saved {
            z: self.vectors().into_owned(),
            materials: self.layout().map(Vec::from),
        };
        saved.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Design<[f64; 3]> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Saved { z, materials } = Saved::deserialize(deserializer)?;
        Ok(materials.map_or(Self::Undecided(z), Self::Layout))
    }
}
