//! `cosmic walk`, and goals in reports: the page and the animation.

use crate::cli_browser::{browser, document};
use crate::cli_report::{fetches_nothing, pictures};
use crate::common::Bench;
use cosmic::Registry;
use cosmic::case::Case;
use cosmic::outcome::DesignFile;
use cosmic_lab::walk::place;
use serde_json::Value;
use std::fs;
use std::sync::LazyLock;

/// A scene whose robot takes goals, and whose run takes a second.
const SCENE: &str = "
base = 'errand'
[lattice]
columns = 3
rows = 3
[physics]
dt = 0.00125
steps = 512
[schedule]
iterations = 12
";

/// A test folder with a finished run in the folder `run`. Tests share it, so each writes into other folders.
static BENCH: LazyLock<Bench> = LazyLock::new(|| {
    let bench = Bench::with(SCENE);
    bench.run("run", "--quiet");
    bench
});

fn case() -> Case {
    let scene = Registry::default()
        .read(&BENCH.path("run/scene.toml"))
        .unwrap();
    let design = DesignFile::read(&BENCH.path("run/design.json")).unwrap();
    design.case(&scene, "design.json").unwrap()
}

#[track_caller]
fn near(number: &Value, expected: f64) {
    let number = number.as_f64().unwrap();
    // Numbers of about 1 after a few operations.
    assert!(
        (number - expected).abs() < 1e-14,
        "{number} is not {expected}"
    );
}

/// The data for the scripts of a page.
fn data(page: &str) -> Value {
    let (_, data) = page.split_once("id=\"data\">").unwrap();
    serde_json::from_str(data.split_once("</script>").unwrap().0).unwrap()
}

/// The page and the animation show the goal of each moment.
#[test]
fn a_walk_is_drawn_with_its_goals() {
    BENCH.ok("walk run --goal 0.05 --goal 0.1@0.4s --out walk");
    let page = BENCH.read("walk/walk.html");
    fetches_nothing(&page);
    let data = data(&page);
    let start = place(&case(), [0.0; 2]).forward();
    let goals = data["goals"].as_array().unwrap();
    assert_eq!(goals.len(), 2);
    for (goal, expected) in goals.iter().zip([
        [0.0, start + 0.05, 0.0, 0.0, 0.05, 0.0],
        [0.4, start + 0.1, 0.0, 0.0, 0.1, 0.0],
    ]) {
        (0..6).for_each(|k| near(&goal[k], expected[k]));
    }
    // The walk takes 0.72 s: 0.4 s, and then half of the time of the scene. A frame is shown every 0.08 s.
    assert_eq!(pictures(&BENCH, "walk/walk.gif"), 10);
    assert!(shows_a_flag("walk/walk.gif"));
    if let Some(browser) = browser() {
        let page = document(browser, &BENCH.path("walk/walk.html").display().to_string());
        assert!(page.contains("data-ready=\"true\"") && !page.contains("data-error"));
    }
}

/// True if the first frame of an animation has the colour of the flag at a goal.
fn shows_a_flag(name: &str) -> bool {
    let file = fs::File::open(BENCH.path(name)).unwrap();
    let mut animation = gif::DecodeOptions::new().read_info(file).unwrap();
    let colours = animation.global_palette().unwrap().to_vec();
    let flag = colours
        .as_chunks::<3>()
        .0
        .iter()
        .position(|rgb| *rgb == [0x1a, 0x7f, 0x4b]);
    let flag = u8::try_from(flag.unwrap()).unwrap();
    animation
        .read_next_frame()
        .unwrap()
        .unwrap()
        .buffer
        .contains(&flag)
}

/// The report of a run whose robot takes goals shows the goal.
#[test]
fn a_report_shows_the_goal() {
    BENCH.ok("report run");
    let page = BENCH.read("run/report.html");
    fetches_nothing(&page);
    let goal = case().scene.controller.goal.forward();
    let goals = data(&page)["goals"].clone();
    near(&goals[0][1], goal);
    assert!(shows_a_flag("run/gait.gif"));
}
