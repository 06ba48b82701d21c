//! The tables, and the page `docs/speed.md`.

use std::fmt::Write as _;

use benches::machine::{built_in, machine, row};
use cosmic_lab::verify::measure;

use crate::TapeRow;

/// The table of tapes; the first row is the primal that ratios are taken to.
pub(crate) fn tapes(rows: &[TapeRow]) -> String {
    let primal = rows[0].time.unwrap_or(f64::NAN);
    let mut table = String::from("| one step | us | times the primal |\n| --- | --- | --- |\n");
    for TapeRow { name, time } in rows {
        let row = match time {
            Ok(time) => format!("| {name} | {time:.3} | {:.1} |", time / primal),
            Err(why) => format!("| {name} | {why} | |"),
        };
        table += &row;
        table.push('\n');
    }
    table
}

/// Measures the rollouts and makes the page.
pub(crate) fn page(tapes: &str) -> String {
    let machine = machine();
    let rollouts = rollouts();
    format!(
        "# Speed\n\n\
         Measured on {machine}; times are the least of many rounds taken in turns, on one thread. \
         This page is written by\n\n```sh\n\
         cargo bench -p benches --bench tapes --features rivals,xad-rs --ignore-rust-version -- --table\n\
         ```\n\n\
         ## The robot's rollout\n\n\
         6x6 nodes, 110 edges, 32 hidden units, 4096 steps; microseconds a step. The \
         yardstick is the controller's two matrices times vectors in f64 and nothing else: it \
         travels between machines. The design gradient of a layout is the one by its mixture. \
         Eight starts of one design and controller run together, one a lane, where registers have \
         room for so many, with the bits of each alone. `cosmic explain --measure` says the same \
         of any scene, [instructions.md](instructions.md) counts instead of timing, and \
         [handwritten.md](handwritten.md) has an adjoint written by hand beside it.\n\n{rollouts}\n\
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
    let [mixture, one_hot] = ["stability", "baseline_tall"].map(|scene| {
        let (scene, case) = built_in(scene);
        measure(&case, &scene)
    });
    let unit = mixture.time("two_matvecs");
    for (name, speed, set) in [
        ("mixture, f64", &mixture, ""),
        ("mixture, f32", &mixture, "f32_"),
        ("one-hot, f64", &one_hot, "one_hot_"),
        ("one-hot, f32", &one_hot, "one_hot_f32_"),
        ("mixture, each of eight starts", &mixture, "eight_starts_"),
        ("one-hot, each of eight starts", &one_hot, "eight_starts_"),
    ] {
        let time = |work: &str| speed.time(&format!("{set}{work}"));
        let figures = [
            time("rollout"),
            time("value_and_design_gradient"),
            time("value_and_controller_gradient"),
            unit,
        ];
        row(&mut table, name, &figures, 3);
        row(&mut table, "… in mat-vecs", &figures.map(|f| f / unit), 2);
    }
    let own = one_hot.time("one_hot_own_materials");
    let own_f32 = one_hot.time("one_hot_f32_own_materials");
    let _ = write!(
        table,
        "\nA layout's value and gradient by what each edge has of its own material, and so by its \
         stiffness and strain, without what other materials would do there: {own:.3} in f64, \
         {own_f32:.3} in f32.\n"
    );
    let _ = write!(
        table,
        "\nThe performance and the stability projection of a design, side by side as an \
         optimisation takes them on one thread: {:.3} for value and design gradient of each.\n",
        mixture.time("one_of_two_designs")
    );
    let [first, last] = mixture.single_errors.map(|error| {
        format!(
            "{:.1e} (design) and {:.1e} (controller) over {} steps",
            error.design, error.controller, error.steps
        )
    });
    let _ = write!(
        table,
        "\nGradients in f32 (`gradient.precision`) are off those in f64, of the scene `stability` \
         at its start and as shares of their length, by {first}, by {last}.\n"
    );
    table
}
