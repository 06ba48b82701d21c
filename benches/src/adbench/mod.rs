//! ADBench's four objectives on `autodiff`: Gaussian mixture, bundle adjustment, LSTM, hand
//! tracking (Srajer, Kukelova, Fitzgibbon, *A benchmark of selected algorithmic differentiation
//! tools*, arXiv:1807.10129). Each is written once over `R: Real`; nothing is differentiated by
//! hand.
//!
//! | problem | how its derivative is had |
//! | --- | --- |
//! | [`gmm`] | reverse mode: a sum over data, replayed in lanes over blocks of them |
//! | [`ba`] | the local Jacobian of every observation, by code emitted from the reverse tape, in lanes over observations |
//! | [`lstm`] | reverse mode: a rollout, a step for each character, adjoints emitted |
//! | [`hand`] | forward mode: four directions serve all fingers, in lanes over vertices |

pub mod answer;
pub mod ba;
mod case;
pub mod gmm;
pub mod hand;
mod input;
pub mod lstm;
pub mod measure;
mod rotation;
pub mod table;

use serde_json::Value;

pub use case::{DataFile, cases, open};
pub use input::Error;

/// An instance of a problem, with memory for its results.
pub trait Problem {
    /// Computes the objective, as plain floating point, from scratch.
    fn objective(&mut self);

    /// Computes objective and derivative, from scratch.
    fn derivative(&mut self);

    /// The results of the last [`objective`](Self::objective) and [`derivative`](Self::derivative):
    /// `objective` and `gradient` or `jacobian`, as the reference answers name them.
    fn answer(&self) -> Value;
}

/// The four problems.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Gaussian mixture model.
    Gmm,
    /// Bundle adjustment.
    Ba,
    /// A language model.
    Lstm,
    /// Hand tracking, simple or complicated.
    Hand,
}
