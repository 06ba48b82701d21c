//! Tests of populations on a device.

mod alike;
mod commands;
mod device;
mod every;
mod program;
mod refused;
mod robots;
mod text;
