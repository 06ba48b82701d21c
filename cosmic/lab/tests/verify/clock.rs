#![cfg(target_os = "linux")]

use cosmic_lab::verify::measured;

#[test]
fn memory_is_that_of_the_work() {
    let ((), _, held) = measured(|| drop(std::hint::black_box(vec![1u8; 64 << 20])));
    // The memory is unknown if the system refuses to reset the peak.
    if let Some(bytes) = held {
        assert!(bytes >= 60 << 20, "{bytes}");
    }
}
