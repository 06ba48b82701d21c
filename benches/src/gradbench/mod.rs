//! GradBench's evaluations on `autodiff`, and the tool that speaks its protocol
//! (<https://github.com/gradbench/gradbench>).
//!
//! Objectives are plain generic Rust; all derivatives come from the crate. Each is recorded within the
//! timed call, anew for every run.
//!
//! | evaluation | how its derivative is had |
//! | --- | --- |
//! | [`hello`] | reverse mode, of a closure |
//! | [`gmm`] | reverse mode: a sum over data in lanes (shared with [`adbench`](crate::adbench)) |
//! | [`ba`] | local Jacobians in lanes over observations (shared) |
//! | [`lstm`] | reverse mode: a rollout, a step for each character (shared) |
//! | [`ht`] | forward mode: four directions serve all fingers, in lanes over vertices (shared) |
//! | [`kmeans`] | reverse mode, and reverse over forward, of sums in lanes over the points of a centroid |
//! | [`ode`] | reverse mode: a rollout, a Runge-Kutta step each |
//! | [`llsq`] | reverse mode: a sum over data in lanes |
//! | [`det`] | reverse mode: a sum over the minors of the last rows in lanes, nested calls above |
//! | [`lse`] | reverse mode: nested, of the logarithm and of the terms in lanes |
//! | [`particle`], [`saddle`] | both modes nested in both |

pub mod ba;
pub mod compare;
pub mod det;
pub mod gmm;
pub mod hello;
pub mod ht;
pub mod inputs;
pub mod kmeans;
pub mod llsq;
pub mod lse;
pub mod lstm;
pub mod modes;
pub mod ode;
pub mod particle;
pub mod protocol;
pub mod saddle;
mod work;

use serde_json::value::RawValue;

pub use work::{Prepared, Refusal, Work};

/// Reads the input of a function, by the function's name.
pub type Prepare = fn(&str, &RawValue) -> Prepared;

/// All evaluations, by the names of their modules.
pub const EVALUATIONS: [(&str, Prepare); 12] = [
    ("hello", hello::prepare),
    ("gmm", gmm::prepare),
    ("ba", ba::prepare),
    ("lstm", lstm::prepare),
    ("ht", ht::prepare),
    ("kmeans", kmeans::prepare),
    ("ode", ode::prepare),
    ("llsq", llsq::prepare),
    ("det", det::prepare),
    ("lse", lse::prepare),
    ("particle", particle::prepare),
    ("saddle", saddle::prepare),
];

/// The evaluation of a module.
pub fn evaluation(module: &str) -> Option<Prepare> {
    let found = EVALUATIONS.iter().find(|(name, _)| *name == module);
    found.map(|&(_, prepare)| prepare)
}
