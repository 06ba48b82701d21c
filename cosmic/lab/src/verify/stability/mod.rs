//! Robots at the extremes: what the stable time step promises of each, and what it does.
//!
//! A row is stable where its time step is below what its largest frequency allows. Then nothing
//! may grow; otherwise the check of the time step must have said so, and something must grow. No
//! number that is not finite may go unannounced, whatever was expected.

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

/// Lattices over which the bound is held against the largest frequency.
const LATTICES: usize = 600;

/// All that is found of stability.
#[derive(Clone, Debug)]
pub struct Stability {
    /// What became of the case and of every extreme.
    pub found: Vec<Found>,
    /// What the bound on the frequencies gives away.
    pub bound: BoundRatio,
    /// What the guard costs the case's rollout.
    pub guard: GuardCost,
}

impl Stability {
    /// Sweeps the extremes, beside a case of one's own.
    pub fn of(case: &Case) -> Self {
        // Alone: the others take all cores.
        let guard = guard_cost(case);
        let trials = [case_trials(case), extreme_trials()].concat();
        Self {
            found: trials.par_iter().map(Trial::run).collect(),
            bound: bound_ratio(LATTICES),
            guard,
        }
    }
}
