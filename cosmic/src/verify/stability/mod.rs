//! Robots at the extremes: what the stable time step promises of each, and what it does.
//!
//! A row is stable where its time step is below what its largest frequency allows. Then nothing
//! may grow; otherwise the check of the time step must have said so, and something must grow. No
//! number that is not finite may go unannounced, whatever was expected.

mod bound;
mod cost;
mod extremes;
mod trial;

pub use bound::{BoundRatio, bound_ratio};
pub use cost::{GuardCost, guard_cost};
pub use trial::{Found, Outcome, Trial, World};

use rayon::prelude::*;

use crate::scene::Scene;

/// Tries a scene and every extreme.
pub fn extremes(scene: &Scene) -> Vec<Found> {
    let trials: Vec<Trial> = extremes::of_scene(scene)
        .into_iter()
        .chain(extremes::all())
        .collect();
    trials.par_iter().map(Trial::run).collect()
}
