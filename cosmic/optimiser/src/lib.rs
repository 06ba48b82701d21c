//! Gradient-based optimisers for bounded variables and constraints: the method of moving asymptotes (MMA), its globally
//! convergent version (GCMMA), an augmented Lagrangian, and Adam.
//!
//! A [`Problem`] has bounds and two closures, one for the values of the objective and the constraints, one for their
//! gradients. The gradients may come from the crate `autodiff`, from an adjoint solver, or from formulas.
//!
//! ```
//! use cosmic_optimiser::{Problem, Status, mma};
//!
//! // The lightest beam of two segments whose tip sinks by at most 1.
//! let mut beam = Problem::new(
//!     &[0.1; 2],
//!     &[10.0; 2],
//!     |x| vec![x[0] + x[1], 8.0 / x[0].powi(3) + 1.0 / x[1].powi(3) - 1.0],
//!     |x| vec![1.0, 1.0, -24.0 / x[0].powi(4), -3.0 / x[1].powi(4)],
//! );
//! let solution = mma::minimise(&mut beam, &[5.0, 5.0], &mma::Options::default())?;
//! assert_eq!(solution.status, Status::Converged);
//! // At the optimum 24 / x^4 = 3 / y^4, so x / y = 8^(1/4).
//! assert!((solution.point[0] / solution.point[1] - 8.0_f64.powf(0.25)).abs() < 1e-4);
//! # Ok::<(), cosmic_optimiser::OptimiserError>(())
//! ```
//!
//! | for | use |
//! | --- | --- |
//! | finite bounds and inequality constraints; any number of variables, up to some hundred constraints | [`mma::minimise`] |
//! | equality constraints, infinite bounds, many constraints | [`augmented::minimise`] |
//! | a loop of your own, one value and one gradient per update, as in topology optimisation | [`Mma::update`] |
//! | many free variables and a noisy gradient, as in training a network | [`Adam::update`] |
//!
//! # Ends of a run
//!
//! A run ends with a [`Status`]: converged, small step, iteration limit, infeasible, or failed because a function was
//! not finite, with the name of the function and the point. [`Stop`] defines the tolerances. A problem that cannot run
//! at all, because a list has the wrong length or bounds cross, is an [`OptimiserError`].
//!
//! # States
//!
//! [`Mma`] and [`Adam`] have a method `init` that returns their initial state, and a method `update` that advances it.
//! States are plain data. With the feature `serde` they can be saved; if all digits are kept, an optimisation that
//! continues from a saved state has the same bits.

// The modules are in the order of the architecture: each module uses only those above it.
mod error;
mod problem;
mod run;
pub mod adam;
pub mod mma;
mod descent;
pub mod augmented;

pub use adam::{Adam, AdamState, bound_norm};
pub use error::OptimiserError;
pub use mma::{Linearisation, Mma, MmaDiagnostics, MmaSettings, MmaState, Update};
pub use problem::Problem;
pub use run::{Solution, Status, Stop};

/// Compiles and runs the code in the README as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
