//! The objectives of GradBench (<https://github.com/gradbench/gradbench>), written once over `R: Real`. `gmm`, `ba`,
//! `lstm` and `ht` are those of ADBench (Srajer, Kukelova, Fitzgibbon, *A benchmark of selected algorithmic
//! differentiation tools*, arXiv:1807.10129). All derivatives come from `autodiff`, and each run records everything
//! again.
//!
//! | module | derivative |
//! | --- | --- |
//! | `hello` | reverse mode of a closure |
//! | `gmm` | reverse mode: a sum over data, replayed in lanes over blocks of data |
//! | `ba` | forward mode: the local Jacobian of every observation, in lanes over observations |
//! | `lstm` | reverse mode: a rollout with one step per character |
//! | `ht` | forward mode: the Jacobian of all residuals; one direction moves the places of all points |
//! | `kmeans` | forward over forward mode: one direction serves all coordinates of all centroids |
//! | `ode` | reverse mode: a rollout of Runge-Kutta steps |
//! | `llsq` | reverse mode: a sum over data in lanes |
//! | `det` | reverse mode: a sum over the minors of the last rows in lanes, nested calls above |
//! | `lse` | reverse mode: nested, of the logarithm and of the terms in lanes |
//! | `particle`, `saddle` | both modes nested in both |

mod ba;
mod descent;
mod det;
mod gmm;
mod hand;
mod hello;
mod kmeans;
mod llsq;
mod lse;
mod lstm;
mod ode;
mod particle;
mod rotation;
mod saddle;
mod work;

use serde_json::value::RawValue;

pub use work::{Error, Prepared, Work};

/// The type of a function that reads an input and prepares an evaluation. Its first argument is the name of a GradBench
/// function.
pub type Prepare = fn(&str, &RawValue) -> Prepared;

/// All modules of GradBench, each with the function that prepares its evaluations.
pub const EVALUATIONS: [(&str, Prepare); 12] = [
    ("hello", hello::prepare),
    ("gmm", gmm::prepare),
    ("ba", ba::prepare),
    ("lstm", lstm::prepare),
    ("ht", hand::prepare),
    ("kmeans", kmeans::prepare),
    ("ode", ode::prepare),
    ("llsq", llsq::prepare),
    ("det", det::prepare),
    ("lse", lse::prepare),
    ("particle", particle::prepare),
    ("saddle", saddle::prepare),
];

/// Returns the evaluation of a module.
///
/// # Errors
/// If the module is unknown.
pub fn evaluation(module: &str) -> Result<Prepare, Error> {
    let found = EVALUATIONS.iter().find(|(name, _)| *name == module);
    let unknown = || Error::Unknown(format!("module '{module}'"));
    found.map(|&(_, prepare)| prepare).ok_or_else(unknown)
}
