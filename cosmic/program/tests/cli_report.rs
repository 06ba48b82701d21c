//! `cosmic report` and `cosmic compare` as a user meets them: files, page, messages, exit codes.

use crate::program::cosmic;
use std::fs;
use std::io::{self, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// A run of seconds: small, slow to walk, with every phase.
const SCENE: &str = "
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

/// A finished run in `run` of a new folder.
fn finished() -> TempDir {
    let folder = TempDir::new().unwrap();
    let [scene, run] = ["tiny.toml", "run"].map(|name| path(&folder, name));
    fs::write(&scene, SCENE).unwrap();
    let (_, says, code) = cosmic(&["optimize", &scene, "--out", &run, "--quiet"]);
    assert_eq!((code, says.as_str()), (0, ""));
    folder
}

fn path(folder: &TempDir, name: &str) -> String {
    folder.path().join(name).to_str().unwrap().to_owned()
}

#[test]
fn a_report_is_a_page_two_pictures_and_an_animation() {
    let folder = finished();
    let run = path(&folder, "run");
    let (out, _, code) = cosmic(&["report", &run]);
    assert_eq!(code, 0);
    let names = ["report.html", "robot.svg", "convergence.svg", "gait.gif"];
    let written = names.map(|name| path(&folder, &format!("run/{name}")));
    assert!(out.lines().eq(written.iter().map(String::as_str)));

    let page = fs::read_to_string(&written[0]).unwrap();
    assert!(page.contains("tiny, seed 0") && page.contains("gradient.cotangent_bound"));
    // The page fetches nothing: no element of it refers to another file.
    for reference in ["src=", "href=", "url(", "@import", "fetch("] {
        assert!(!page.contains(reference), "the page has {reference}");
    }
    let animation = fs::File::open(&written[3]).unwrap();
    let mut animation = gif::DecodeOptions::new().read_info(animation).unwrap();
    let mut frames = 0;
    while let Some(frame) = animation.read_next_frame().unwrap() {
        let mut colours = frame.buffer.to_vec();
        colours.sort_unstable();
        colours.dedup();
        // Sky, ground and robot at least.
        assert!((frame.width, frame.height) == (480, 240) && colours.len() > 3);
        frames += 1;
    }
    // 1.024 s, ten frames a second, both ends included.
    assert_eq!(frames, 11);
}

#[test]
fn what_is_missing_or_cut_off_is_named() {
    let folder = finished();
    let run = path(&folder, "run");
    let files = [
        "summary.json",
        "scene.toml",
        "design.json",
        "history.jsonl",
        "trajectory.json",
    ];
    for name in files {
        let file = path(&folder, &format!("run/{name}"));
        let whole = fs::read(&file).unwrap();
        fs::remove_file(&file).unwrap();
        // Without a history a run is drawn, see below.
        if name != "history.jsonl" {
            let (_, says, code) = cosmic(&["report", &run]);
            assert!(
                code == 4 && says.contains(name),
                "{name} missing: {code}, {says}"
            );
        }
        // Not on a line's end, where a list of lines would be whole.
        fs::write(&file, &whole[..whole.len() / 2 + 1]).unwrap();
        let (_, says, code) = cosmic(&["report", &run]);
        assert!(
            code == 2 && says.contains(name),
            "{name} cut off: {code}, {says}"
        );
        fs::write(&file, whole).unwrap();
    }
    assert!(!Path::new(&path(&folder, "run/report.html")).exists());
    assert_eq!(
        cosmic(&["report", &run, "--quiet"]),
        (String::new(), String::new(), 0)
    );
}

#[test]
fn a_run_without_a_history_is_drawn() {
    let folder = finished();
    let run = path(&folder, "run");
    fs::remove_file(path(&folder, "run/history.jsonl")).unwrap();
    let (out, says, code) = cosmic(&["report", &run]);
    assert_eq!((code, out.lines().count()), (0, 3), "{out}{says}");
    assert!(!out.contains("convergence.svg"), "{out}");
    let page = fs::read_to_string(path(&folder, "run/report.html")).unwrap();
    assert!(page.contains("No history was kept."));
}

/// A folder with a design and its scene alone, and a design's file of any name.
#[test]
fn a_design_alone_is_drawn() {
    let folder = finished();
    let alone = path(&folder, "alone");
    fs::create_dir(&alone).unwrap();
    for name in ["scene.toml", "design.json"] {
        let [from, to] = ["run", "alone"].map(|of| path(&folder, &format!("{of}/{name}")));
        fs::copy(from, to).unwrap();
    }
    let written = ["report.html", "robot.svg"].map(|name| format!("{alone}/{name}"));
    let (out, says, code) = cosmic(&["report", &alone]);
    assert_eq!(code, 0, "{says}");
    assert!(out.lines().eq(written.iter().map(String::as_str)), "{out}");
    let page = fs::read_to_string(&written[0]).unwrap();
    assert_eq!(page.matches("</svg>").count(), 2);
    assert!(page.contains("9 nodes, 20 edges") && !page.contains("<script"));

    for file in &written {
        fs::remove_file(file).unwrap();
    }
    let [design, best] = ["design.json", "best.json"].map(|name| format!("{alone}/{name}"));
    fs::rename(design, &best).unwrap();
    let (out, says, code) = cosmic(&["report", &best]);
    assert_eq!((code, out.lines().count()), (0, 2), "{says}");
    fs::remove_file(format!("{alone}/scene.toml")).unwrap();
    let (_, says, code) = cosmic(&["report", &best]);
    assert!(code == 4 && says.contains("alone/scene.toml"), "{says}");
    let (_, says, code) = cosmic(&["report", &alone]);
    assert!(code == 4 && says.contains("alone/summary.json"), "{says}");
}

#[test]
fn a_run_without_a_result_says_why_and_what_to_do() {
    let folder = finished();
    let run = path(&folder, "run");
    let says = |end: &str| {
        for command in ["report", "compare"] {
            let (_, says, code) = cosmic(&[command, &run]);
            let whole = format!("error: cannot read {run}/summary.json: {end}\n");
            assert_eq!((says, code), (whole, 4), "{command}");
        }
    };
    let says_of_design = |end: &str| {
        for command in [
            &["evaluate", &run][..],
            &["robustness", &run],
            &["optimize", "--from", &run],
        ] {
            let (_, says, code) = cosmic(command);
            let whole = format!("error: cannot read {run}/design.json: {end}\n");
            assert_eq!((says, code), (whole, 4), "{command:?}");
        }
    };
    for name in ["summary.json", "design.json"] {
        fs::remove_file(path(&folder, &format!("run/{name}"))).unwrap();
    }
    let go_on = format!("the run is not finished; go on with: cosmic resume {run}");
    says(&go_on);
    says_of_design(&go_on);
    // One for a loss that no file holds.
    let snapshot = path(&folder, "run/snapshot.json");
    let text = fs::read_to_string(&snapshot).unwrap();
    let own = text.replacen("\"progress\":{", "\"progress\":{\"own_loss\":true,", 1);
    fs::write(&snapshot, own).unwrap();
    says(&format!(
        "the run is not finished; go on by record::resume_with, with its own loss, in {run}"
    ));

    fs::remove_dir_all(&run).unwrap();
    let wild = SCENE.replace("incline_deg = 10.0", "dt = 0.01\ndamping = 0.0")
        + "[materials]\nstiffness = [1e-7, 4e3, 30.0]\n";
    let scene = path(&folder, "wild.toml");
    fs::write(&scene, wild).unwrap();
    let (_, _, code) = cosmic(&["optimize", &scene, "--out", &run, "--allow-unstable"]);
    assert_eq!(code, 3);
    says(&format!(
        "the run diverged; see its last states with: cosmic evaluate {run}/diverged.json"
    ));

    // No run at all.
    fs::remove_dir_all(&run).unwrap();
    let (_, says, code) = cosmic(&["report", &run]);
    assert!(code == 4 && !says.contains("resume"), "{says}");
}

#[test]
fn files_of_another_run_do_not_fit() {
    let folder = finished();
    let run = path(&folder, "run");
    let scene = path(&folder, "run/scene.toml");
    let text = fs::read_to_string(&scene).unwrap();
    fs::write(&scene, text.replace("columns = 3", "columns = 4")).unwrap();
    let (_, says, code) = cosmic(&["report", &run]);
    assert!(
        code == 2 && says.contains("design.json") && says.contains("expected 29 `edges`, found 20"),
        "{says}"
    );
    fs::write(&scene, text).unwrap();

    let trajectory = path(&folder, "run/trajectory.json");
    let text = fs::read_to_string(&trajectory).unwrap();
    fs::write(
        &trajectory,
        text.replace("\"steps\":[0,16,", "\"steps\":[16,0,"),
    )
    .unwrap();
    let (_, says, code) = cosmic(&["report", &run]);
    assert!(code == 2 && says.contains("`steps` must ascend"), "{says}");
    fs::write(&trajectory, text).unwrap();

    // A summary of another design, and of another rollout.
    let summary = path(&folder, "run/summary.json");
    let text = fs::read_to_string(&summary).unwrap();
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    for (key, other) in [
        ("/V", "design.json"),
        ("/displacement/0", "trajectory.json"),
    ] {
        let mut wrong = json.clone();
        let number = wrong.pointer_mut(key).unwrap();
        *number = (number.as_f64().unwrap() + 1e-6).into();
        let changed = number.to_string();
        fs::write(&summary, wrong.to_string()).unwrap();
        let (_, says, code) = cosmic(&["report", &run]);
        assert!(
            code == 2 && says.contains("summary.json") && says.contains(other),
            "{says}"
        );
        assert!(says.contains(&changed), "{changed}: {says}");
    }
    fs::write(&summary, text).unwrap();
    assert_eq!(cosmic(&["report", &run, "--quiet"]).2, 0);
}

#[test]
fn a_history_of_another_version_or_without_all_its_rows_is_refused() {
    let folder = finished();
    let run = path(&folder, "run");
    let refused = |name: &str, change: fn(&str) -> Vec<u8>, words: &str| {
        let file = path(&folder, &format!("run/{name}"));
        let whole = fs::read_to_string(&file).unwrap();
        fs::write(&file, change(&whole)).unwrap();
        let (_, says, code) = cosmic(&["report", &run]);
        assert!(
            code == 2 && says.contains(name) && says.contains(words),
            "{code}, {says}"
        );
        fs::write(&file, whole).unwrap();
    };
    let last_of_another_version = |text: &str| {
        let at = text.rfind("\"version\":1").unwrap();
        [&text[..at], "\"version\":7", &text[at + 11..]]
            .concat()
            .into()
    };
    refused(
        "history.jsonl",
        last_of_another_version,
        "history.jsonl:12:1",
    );
    refused("designs.jsonl", last_of_another_version, "version 7, not");
    refused("history.jsonl", |_| Vec::new(), "iterations 1 to 12");
    let without_the_first = |text: &str| text.split_once('\n').unwrap().1.into();
    refused("history.jsonl", without_the_first, "iterations 1 to 12");
    let no_text = |text: &str| [text.as_bytes(), b"\xff\n"].concat();
    refused("history.jsonl", no_text, "history.jsonl:13:");
}

/// A robot a hundred million lattices away in the end, and a rollout of hours: neither is too much
/// to draw.
#[test]
fn a_robot_far_away_and_a_long_rollout_are_drawn() {
    let steep = "incline_deg = 60.0\ncontact = \"coulomb\"\nfriction = 0.0\ngravity = 1000.0\n\
                 damping = 0.0\n[materials]\nstiffness = [1e-7, 1.0, 1.0]\n";
    let long = "dt = 1.0\ngravity = 0.0\n[materials]\nstiffness = [0.0, 0.0, 0.0]\n";
    for physics in [steep, long] {
        let folder = TempDir::new().unwrap();
        let [scene, run] = ["scene.toml", "run"].map(|name| path(&folder, name));
        let text = "[lattice]\ncolumns = 2\nrows = 2\nspacing = 0.001\n[physics]\nsteps = 10000\n";
        fs::write(&scene, [text, physics].concat()).unwrap();
        let once = ["--iterations", "1", "--out", &run, "--quiet"];
        let optimize = [&["optimize", &scene][..], &once].concat();
        for command in [&optimize[..], &["report", &run, "--quiet"]] {
            let (_, says, code) = cosmic(command);
            assert_eq!(code, 0, "{says}");
        }
        let animation = fs::metadata(path(&folder, "run/gait.gif")).unwrap();
        assert!(animation.len() < 4_000_000);
    }
}

#[test]
fn a_page_that_cannot_be_written_is_exit_4() {
    let folder = finished();
    // A folder in the file's place stops root as well.
    fs::create_dir_all(folder.path().join("run/report.html/in the way")).unwrap();
    let (_, says, code) = cosmic(&["report", &path(&folder, "run")]);
    assert!(
        code == 4 && says.contains("cannot write") && says.contains("report.html"),
        "{says}"
    );
}

#[test]
fn compare_has_a_row_for_every_run() {
    let folder = finished();
    let run = path(&folder, "run");
    let page = path(&folder, "compare.html");
    let (out, _, code) = cosmic(&["compare", &run, &run, "--out", &page]);
    let rows: Vec<&str> = out.lines().collect();
    assert!(code == 0 && rows.len() == 3 && rows[1] == rows[2] && rows[1].starts_with("run "));
    let text = fs::read_to_string(path(&folder, "run/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
    let median = format!("{:.3}", summary["displacement_p50"].as_f64().unwrap());
    assert!(rows[1].replace('\u{2212}', "-").contains(&median));
    let html = fs::read_to_string(page).unwrap();
    assert_eq!(html.matches("<tr>").count(), 3);

    let (out, _, code) = cosmic(&["compare", &run, &run, "--json"]);
    let json: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!((code, &json["runs"][1]["run"]), (0, &"run".into()));
    let compared = &json["runs"][0]["summary"];
    assert_eq!(compared["displacement_p50"], summary["displacement_p50"]);

    // Another run of the name, for another task.
    assert!(!rows[0].contains("loss"));
    let other = path(&folder, "other/run");
    fs::create_dir_all(&other).unwrap();
    let text = text.replacen("\"seed\":", "\"loss_p50\": -1.25,\n\"seed\":", 1);
    fs::write(path(&folder, "other/run/summary.json"), text).unwrap();
    let (out, _, code) = cosmic(&["compare", &run, &other]);
    let rows: Vec<&str> = out.lines().collect();
    assert!(code == 0 && rows[0].ends_with("loss p50"), "{out}");
    assert!(
        rows[1].starts_with(&run) && rows[1].ends_with(" –"),
        "{out}"
    );
    assert!(
        rows[2].starts_with(&other) && rows[2].ends_with("1.2500"),
        "{out}"
    );

    let (_, says, code) = cosmic(&["compare", &run, &path(&folder, "none")]);
    assert!(code == 4 && says.contains("none"), "{says}");
    assert_eq!(cosmic(&["compare"]).2, 2);
}

/// A browser of the Chromium family, where there is one.
fn browser() -> Option<&'static str> {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let runs = |name: &&str| Command::new(name).arg("--version").output().is_ok();
    names.into_iter().find(runs)
}

/// The document that a browser makes of a file, scripts run for a second of its own time.
fn document(browser: &str, file: &str) -> String {
    let profile = TempDir::new().unwrap();
    let page = profile.path().join("page.html");
    let mut child = Command::new(browser)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-quic",
        ])
        .args([
            "--no-first-run",
            "--disable-background-networking",
            "--disable-sync",
        ])
        .args([
            "--disable-component-update",
            "--virtual-time-budget=1000",
            "--dump-dom",
        ])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg(format!("file://{file}"))
        .stdout(fs::File::create(&page).unwrap())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let began = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if began.elapsed() > Duration::from_secs(120) {
            child.kill().unwrap();
            panic!("{browser} hangs");
        }
        thread::sleep(Duration::from_millis(20));
    }
    fs::read_to_string(page).unwrap()
}

#[test]
fn a_browser_draws_the_page_without_errors() {
    let Some(browser) = browser() else {
        // Past the test harness, which hides what passing tests print.
        writeln!(
            io::stderr(),
            "no chromium here: the page is not opened in a browser"
        )
        .unwrap();
        return;
    };
    let folder = finished();
    assert_eq!(cosmic(&["report", &path(&folder, "run")]).2, 0);
    let page = document(browser, &path(&folder, "run/report.html"));
    // The script sets `ready` at its end, and `error` should anything be thrown, then or later.
    assert!(
        page.contains("data-ready=\"true\""),
        "the script did not end"
    );
    assert!(!page.contains("data-error"), "the script failed");
    assert_eq!(page.matches("</svg>").count(), 4);
    for name in ["robot.svg", "convergence.svg"] {
        let picture = document(browser, &path(&folder, &format!("run/{name}")));
        // XML that is not well formed is replaced by a `parsererror`.
        assert!(
            picture.contains("</svg>") && !picture.contains("parsererror"),
            "{name}"
        );
    }
}
