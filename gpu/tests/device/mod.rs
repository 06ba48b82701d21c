//! The device of the tests.

use std::io::{self, Write};

use cosmic_gpu::Gpu;

/// Opens the device that the environment names, or the first one. Without one, the tests say so and end.
pub(crate) fn gpu() -> Option<Gpu> {
    match Gpu::of_environment() {
        Ok(gpu) => Some(gpu),
        Err(error) => {
            let skipped = format!("SKIPPED: {error}: nothing is tested on a GPU\n");
            // The text is written to standard error directly, because the test harness hides what passing tests print.
            io::stderr().write_all(skipped.as_bytes()).unwrap();
            None
        }
    }
}
