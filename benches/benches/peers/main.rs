//! Compares `autodiff` with other crates on small tasks. For each crate, a task is written as that crate's
//! documentation recommends. The answers are compared before anything is timed.
//!
//! `cargo bench -p benches --bench peers --features rivals` prints a section of `RESULTS.md`. To include tensors, use
//! `--features candle` and set `RAYON_NUM_THREADS=1`.

mod document;
mod ensemble;
mod forward;
mod hessian;
mod network;
mod ode;
mod rosenbrock;
mod sparse;
mod task;

use benches::machine::section;

/// The number of rounds of a measurement. Only the minimum is reported.
const ROUNDS: usize = 100;

fn main() {
    #[cfg(feature = "candle")]
    assert!(
        candle_core::utils::get_num_threads() == 1,
        "RAYON_NUM_THREADS must be 1, because every crate is timed on one thread; set it in the environment"
    );
    let tasks = [
        rosenbrock::task(),
        ode::task(),
        network::task(&[64, 128, 128, 1], 256),
        network::task(&[256, 256, 256, 1], 64),
        network::task(&[8, 16, 16, 1], 256),
        hessian::task(),
        sparse::task(),
        ensemble::task(),
        forward::gradient(),
        forward::jacobian(),
    ];
    let measured = tasks.into_iter().map(|mut task| {
        task.compare();
        let outcomes = task.measure(ROUNDS);
        let measured = (task, outcomes);
        println!("{}", document::table(&measured));
        measured
    });
    let summary = document::summary(&measured.collect::<Vec<_>>());
    let command = "RAYON_NUM_THREADS=1 cargo bench -p benches --bench peers --features candle";
    println!("{}", section("Peers", command, &summary));
}
