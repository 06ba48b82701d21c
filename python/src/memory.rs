//! Checks whether there is enough memory. A failed allocation in the library would end the process, so sizes are
//! checked beforehand.

use crate::arrays::Sizes;
use crate::errors::OutOfMemoryError;
use cosmic::lattice::Lattice;
use cosmic::scene::Scene;
use pyo3::PyResult;
use std::fs;
use std::hint::black_box;

/// Memory is not checked for fewer bytes than this, because a check takes about 20 us.
const LITTLE: f64 = 16e6;

/// Returns an error if fewer than `bytes` bytes are available. The message begins with `what` and ends with `remedy`.
pub(crate) fn has_room(bytes: f64, what: &str, remedy: &str) -> PyResult<()> {
    if bytes < LITTLE {
        return Ok(());
    }
    let free = free();
    if free.is_none_or(|free| bytes <= free) && is_granted(bytes) {
        return Ok(());
    }
    let beyond = free.filter(|free| bytes > *free).map_or_else(
        || "the system refuses to allocate it".to_owned(),
        |free| format!("only {} are free", in_words(free)),
    );
    let bytes = in_words(bytes);
    Err(OutOfMemoryError::new_err(format!(
        "{what} needs {bytes} of memory, but {beyond}; {remedy}"
    )))
}

/// True if the system can allocate this many bytes. They are freed at once.
fn is_granted(bytes: f64) -> bool {
    let mut probe: Vec<u8> = Vec::new();
    // A number too large for `usize` saturates, and the allocation is refused.
    let granted = probe.try_reserve_exact(bytes as usize).is_ok();
    // Without this, the compiler could remove the allocation.
    black_box(&probe);
    granted
}

/// Returns the number of bytes that are free on the machine, or the limit of the container if it is smaller. Returns
/// `None` if both are unknown.
fn free() -> Option<f64> {
    let number = |path: &str| fs::read_to_string(path).ok()?.trim().parse::<f64>().ok();
    let container = [
        "/sys/fs/cgroup/memory.max",
        "/sys/fs/cgroup/memory/memory.limit_in_bytes",
    ];
    let machine = fs::read_to_string("/proc/meminfo").ok().map(|lines| {
        let of = |name: &str| {
            let line = lines.lines().find_map(|line| line.strip_prefix(name));
            let kilobytes = line.and_then(|line| line.trim_end_matches("kB").trim().parse().ok());
            kilobytes.unwrap_or(0.0) * 1024.0
        };
        of("MemAvailable:") + of("SwapFree:")
    });
    (container.into_iter().filter_map(number))
        .chain(machine)
        .reduce(f64::min)
}

fn in_words(bytes: f64) -> String {
    match bytes {
        ..1e9 => format!("{:.0} MB", bytes / 1e6),
        1e9..1e12 => format!("{:.1} GB", bytes / 1e9),
        _ => format!("{:.1e} GB", bytes / 1e9),
    }
}

/// Refuses a scene whose simulator does not fit into memory.
pub(crate) fn simulator_fits(scene: &Scene) -> PyResult<()> {
    let lattice = Lattice::new(&scene.lattice, &scene.physics);
    let sizes = Sizes::of(&lattice, &scene.controller);
    let (edges, steps) = (sizes.edges, scene.physics.steps);
    // The simulator keeps a sine, a cosine and a time for each step, together 24 bytes. The list of them doubles as it
    // grows and is then copied, so it needs up to three times as much. An edge takes about 400 bytes.
    let bytes = 72.0 * steps as f64 + 1e3 * edges as f64;
    has_room(
        bytes,
        &format!("a simulator of {edges} edges and {steps} steps"),
        "use a smaller lattice, or lower physics.steps",
    )
}

/// Refuses a scene if `copies` copies of the initial inputs do not fit into memory.
pub(crate) fn start_fits(scene: &Scene, sizes: &Sizes, copies: f64) -> PyResult<()> {
    let (edges, hidden) = (sizes.edges, scene.controller.hidden);
    has_room(
        8.0 * copies * sizes.numbers(),
        &format!("a controller of {hidden} hidden neurons for {edges} edges"),
        "use a smaller lattice, or lower controller.hidden",
    )
}

/// Refuses a scene whose optimisation does not fit into memory. The gradient records every step of its horizon, unless
/// the scene sets a memory budget.
pub(crate) fn optimisation_fits(scene: &Scene) -> PyResult<()> {
    simulator_fits(scene)?;
    let lattice = Lattice::new(&scene.lattice, &scene.physics);
    let sizes = Sizes::of(&lattice, &scene.controller);
    // The ten copies include gradients and the moments of two optimisers.
    start_fits(scene, &sizes, 10.0)?;
    let horizon = scene.schedule.horizon.into_iter().max().unwrap_or(0);
    let record = kept(scene, &sizes, horizon, 8.0);
    has_room(
        record,
        &format!("the gradient over {horizon} steps"),
        "set gradient.memory, or lower schedule.horizon",
    )
}

/// Returns the number of bytes that a gradient records over a rollout: for every step the state and the results of all
/// operations, limited by the scene's memory budget. A number takes `size` bytes.
pub(crate) fn kept(scene: &Scene, sizes: &Sizes, steps: usize, size: f64) -> f64 {
    let (nodes, edges, hidden) = (sizes.nodes, sizes.edges, scene.controller.hidden);
    // The factors were measured on lattices of 6 x 6 and 16 x 16 nodes with 32 and 512 hidden neurons.
    let row = 5 * nodes + 4 * edges + 6 * hidden;
    let all = steps as f64 * row as f64 * size;
    let budget = scene.gradient.memory.map(|megabytes| megabytes * 1e6);
    budget.map_or(all, |budget| all.min(budget))
}
