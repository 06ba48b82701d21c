//! Compares `autodiff` with other crates on small tasks, each written as the documentation of the crate recommends.
//! Answers are compared before anything is timed.
//!
//! `cargo bench -p benches --bench peers --features rivals`, or `--features candle` with
//! `RAYON_NUM_THREADS=1` for tensors too, prints a section of `RESULTS.md`.

mod document;
mod ensemble;
mod hessian;
mod network;
mod ode;
mod rosenbrock;
mod sparse;
mod task;

use benches::machine::section;

/// The number of rounds; the minimum counts.
const ROUNDS: usize = 100;

fn main() {
    #[cfg(feature = "candle")]
    assert!(
        candle_core::utils::get_num_threads() == 1,
        "set RAYON_NUM_THREADS=1: every crate gets one thread"
    );
    let tasks = [
        rosenbrock::task(100),
        rosenbrock::task(1000),
        ode::task(),
        network::task(&[64, 128, 128, 1], 256),
        network::task(&[256, 256, 256, 1], 64),
        network::task(&[8, 16, 16, 1], 256),
        hessian::task(),
        sparse::task(),
        ensemble::task(),
    ];
    let measured = tasks.map(|mut task| {
        task.compare();
        let outcomes = task.measure(ROUNDS);
        let measured = (task, outcomes);
        println!("{}", document::table(&measured));
        measured
    });
    let summary = document::summary(&measured);
    let command = "RAYON_NUM_THREADS=1 cargo bench -p benches --bench peers --features candle";
    println!("{}", section("Peers", command, &summary));
}
