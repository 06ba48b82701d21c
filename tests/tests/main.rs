//! The tests of both crates together. They form one binary with a module for each topic. If each topic had a binary,
//! every binary would compile and link its own copy of the simulator.
//!
//! `cargo test -p cosmic-tests --test all plan::` runs one module.

mod absent_nodes;
mod case_reader;
mod corpus;
mod drawn_scenes;
mod efforts;
mod floors;
mod frame;
mod goals;
mod ground_profile;
mod guard;
mod implicit;
mod integrators;
mod learned_clock;
mod mma;
mod model_gradients;
mod motion;
mod moved;
mod one_piece;
mod outside;
mod own_laws;
mod own_losses;
mod plan;
mod policies;
mod reference_rollouts;
mod rollout_gradients;
mod scale;
mod space;
mod stability;
mod studies;
mod surroundings;
mod time_step;
mod void_edges;
