//! The tests of the crate `cosmic-optimiser`. They form one binary.

mod adam;
mod classics;
mod ends;
mod engineering;
mod mma {
    mod subproblem;
}
mod problems;
