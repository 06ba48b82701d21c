//! placeholder

pub mod optimiser;
