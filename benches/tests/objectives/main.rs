//! Compares the objectives with a second, plain implementation that is differentiated by finite differences. The tool is
//! run through the same protocol that GradBench uses.

mod answers;
mod draw;
mod driver;
mod hand;
mod naive;
mod session;
