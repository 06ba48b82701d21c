//! GPU support for the program `cosmic`.

use std::num::NonZeroUsize;
use std::sync::Arc;

use cosmic::error::{Error, Result};
use cosmic::population::Populations;
use cosmic_gpu::{Gpu, OnGpu, adapters};
use cosmic_program::GpuSupport;

/// The adapters of Vulkan, Metal and DirectX 12.
pub(crate) struct Support;

fn usage(error: impl ToString) -> Error {
    Error::Usage(error.to_string())
}

impl GpuSupport for Support {
    fn adapters(&self) -> Vec<String> {
        let describe = |adapter: &cosmic_gpu::Adapter| {
            format!(
                "{} ({:?}, {:?}, {})",
                adapter.name, adapter.device_type, adapter.backend, adapter.driver_info
            )
        };
        adapters().iter().map(describe).collect()
    }

    fn open(&self, threads: Option<NonZeroUsize>) -> Result<Arc<dyn Populations>> {
        let gpu = Gpu::of_environment().map_err(usage)?;
        Ok(Arc::new(OnGpu::new(gpu, threads).map_err(usage)?))
    }
}
