//! GPUs, of which this program knows nothing: another package adds support for them.

use crate::common::Bench;

/// The message says which command has GPU support, and nothing is written.
#[test]
fn a_program_without_gpu_support_names_the_one_that_has_it() {
    let bench = Bench::default();
    let words = [
        "this program was built without GPU support",
        "cargo run --release --manifest-path gpu/Cargo.toml -- ",
    ];
    bench.fails("devices", 2, &words);
    bench.fails("robustness a --device gpu", 2, &words);
    bench.fails("resume a --device gpu", 2, &words);
    bench
        .optimize("a", "--starts 2 --device gpu")
        .fails(2, &words);
    assert!(!bench.path("a").exists());
    bench
        .optimize("a", "--device tpu")
        .fails(2, &["invalid value 'tpu'", "cpu, gpu"]);
}

/// The processor is the default, and can be named.
#[test]
fn the_processor_can_be_named() {
    let bench = Bench::default();
    bench.run("a", "--device cpu --iterations 1");
}
