//! `cosmic report`: pictures, and numbers that agree with those of the run.

use crate::cli_workshop::table;
use crate::common::Bench;
use crate::program::Told;
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
    assert_eq!((&told.out[..], &told.error[..]), ("", ""));
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

/// Before the snap, every edge is a mixture of materials. Its bar is also drawn, but faintly.
#[test]
fn a_robot_of_mixtures_is_drawn() {
    let bench = Bench::with(SCENE);
    bench.unfinished("run", 2);
    report(&bench).ok();
    let drawn = bench.read("run/robot.svg").matches("<polyline").count();
    // The pictures show at least one moment of the walk and six moments of the gait, with 20 edges each.
    assert!(drawn >= 7 * 20, "{drawn} lines");
}

/// The page lists the strains beyond the limit, and the pictures draw such bars in a separate colour.
#[test]
fn strains_beyond_the_limit_are_named() {
    let bench = Bench::with(&(SCENE.to_owned() + "[materials]\nmax_strain = [0.0, 0.0, 1e-4]\n"));
    bench.run("run", "--quiet");
    report(&bench).ok();
    let page = bench.read("run/report.html");
    assert!(page.contains("are strained beyond \u{b1}0.0 %</b>"));
    let drawn = bench.read("run/robot.svg");
    assert!(drawn.matches("#b800b8").count() > 1, "more than the legend");
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

/// Reports of extreme runs: a robot that ends a hundred million lattice widths away, and a rollout that lasts hours.
#[test]
fn a_robot_far_away_and_a_long_rollout_are_drawn() {
    let steep = "incline_deg = 60.0\ncontact = \"coulomb\"\nfriction = 0.0\ngravity = 1000.0\n\
                 speed_bound = \"off\"\ndamping = 0.0\n[materials]\nstiffness = [1e-7, 1.0, 1.0]\n";
    let long = "dt = 1.0\ngravity = 0.0\n[materials]\nstiffness = [0.0, 0.0, 0.0]\n";
    for physics in [steep, long] {
        let text = "base = \"stability\"\n[lattice]\ncolumns = 2\nrows = 2\nspacing = 0.001\n[physics]\nsteps = 10000\n";
        let bench = Bench::with(&[text, physics].concat());
        bench.run("run", "--iterations 1 --quiet");
        report(&bench).ok();
        let animation = fs::metadata(bench.path("run/gait.gif")).unwrap();
        assert!(animation.len() < 4_000_000);
    }
}

/// The smallest Euler safety of a run with parts is in its summary, and that of every skeleton bar in `bars.csv`.
#[test]
fn the_euler_safety_of_parts_is_that_of_the_worst_bar() {
    let parts = "[parts]\nskeleton = 'strut'\nmaterial = 'pla'\nouter = 0.003\njoint = 1e3\nend_mass = 0.001\n";
    let bench = Bench::with(&[SCENE, parts].concat());
    bench.run("run", "--quiet");
    let summary = bench.json("run/summary.json");
    let least = summary["loads"]["euler_safety"].as_f64().unwrap();
    assert!(least > 0.0, "{least}");
    bench.ok("export run --csv --out made");
    let bars = table(&bench, "made/bars.csv");
    let safeties = bars
        .iter()
        .filter_map(|bar| bar["euler_safety"].parse().ok());
    let smallest = safeties.fold(f64::INFINITY, f64::min);
    // The table has nine decimals.
    assert!((smallest - least).abs() < 1e-9, "{smallest} {least}");
}

#[test]
fn a_comparison_has_the_medians_of_the_summaries() {
    let bench = finished();
    let told = bench.ok("report run run").out;
    let row = told.lines().nth(1).unwrap().replace('\u{2212}', "-");
    let summary = bench.json("run/summary.json");
    let median = summary["displacement_robust_p50"].as_f64().unwrap();
    assert!(row.contains(&format!(" {median:.3} ")), "{told}");
    let json = bench.cosmic("report run run --json").json();
    let run = &json["runs"][1];
    assert_eq!(run["summary"]["displacement_robust_p50"], median);
    let text = run["verdict"][0]["text"].as_str().unwrap();
    assert!(told.contains(text), "{told}");
}
