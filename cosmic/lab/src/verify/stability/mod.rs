//! Robots at the extremes: the promise of the stable time step, and their motion.
//!
//! A row is stable if its time step is below the limit of its largest frequency. Then nothing may grow.
//! Otherwise the check of the time step must have said so, and something must grow. No number may cease
//! to be finite without a message.

mod bound;
mod cost;
mod extremes;
mod sheet;
mod trial;

pub use bound::{BoundRatio, bound_ratio};
pub use cost::{GuardCost, guard_cost};
pub use extremes::{case_trials, extreme_trials};
pub use trial::{Found, Outcome, Trial, World};

use rayon::prelude::*;

use cosmic::case::Case;

/// Lattices over which the bound is compared with the largest frequency.
const LATTICES: usize = 600;

/// The results on stability.
#[derive(Clone, Debug)]
pub struct Stability {
    /// The results of the case and of every extreme.
    pub found: Vec<Found>,
    /// The bound on the frequencies over the frequencies.
    pub bound: BoundRatio,
    /// The cost of the guard in the case's rollout.
    pub guard: GuardCost,
}

impl Stability {
    /// Tries a case and all extremes.
    pub fn of(case: &Case) -> Self {
        // Measured alone: the trials take all cores.
        let guard = guard_cost(case);
        let trials = [case_trials(case), extreme_trials()].concat();
        Self {
            found: trials.par_iter().map(Trial::run).collect(),
            bound: bound_ratio(LATTICES),
            guard,
        }
    }
}
