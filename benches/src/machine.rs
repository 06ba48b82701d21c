//! Helpers that the benches share: a description of the machine, built-in robots, and sections of `RESULTS.md`.

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

/// Formats a section of `benches/RESULTS.md` from its title, the command that makes it, the machine, and the content
/// `rest`.
pub fn section(title: &str, command: &str, rest: &str) -> String {
    format!(
        "## {title}\n\n`{command}`, {}, one thread.\n\n{rest}",
        machine()
    )
}
