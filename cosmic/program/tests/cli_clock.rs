//! A clock whose frequency is learned (`controller.clock = "learned"`), in all commands that read it.

use crate::common::Bench;
use std::f64::consts::TAU;

const LEARNED: &str = "--set controller.clock=learned";

/// A run writes the learned frequency, and the commands that read the run use it.
#[test]
fn all_commands_use_the_learned_frequency() {
    let bench = Bench::new(24, 400);
    bench.run("a", LEARNED);
    let tempo = |run: &str| {
        let design = bench.json(&format!("{run}/design.json"));
        design["controller"]["tempo"][0].as_f64().unwrap()
    };
    let omega = 10.0 * tempo("a").exp();
    assert!(omega != 10.0 && (omega - 10.0).abs() < 1.0, "{omega}");
    // Evaluated again, the robot has the displacement of the run.
    bench.evaluated("a");
    bench.ok("check a --steps 64");

    bench.ok("export a --mujoco --out e --set physics.contact=none");
    assert_eq!(bench.json("e/controller.json")["omega"], omega);
    // The report shows the last periods of the clock: 400 steps are longer than a period.
    bench.ok("report a");
    let page = bench.read("a/report.html");
    let period = page.split("\"period\":").nth(1).unwrap();
    let period = period.split([',', '}']).next().unwrap();
    assert_eq!(period.parse::<f64>().unwrap(), TAU / omega);

    // Another run goes on with the learned frequency.
    bench.ok("optimize --from a --out b");
    assert_ne!(tempo("b"), 0.0);
    bench.fails(
        "optimize --from a --out c --set controller.clock=fixed",
        2,
        &["`controller.tempo`", "set `controller.clock`"],
    );
    bench.run("d", "");
    bench.fails(
        &format!("optimize --from d --out c {LEARNED}"),
        2,
        &["`controller.tempo` is missing", "[0.0]"],
    );
}
