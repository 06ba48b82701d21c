//! Mixtures: the shares of the materials in an edge.

use std::ops::Index;

use autodiff::Real;

use super::Material;

/// The shares of void, skeleton and actuator in an edge. They sum to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mixture<R>(pub [R; 3]);

impl<R> Index<Material> for Mixture<R> {
    type Output = R;

    fn index(&self, material: Material) -> &R {
        &self.0[material as usize]
    }
}

impl<R: Real> Mixture<R> {
    /// The share of solid material: skeleton and actuator together.
    pub fn solid(&self) -> R {
        self[Material::Skeleton] + self[Material::Actuator]
    }

    /// The mean of a property of the materials, weighted by their shares.
    pub fn mean_of(&self, property: &[f64; 3]) -> R {
        R::dot(&self.0, &property.map(R::lit))
    }
}

impl Mixture<f64> {
    /// The material with the largest share.
    pub fn dominant(&self) -> Material {
        Material::dominant(&self.0)
    }
}

/// The mean shares of solid material and of actuators over all edges.
pub fn volumes(mixtures: &[Mixture<f64>]) -> [f64; 2] {
    let mean = |share: fn(&Mixture<f64>) -> f64| {
        mixtures.iter().map(share).sum::<f64>() / mixtures.len() as f64
    };
    [mean(Mixture::solid), mean(|m| m[Material::Actuator])]
}
