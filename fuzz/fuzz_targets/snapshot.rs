//! Reads arbitrary bytes as a snapshot.
#![no_main]

use cosmic_tests::readers;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let _ = readers::snapshot(bytes);
});
