//! Compares `autodiff` with other crates on small tasks. For each crate, a task is written as that crate's
//! documentation recommends. The answers are compared before anything is timed.
//!
//! `cargo bench -p benches --bench peers --features rivals` prints a table of `RESULTS.md`. To include tensors, use
//! `--features candle` and set `RAYON_NUM_THREADS=1`.

mod ensemble;
mod forward;
mod hessian;
mod network;
mod ode;
mod rosenbrock;
mod sparse;
mod task;

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
        forward::task(),
    ];
    println!("{}, one thread\n", machine());
    println!(
        "| task | ours, us | ratio to the reference | fastest peer | peer, us | peer's ratio to ours | lines, ours and \
         peer's |\n| --- | --- | --- | --- | --- | --- | --- |"
    );
    for mut task in tasks {
        task.compare();
        println!("{}", task.measure(ROUNDS));
    }
}

/// Returns the name of the processor and the kind of its SIMD registers.
fn machine() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let field = |name: &str| {
        let line = info.lines().find(|line| line.starts_with(name))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    };
    let name = field("model name").unwrap_or_else(|| "an unknown processor".into());
    let kind = [field("cpu family"), field("model\t")].map(Option::unwrap_or_default);
    let [family, model] = kind;
    let level = autodiff::simd::level();
    format!("{name} (family {family}, model {model}), {level:?} lanes")
}
