//! Reads arbitrary bytes as a design.
#![no_main]

use cosmic_tests::readers;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let _ = readers::design(bytes);
});
