//! The method of moving asymptotes (MMA), for bounded variables under a few inequality constraints.
//!
//! K. Svanberg, "The method of moving asymptotes: a new method for structural optimization",
//! International Journal for Numerical Methods in Engineering 24 (1987) 359-373, in the form of
//! his "MMA and GCMMA, two methods for nonlinear optimization" (2007): minimise
//! `f_0(x) + sum_i (c y_i + d y_i^2 / 2)` subject to `f_i(x) - y_i <= 0`, `xmin <= x <= xmax`,
//! `y >= 0`. All `a_i` of the general form are 0 here, which makes its `z` 0 and `a0` irrelevant.
//!
//! Each update replaces every function by a convex separable model, which is exact to first order and has poles at two
//! asymptotes per variable. The asymptotes of a variable move closer if the variable oscillates, and away if it keeps
//! its direction. Because of the elastic variables `y`, each subproblem has a solution even if no point meets all
//! constraints. The subproblem is solved through its dual, up to rounding error. That is cheap for up to about ten
//! constraints.
//!
//! [`minimise`] runs the method to a stopping rule. Its default is the globally convergent version of K. Svanberg, "A
//! class of globally convergent optimization methods based on conservative convex separable approximations", SIAM
//! Journal on Optimization 12 (2002) 555-573, which cannot cycle. [`Mma::update`] is a single update of the original
//! method, for callers with a loop of their own.

mod bracket;
mod cholesky;
mod subproblem;
mod dual;
mod settings;
mod method;
mod driver;

pub use driver::{Options, Variant, minimise};
pub use method::{Linearisation, Mma, MmaDiagnostics, MmaState, Update};
pub use settings::MmaSettings;
