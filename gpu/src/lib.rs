//! Runs programs that [`autodiff_programs::wgsl`] prints, for a whole population at once, on a GPU.

mod device;
mod population;
mod robots;
mod on_gpu;

pub use device::{Gpu, GpuError, adapters};
pub use on_gpu::{OnGpu, Refused, WORKGROUP};
pub use population::{Cotangents, Members, Population, Sweep};
pub use robots::{Differentiated, Losses, RobotsOnGpu};
pub use wgpu::AdapterInfo as Adapter;
