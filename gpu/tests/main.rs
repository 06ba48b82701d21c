//! Tests of populations on a device.

mod alike;
mod commands;
mod device;
mod every;
mod optimise;
mod program;
mod robots;
mod text;
