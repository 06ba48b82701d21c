//! The tests of the public interface, as one binary with one module per topic. Thirty binaries would each link, and
//! compile their own copies of the generic code.
//!
//! `cargo test -p cosmic-autodiff --test all kinks::` runs one module.

mod closures;
mod common;
mod in_lanes;

mod callers;
mod check;
mod complex;
mod computed_zeros;
mod double_double;
mod element;
mod elementary;
mod foreign;
mod fused;
mod higher;
mod implicit;
mod kinks;
mod misuse;
mod matrices;
mod singular_matrices;
mod nalgebra_branches;
mod nesting;
mod numbers;
mod parallel;
mod parameters;
mod pointers;
mod precision;
mod rounding;
mod rules;
mod sparse;
mod sums;
mod special;
mod trace;
mod trace_lines;
mod values;
