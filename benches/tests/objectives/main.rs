//! The objectives against stored reference answers and against objectives that are written again, as
//! plainly as can be, and differentiated in forward mode. The tool of GradBench is driven as GradBench
//! drives it.

mod adbench;
mod answers;
mod driver;
mod naive;
mod session;
