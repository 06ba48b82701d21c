//! Compares the objectives with stored reference answers and with a second, plain implementation that is
//! differentiated by finite differences. The GradBench tool is driven as GradBench drives it.

mod adbench;
mod answers;
mod draw;
mod driver;
mod naive;
mod session;
