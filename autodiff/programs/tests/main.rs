//! The tests of the public interface, as one binary with one module per topic. The helpers in `common`, and the tests of all
//! functions and kinks, are those of `cosmic-autodiff`: here they run in replays and rollouts.
//!
//! `cargo test -p cosmic-autodiff-programs --test all rollout::` runs one module.

#[allow(dead_code, unused_imports)] // The tests of `cosmic-autodiff` need more.
mod common;
mod in_lanes;
mod net;
mod steps;
mod summand;

mod batch;
mod callers;
mod computed_zeros;
mod double_double;
mod drawn;
mod elementary;
mod emitted;
mod graph;
mod kinks;
mod local_jacobians;
mod memory;
mod named;
mod operations;
mod pointers;
mod program;
mod recorded;
mod replayed;
mod rollout;
mod sizes;
mod solve;
mod special;
mod sums;
mod trace;
