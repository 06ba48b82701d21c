//! Compares the objectives with stored reference answers and with a second, plain implementation that is differentiated
//! by finite differences. The tool is run through the same protocol that GradBench uses.

mod adbench;
mod answers;
mod comparison;
mod draw;
mod driver;
mod naive;
mod session;
