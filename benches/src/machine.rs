//! Shared by all benches: the machine, the built-in robots, timing, and the sections of `RESULTS.md` that
//! they print.

use std::fmt::Write as _;
use std::hint::black_box;
use std::time::Instant;

use cosmic::case::Case;
use cosmic::scene::Scene;

/// Processor and registers.
pub fn machine() -> String {
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

/// A built-in scene and its first case.
///
/// # Panics
/// If there is no scene of that name.
pub fn built_in(scene: &str) -> (Scene, Case) {
    let scene = Scene::load(scene).expect("the scene is built in");
    let case = Case::of_scene(&scene, 0).expect("a built-in scene is complete");
    (scene, case)
}

/// How long a work takes, s.
pub fn seconds<T>(work: impl FnOnce() -> T) -> f64 {
    let start = Instant::now();
    black_box(work());
    start.elapsed().as_secs_f64()
}

/// How long one measurement in turns lasts by default, s: long against the warming up of caches and branch
/// predictors after its predecessor, short against a time slice.
pub const SPAN: f64 = 2e-3;

/// Seconds that each work takes: the least of so many rounds, in each of which each work has its turn
/// and is repeated for so many seconds.
pub fn in_turns<T>(works: &mut [impl FnMut() -> T], span: f64, rounds: usize) -> Vec<f64> {
    let mut least = vec![f64::INFINITY; works.len()];
    for round in 0..=rounds {
        for (work, least) in works.iter_mut().zip(&mut least) {
            let repeats = ((span / *least) as usize).max(1);
            let all = || {
                for _ in 0..repeats {
                    black_box(work());
                }
            };
            let taken = seconds(all) / repeats as f64;
            // The first round finds out how many repeats there may be.
            *least = if round == 0 { taken } else { least.min(taken) };
        }
    }
    least
}

/// Appends a table's row: a name and figures, with so many digits.
pub fn row(table: &mut String, name: &str, figures: &[f64], digits: usize) {
    *table += &format!("| {name}");
    for figure in figures {
        let _ = write!(table, " | {figure:.digits$}");
    }
    *table += " |\n";
}

/// A section of `benches/RESULTS.md`: its title, the command that prints it, the machine, and the rest.
pub fn section(title: &str, command: &str, rest: &str) -> String {
    format!(
        "## {title}\n\n`{command}`, {}, one thread.\n\n{rest}",
        machine()
    )
}
