//! Runs programs that [`autodiff::wgsl`] prints, for a whole population at once, on a GPU.

mod device;
mod population;

pub use device::{Gpu, GpuError, adapters};
pub use population::{Cotangents, Members, Population, Sweep};
