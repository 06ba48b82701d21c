//! The paper's algorithm 1: structure, material and controller optimised together.
//!
//! [`CoDesign::iterate`] does one iteration. It updates a [`Progress`], which is the whole state of an
//! optimisation, and returns a [`Record`] of the iteration. Its random numbers depend only on the seed and the
//! iteration. It neither reads nor writes files. At the end,
//! [`CoDesign::deliver`] chooses the controller and measures the robot. What takes a [`Progress`] is a method of [`CoDesign`];
//! what takes any robot is one of [`Evaluator`](crate::judge::Evaluator). [`CoDesign::optimise`] does everything from start to
//! result:
//!
//! ```
//! use cosmic::search::CoDesign;
//! use cosmic::scene::Scene;
//!
//! let scene = Scene::parse("tiny", "
//!     [lattice]
//!     columns = 3
//!     rows = 2
//!     [physics]
//!     steps = 64
//!     [schedule]
//!     iterations = 8
//!     attraction_from = 4
//!     snap_at = 6
//!     horizon = [32, 32]
//!     [loss]
//!     window = 16
//! ")?;
//! let mut design_gradients = Vec::new();
//! let delivery = CoDesign::new(&scene)?.optimise(0, |record| {
//!     design_gradients.extend(record.design_gradient[0]);
//! })?;
//! assert_eq!(design_gradients.len(), 3); // The cycle begins d c d c d, and 6 is the snap.
//! assert_eq!(delivery.materials.len(), 11);
//! println!("{:.3} m", delivery.robust.p50);
//! # Ok::<(), cosmic::Error>(())
//! ```

mod schedule;
mod slope;
mod progress;
mod current;
mod variations;
mod slopes;
mod constraints;
mod begin;
mod review;
mod settle;
mod polish;
mod windows;
mod contest;
mod passes;
mod learn;
mod iterate;

pub use begin::CoDesign;
pub use progress::{Progress, Record, Settled};
pub use review::Review;
pub use schedule::{PassKind, Phase, Schedule};
pub use slope::{GradientPoint, Slope};
pub use slopes::Variables;
pub use windows::{Learner, Walkers, Window};
