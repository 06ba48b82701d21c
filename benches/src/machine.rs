//! Helpers that the benches share: a description of the machine, built-in robots, time measurements, and sections of
//! `RESULTS.md`.

use std::fmt::Write as _;
use std::hint::black_box;
use std::time::Instant;

use cosmic::case::Case;
use cosmic::scene::Scene;

/// Returns the name of the processor and the kind of its SIMD registers.
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

/// Returns a built-in scene, and the first of its cases.
///
/// # Panics
/// If the scene does not exist.
pub fn built_in(scene: &str) -> (Scene, Case) {
    let scene = Scene::load(scene).expect("the scene is built in");
    let case = Case::of_scene(&scene, 0).expect("a built-in scene is complete");
    (scene, case)
}

/// Measures the run time of `work` in seconds.
pub fn seconds<T>(work: impl FnOnce() -> T) -> f64 {
    let start = Instant::now();
    black_box(work());
    start.elapsed().as_secs_f64()
}

/// The default duration of one measurement, in seconds. It is long enough for caches and branch predictors to warm up,
/// and short compared with a time slice of the operating system.
pub const SPAN: f64 = 2e-3;

/// Measures the times of several pieces of work, which take turns. Returns for each one the minimum over `rounds`
/// rounds, in seconds. In a round each piece is repeated for `span` seconds.
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
            // The first round is not timed. It only finds the number of repetitions.
            *least = if round == 0 { taken } else { least.min(taken) };
        }
    }
    least
}

/// Appends a row to a table. The row has a name and figures, which are rounded to the given number of digits.
pub fn row(table: &mut String, name: &str, figures: &[f64], digits: usize) {
    *table += &format!("| {name}");
    for figure in figures {
        let _ = write!(table, " | {figure:.digits$}");
    }
    *table += " |\n";
}

/// Formats a section of `benches/RESULTS.md` from its title, the command that makes it, the machine, and the content
/// `rest`.
pub fn section(title: &str, command: &str, rest: &str) -> String {
    format!(
        "## {title}\n\n`{command}`, {}, one thread.\n\n{rest}",
        machine()
    )
}
