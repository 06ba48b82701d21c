//! The tool of GradBench, driven as GradBench drives it: every function at small sizes, against objectives
//! that are written again, as plainly as can be, and differentiated in forward mode.

mod answers;
mod driver;
mod naive;
mod naive_scenes;
mod session;
