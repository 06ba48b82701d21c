//! The tables, and the page `docs/speed.md`.

use std::fmt::Write as _;
use std::path::Path;

use cosmic::case::Case;
use cosmic::scene::Scene;
use cosmic::verify::{Speed, measure};

use crate::Row;

/// The table of tapes; the first row is the primal that ratios are taken to.
pub(crate) fn tapes(rows: &[Row]) -> String {
    let primal = rows[0].time.unwrap_or(f64::NAN);
    let mut table = String::from("| one step | us | times the primal |\n| --- | --- | --- |\n");
    for Row { name, time } in rows {
        let row = match time {
            Ok(time) => format!("| {name} | {time:.3} | {:.1} |", time / primal),
            Err(why) => format!("| {name} | {why} | |"),
        };
        table += &row;
        table.push('\n');
    }
    table
}

/// Measures the rollouts and writes the page; returns where.
pub(crate) fn write(tapes: &str) -> std::io::Result<String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/speed.md");
    std::fs::write(&path, page(tapes))?;
    Ok("docs/speed.md".into())
}

fn page(tapes: &str) -> String {
    let machine = machine();
    let rollouts = rollouts();
    format!(
        "# Speed\n\n\
         Measured on {machine}; times are the least of many rounds taken in turns, on one thread. \
         This page is written by\n\n```sh\n\
         cargo bench -p benches --bench tapes --features rivals,xad-rs --ignore-rust-version -- --table\n\
         ```\n\n\
         ## The robot's rollout\n\n\
         6x6 nodes, 110 edges, 32 hidden units, 4096 steps, f64; microseconds a step. The \
         yardstick is the controller's two matrices times vectors and nothing else: it travels \
         between machines. Eight starts \
         of one design and controller run together, one a lane, where registers have room for \
         so many, with the bits of each alone; `cosmic explain --measure` says the same of any \
         scene. `cargo bench -p benches --bench rollout` takes the same figures with \
         their spread.\n\n{rollouts}\n\
         ## Scalar tapes\n\n\
         The gradient of one step of springs, damping and contact, 36 nodes and 110 springs, by \
         all positions, velocities and stiffnesses: plain scalar code, one source for all tapes, \
         nothing fused. All answers agree. A tape's record and memory are kept between \
         gradients where the crate can.\n\n{tapes}"
    )
}

fn rollouts() -> String {
    let mut table = String::from(
        "| design | rollout | value and design gradient | value and controller gradient | \
         two mat-vecs |\n| --- | --- | --- | --- | --- |\n",
    );
    for (name, scene) in [("mixture", "stability"), ("one-hot", "baseline_tall")] {
        let scene = Scene::load(scene).expect("the scene is built in");
        let case = Case::of_scene(&scene, 0).expect("a built-in scene is complete");
        let Speed {
            rollout,
            value_and_design_gradient: design,
            value_and_controller_gradient: controller,
            two_matvecs,
            eight_starts,
            eight_starts_and_design_gradient: eight_design,
            eight_starts_and_controller_gradient: eight_controller,
            ..
        } = measure(&case, &scene.loss);
        // A frozen layout does not depend on the design vectors.
        let alone = [rollout, design, controller, two_matvecs];
        let together = [eight_starts, eight_design, eight_controller, f64::NAN];
        let rows = [
            (name, alone, [1.0; 4], 3),
            ("… in mat-vecs", alone, [two_matvecs; 4], 2),
            ("… each of eight starts together", together, [1.0; 4], 3),
            ("… in those of one start", together, alone, 2),
        ];
        for (name, figures, units, digits) in rows {
            let _ = write!(table, "| {name}");
            for (column, (figure, unit)) in figures.into_iter().zip(units).enumerate() {
                let _ = match (column, figure.is_nan()) {
                    (1, _) if case.frozen.is_some() => write!(table, " | none: frozen"),
                    (_, true) => write!(table, " |"),
                    _ => write!(table, " | {:.digits$}", figure / unit),
                };
            }
            table += " |\n";
        }
    }
    table
}

/// Processor and registers.
fn machine() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let field = |name: &str| {
        let line = info.lines().find(|line| line.starts_with(name))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    };
    let name = field("model name").unwrap_or_else(|| "an unknown processor".into());
    let kind = [field("cpu family"), field("model\t")].map(Option::unwrap_or_default);
    let [family, model] = kind;
    let level = autodiff::lanes::level();
    format!("{name} (family {family}, model {model}), {level:?} lanes")
}
