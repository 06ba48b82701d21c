//! The tests of the crate `cosmic-codesign`. They form one binary with a module for each topic.
//!
//! `cargo test -p cosmic-codesign --test all scene_reader::` runs one module.

mod property_design;
#[cfg(feature = "files")]
mod property_files;
#[cfg(feature = "files")]
mod record_files;
mod scene_builtin;
mod scene_follow;
mod scene_reader;
mod scene_unread;
mod scene_values;
