//! The measures of mixtures: how much material they have, and how far they are from a single material per edge.

use autodiff::Real;

use crate::design::{Material, Mixture};

/// Measures of the mixtures of a robot. Each measure is a mean over the edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measures<R> {
    /// `V`: the share of solid material.
    pub volume: R,
    /// `V_act`: the share of actuators.
    pub actuator_volume: R,
    /// `g_bin`: one minus the norm of the mixture. It is 0 for an edge of a single material.
    pub binarisation: R,
    /// `g_kl`: the overlap of each pair of materials (0,1), (0,2) and (1,2) in the mixture (D6).
    pub overlap: [R; 3],
}

impl<R: Real> Measures<R> {
    /// The four measures that the augmented objective bounds: `g_bin`, then the three overlaps.
    pub fn constrained(&self) -> [R; 4] {
        let [a, b, c] = self.overlap;
        [self.binarisation, a, b, c]
    }
}

/// Computes the measures of mixtures. `delta` keeps the overlap finite if both of its shares vanish.
pub fn measures<R: Real>(mixtures: &[Mixture<R>], delta: f64) -> Measures<R> {
    let mean = |measure: &dyn Fn(&Mixture<R>) -> R| {
        let terms: Vec<R> = mixtures.iter().map(measure).collect();
        R::sum_of(&terms) * R::lit(1.0 / mixtures.len() as f64)
    };
    Measures {
        volume: mean(&Mixture::solid),
        actuator_volume: mean(&|m| m[Material::Actuator]),
        binarisation: mean(&shortfall),
        overlap: [(0, 1), (0, 2), (1, 2)].map(|(k, l)| mean(&|m| overlap(m.0[k], m.0[l], delta))),
    }
}

/// `1 - |m|`, as in the paper. For a nearly one-hot mixture the difference is only accurate to 1e-16.
fn shortfall<R: Real>(m: &Mixture<R>) -> R {
    R::one() - R::dot(&m.0, &m.0).sqrt()
}

/// `a b / (mean + delta)`, where `mean` is the mean of the shares `a` and `b`.
fn overlap<R: Real>(a: R, b: R, delta: f64) -> R {
    a * b / (R::lit(0.5) * (a + b) + R::lit(delta))
}
