//! Simulates a whole population of robots at once on a GPU: [`wgsl`] prints the recorded step, and the other modules run it.

pub mod wgsl;
mod device;
mod population;
mod printed;
mod robots;
mod on_gpu;

pub use device::{Gpu, GpuError, adapters};
pub use on_gpu::{OnGpu, Refused, WORKGROUP};
pub use population::{Cotangents, Members, Population, Sweep};
pub use printed::{PrintedRobots, Wanted, Workgroup};
pub use robots::{Differentiated, Losses, RobotsOnGpu};
pub use wgpu::AdapterInfo as Adapter;
