//! GPU support, which a program of another package adds, and `cosmic devices`.

use crate::output::{lines_of, print, print_json};
use clap::{Args, ValueEnum};
use cosmic::error::{Error, Result};
use cosmic::population::Populations;
use serde_json::json;
use std::num::NonZeroUsize;
use std::sync::Arc;

/// What a program with GPU support can do. The package `cosmic-gpu` implements it; its program is this one with GPU
/// support.
pub trait GpuSupport: Send + Sync {
    /// Describes each adapter in a line, the one that is taken first.
    fn adapters(&self) -> Vec<String>;

    /// Opens the adapter that the user chose, or the first one. The device prepares its work on this many threads, by
    /// default one per core.
    ///
    /// # Errors
    /// [`Error::Usage`] if there is none, or if it cannot be opened.
    fn open(&self, threads: Option<NonZeroUsize>) -> Result<Arc<dyn Populations>>;
}

/// The GPU support of the program, if it has any.
pub(super) type Gpu<'a> = Option<&'a dyn GpuSupport>;

/// Returns the GPU support of the program.
///
/// # Errors
/// [`Error::Usage`] if it has none. The message has the command that does.
pub(super) fn support(gpu: Gpu<'_>) -> Result<&dyn GpuSupport> {
    gpu.ok_or_else(|| {
        Error::Usage(
            "this program was built without GPU support; in a clone of the project, run the program that has it with: \
             cargo run --release --manifest-path gpu/Cargo.toml -- …"
                .into(),
        )
    })
}

/// Where rollouts and gradients are computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Device {
    /// On the processor
    Cpu,
    /// On a GPU, in single precision
    Gpu,
}

/// The option `--device`.
#[derive(Debug, Clone, Args)]
pub(super) struct On {
    /// Where rollouts and gradients are computed
    #[arg(long, value_name = "DEVICE", default_value = "cpu")]
    device: Device,
}

impl On {
    /// Opens the device; `None` for the processor.
    pub(super) fn open(
        &self,
        gpu: Gpu<'_>,
        threads: Option<NonZeroUsize>,
    ) -> Result<Option<Arc<dyn Populations>>> {
        match self.device {
            Device::Cpu => Ok(None),
            Device::Gpu => support(gpu)?.open(threads).map(Some),
        }
    }
}

/// List the GPUs of this computer, the one that is taken first
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Write JSON
    #[arg(long)]
    json: bool,
}

impl Arguments {
    pub(super) fn run(&self, gpu: Gpu<'_>) -> Result<()> {
        let adapters = support(gpu)?.adapters();
        if self.json {
            return print_json(&json!({ "devices": adapters }));
        }
        if adapters.is_empty() {
            return print("no adapter of Vulkan, Metal or DirectX 12 was found\n");
        }
        print(&lines_of(&adapters))
    }
}
