//! The tests of the crate `cosmic-optimiser`. They form one binary.

mod adam;
mod classics;
mod ends;
mod engineering;
mod mma {
    mod bracket;
    mod cholesky;
    mod subproblem;
}
mod problems;
