//! The tests across both crates as one binary, a module a topic: a binary for each would link, and
//! compile its own copy of the simulator, twenty times.
//!
//! `cargo test -p cosmic-tests --test all plan::` runs one module.

mod case_reader;
mod corpus;
mod drawn_scenes;
mod floors;
mod ground_profile;
mod guard;
mod inlined_kernels;
mod integrators;
mod listed;
mod mma;
mod mma_subproblem;
mod model_gradients;
mod one_piece;
mod optimisers;
mod outside;
mod own_laws;
mod plan;
mod policies;
mod reference_model;
mod reference_rollouts;
mod richer_physics;
mod rollout_gradients;
mod stability;
mod surroundings;
mod time_step;
mod void_edges;
