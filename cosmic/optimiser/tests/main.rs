//! The tests of the crate `cosmic-optimiser`. They form one binary.

mod adam;
mod mma {
    mod bracket;
    mod cholesky;
    mod subproblem;
}
