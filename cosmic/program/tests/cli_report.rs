//! `cosmic report`: pictures, and robots whose edges have no material yet.

use crate::common::Bench;
use crate::program::{Told, has};
use serde_json::Value;
use std::fs;

/// A scene whose run takes a few seconds and goes through every phase.
const SCENE: &str = "
base = 'stability'
[lattice]
columns = 3
rows = 3
[physics]
steps = 512
incline_deg = 10.0
[schedule]
iterations = 12
attraction_from = 6
snap_at = 8
horizon = [64, 128]
horizon_over = [2, 5]
[loss]
window = 64
";

/// A test folder with a finished run in the folder `run`.
pub(crate) fn finished() -> Bench {
    let bench = Bench::with(SCENE);
    let told = bench.run("run", "--quiet");
    assert!(told.out.starts_with("run: run\n"), "{}", told.out);
    assert_eq!(told.error, "");
    bench
}

pub(crate) fn report(bench: &Bench) -> Told {
    bench.cosmic("report run")
}

#[test]
fn a_report_has_an_animation() {
    let bench = finished();
    report(&bench).ok();
    fetches_nothing(&bench.read("run/report.html"));
    // The walk lasts 1.024 s. The animation has a frame at its start and one every 0.08 s.
    assert_eq!(pictures(&bench, "run/gait.gif"), 13);
}

/// Asserts that no element and no script of a page loads another file.
pub(crate) fn fetches_nothing(page: &str) {
    let page = page.replace("href=\"data:,\"", "");
    for reference in ["src=", "href=", "url(", "@import", "fetch("] {
        assert!(!page.contains(reference), "the page has {reference}");
    }
}

/// Returns the number of frames of an animation. Asserts that each shows a robot on its ground.
pub(crate) fn pictures(bench: &Bench, name: &str) -> usize {
    let animation = fs::File::open(bench.path(name)).unwrap();
    let mut animation = gif::DecodeOptions::new().read_info(animation).unwrap();
    let mut count = 0;
    while let Some(frame) = animation.read_next_frame().unwrap() {
        let mut colours = frame.buffer.to_vec();
        colours.sort_unstable();
        colours.dedup();
        // A frame with sky, ground and robot has at least four colours.
        assert!((frame.width, frame.height) == (800, 334) && colours.len() > 3);
        count += 1;
    }
    count
}

/// A test folder with a finished run of a robot in space, in the folder `run`.
pub(crate) fn in_space() -> Bench {
    let settings = "[lattice]\nkind = 'cubic'\ndepth = 2\n";
    let bench = Bench::with(&SCENE.replace("[lattice]\n", settings));
    bench.run("run", "--quiet");
    bench
}

#[test]
fn only_a_robot_in_space_is_drawn_from_three_sides() {
    for (bench, sides) in [(in_space(), 1), (finished(), 0)] {
        report(&bench).ok();
        let picture = bench.read("run/robot.svg");
        for text in ["from the front", "from the side", "from above", "Footfalls"] {
            assert_eq!(
                picture.matches(&format!(">{text}")).count(),
                sides,
                "{text}"
            );
        }
        assert_eq!(pictures(&bench, "run/gait.gif"), 13);
    }
}

/// Before the snap, every edge is a mixture of materials. Its bar is also drawn, but faintly. There are no counts of bars and
/// no loads yet.
#[test]
fn a_robot_of_mixtures_is_undecided() {
    let bench = Bench::default();
    bench.unfinished("run", 15);
    let said = bench.ok("resume run");
    let summary = bench.json("run/summary.json");
    assert_eq!(
        (&summary["stop_reason"], &summary["undecided"]),
        (&"unfinished".into(), &true.into())
    );
    // The two volumes are means over 20 edges, which were added in different orders.
    let [told, found] =
        [&summary, &bench.evaluated("run")].map(|numbers| numbers["V"].as_f64().unwrap());
    assert!((told - found).abs() < 1e-15);
    for nothing in ["structure", "loads"] {
        assert_eq!(summary.get(nothing), Some(&Value::Null));
    }
    let exported = bench.ok("export run --csv");
    has(&exported.error, &["the design is undecided"]);
    report(&bench).ok();
    let drawn = bench.read("run/robot.svg").matches("<polyline").count();
    // The pictures show at least one moment of the walk and six moments of the gait, with 20 edges each.
    assert!(drawn >= 7 * 20, "{drawn} lines");
    let page = bench.read("run/report.html");
    let compared = bench.ok("report run run").out;
    for text in [&said.out, &page, &compared] {
        has(text, &["undecided"]);
        for wrong in ["0 pieces", "0.00 N", "No edge is an actuator"] {
            assert!(!text.contains(wrong), "{wrong}");
        }
    }
}

/// Makes a folder that contains only the design and the scene of the run.
pub(crate) fn design_alone(bench: &Bench, folder: &str) {
    fs::create_dir(bench.path(folder)).unwrap();
    for name in ["scene.toml", "design.json"] {
        bench.write(
            &format!("{folder}/{name}"),
            bench.read(&format!("run/{name}")),
        );
    }
}
