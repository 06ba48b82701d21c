//! The device of the tests.

use cosmic_gpu::Gpu;

/// Opens the device that the environment names, or the first one. Without one, the tests say so and end.
pub fn gpu() -> Option<Gpu> {
    match Gpu::of_environment() {
        Ok(gpu) => Some(gpu),
        Err(error) => {
            println!("SKIPPED: {error}");
            None
        }
    }
}
