//! `cosmic report`: files, pages, messages, exit codes.

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

/// Changes one file of the run, asserts that `report` refuses the run, and restores the file.
fn refused(bench: &Bench, name: &str, content: impl AsRef<[u8]>, says: &[&str]) {
    let file = format!("run/{name}");
    let whole = bench.read(&file);
    bench.write(&file, content);
    report(bench).fails(2, says);
    bench.write(&file, whole);
}

#[test]
fn a_report_is_a_page_a_picture_and_an_animation() {
    let bench = finished();
    let told = report(&bench).ok();
    assert!(told.error.starts_with("verdict: "), "{told:?}");
    let told = told.out;
    let names = ["report.html", "robot.svg", "gait.gif"];
    let written = names.map(|name| format!("run/{name}"));
    assert!(told.lines().eq(&written));

    let page = bench.read("run/report.html");
    assert!(page.contains("tiny, seed 0") && page.contains("lattice.columns"));
    // The verdict comes first, then the moving robot, the poses and the tiles. Parts for authors are folded at the end.
    let places = [
        "class=\"verdict",
        "id=\"stage\"",
        "s of walking",
        "class=\"figures\"",
        "<details><summary>Convergence",
    ];
    let places = places.map(|part| page.find(part).unwrap_or_else(|| panic!("no {part}")));
    assert!(places.is_sorted(), "{places:?}");
    fetches_nothing(&page);
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

/// The page plays the recorded walks of the iterations. Runs of earlier versions kept designs without walks.
#[test]
fn a_page_has_the_walks_of_several_iterations() {
    let bench = finished();
    report(&bench).ok();
    let page = bench.read("run/report.html");
    assert!(page.contains("\"iteration\":10,") && page.matches("\"every\":0.084").count() == 2);
    let rows = bench.read("run/designs.jsonl");
    let without = rows.lines().map(|row| {
        let (before, _) = row.split_once(",\"walk\"").unwrap();
        format!("{before}}}\n")
    });
    bench.write("run/designs.jsonl", without.collect::<String>());
    report(&bench).ok();
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

#[test]
fn a_missing_or_truncated_file_is_named() {
    let bench = finished();
    for name in [
        "summary.json",
        "scene.toml",
        "design.json",
        "history.jsonl",
        "trajectory.json",
    ] {
        let file = format!("run/{name}");
        let whole = bench.read(&file);
        // Two files may be missing: a run without a history or with a part of it is drawn (see below), and the scene is also in
        // the snapshot.
        if !["history.jsonl", "scene.toml"].contains(&name) {
            bench.remove(&file);
            report(&bench).fails(4, &[name]);
            bench.write(&file, &whole);
        }
        // The text ends in the middle of a line, because a smaller number of complete lines could be valid.
        if name != "history.jsonl" {
            refused(&bench, name, &whole[..whole.len() / 2 + 1], &[name]);
        }
    }
    assert!(!bench.path("run/report.html").exists());
    let told = bench.cosmic("report run --quiet").ok();
    assert_eq!((&told.out[..], &told.error[..]), ("", ""));
}

#[test]
fn a_run_without_a_history_is_drawn() {
    let bench = finished();
    bench.remove("run/history.jsonl");
    report(&bench).ok();
    let page = bench.read("run/report.html");
    assert!(page.contains("No history was kept."));
}

/// A full disk or an interrupted copy cuts a history off, also in the middle of a line. The page shows what is left.
#[test]
fn a_history_that_was_cut_off_is_drawn() {
    let bench = finished();
    for file in ["history.jsonl", "designs.jsonl"] {
        let text = bench.read(&format!("run/{file}"));
        bench.write(&format!("run/{file}"), &text[..text.len() / 2 + 3]);
    }
    report(&bench).ok();
    let page = bench.read("run/report.html");
    assert!(!page.contains("No history was kept."));
    bench.write("run/history.jsonl", "");
    report(&bench).ok();
    assert!(
        bench
            .read("run/report.html")
            .contains("No history was kept.")
    );
}

/// A finished run lacks a file of its result. The error says how to write the file again, and that works.
#[test]
fn a_missing_file_of_a_finished_run_is_restored() {
    let bench = Bench::finished();
    let before = bench.results("a");
    for (file, command) in [
        ("trajectory.json", "report a"),
        ("design.json", "evaluate a"),
    ] {
        bench.remove(&format!("a/{file}"));
        let says = "delete a/summary.json and continue with: cosmic resume a";
        bench.fails(
            command,
            4,
            &[file, "the run is finished, but this file is missing", says],
        );
        bench.remove("a/summary.json");
        bench.ok("resume a");
        assert_eq!(bench.results("a"), before);
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

/// A report needs no run. A folder with only a design and its scene is enough, and so is a design file beside a scene.
#[test]
fn a_design_alone_is_drawn() {
    let bench = finished();
    design_alone(&bench, "alone");
    let told = bench.cosmic("report alone").ok();
    assert_eq!(told.out, "alone/report.html\n");
    let page = bench.read("alone/report.html");
    assert!(page.contains("9 nodes, 20 edges") && !page.contains("id=\"stage\""));
    fetches_nothing(&page);
    bench.remove("alone/report.html");
    fs::rename(
        bench.path("alone/design.json"),
        bench.path("alone/best.json"),
    )
    .unwrap();
    let told = bench.cosmic("report alone/best.json").ok();
    assert_eq!(told.out, "alone/report.html\n");
    bench.remove("alone/scene.toml");
    let told = bench.cosmic("report alone/best.json");
    told.fails(4, &["alone/scene.toml"]);
    bench.cosmic("report alone").fails(
        4,
        &["cannot read alone: ", "because it has no summary.json"],
    );
}

#[test]
fn a_run_without_a_result_says_why_and_what_to_do() {
    let bench = finished();
    let says = |lines: &[&str], file: &str, end: &str| {
        for line in lines {
            let told = bench.cosmic(line);
            let whole = format!("error: cannot read run/{file}: {end}\n");
            assert_eq!((told.error, told.code), (whole, 4), "{line}");
        }
    };
    let of_summary = |end: &str| says(&["report run", "report run run"], "summary.json", end);
    bench.remove("run/summary.json");
    bench.remove("run/design.json");
    let go_on = "the run is not finished; continue with: cosmic resume run";
    of_summary(go_on);
    let of_design = ["evaluate run", "robustness run", "optimize --from run"];
    says(&of_design, "design.json", go_on);
    // Change the run into one with a loss that a program adds. No file contains such a loss, so the advice is not
    // `cosmic resume`.
    let text = bench.read("run/snapshot.json");
    let own = text.replacen("\"progress\":{", "\"progress\":{\"own_loss\":true,", 1);
    bench.write("run/snapshot.json", own);
    of_summary(
        "the run is not finished; continue with record::resume_with and the loss of the run in run",
    );

    fs::remove_dir_all(bench.path("run")).unwrap();
    let wild = SCENE.replace("incline_deg = 10.0", "dt = 0.01\ndamping = 0.0")
        + "[materials]\nstiffness = [1e-7, 4e3, 30.0]\n";
    bench.write("tiny.toml", wild);
    bench.optimize("run", "--allow-unstable").fails(3, &[]);
    of_summary("the run diverged; see its last states with: cosmic evaluate run/diverged.json");

    // If the folder is missing, the error must not advise to resume the run.
    fs::remove_dir_all(bench.path("run")).unwrap();
    let told = report(&bench);
    told.fails(4, &[]);
    assert!(!told.error.contains("resume"), "{told:?}");
}

#[test]
fn files_of_another_run_or_version_are_refused() {
    let bench = finished();
    let read = |name: &str| bench.read(&format!("run/{name}"));
    let last_of_another_version = |name: &str| {
        let text = read(name);
        let (before, after) = text.rsplit_once("\"version\":1").unwrap();
        format!("{before}\"version\":7{after}").into_bytes()
    };
    let wider = read("scene.toml").replace("columns = 3", "columns = 4");
    let steps = ["\"steps\":[0,16,", "\"steps\":[16,0,"];
    let descending = read("trajectory.json").replace(steps[0], steps[1]);
    let history = read("history.jsonl");
    let (_, without_the_first) = history.split_once('\n').unwrap();
    let no_text = [history.as_bytes(), b"\xff\n"].concat();
    let began = "not the scene with which the run began";
    for (name, content, says) in [
        ("scene.toml", wider.into_bytes(), began),
        ("trajectory.json", descending.into(), "`steps` must ascend"),
        (
            "history.jsonl",
            last_of_another_version("history.jsonl"),
            "history.jsonl:12:1",
        ),
        (
            "designs.jsonl",
            last_of_another_version("designs.jsonl"),
            "version 7, not",
        ),
        (
            "history.jsonl",
            without_the_first.into(),
            "iterations 1 to 12",
        ),
        ("history.jsonl", no_text, "history.jsonl:13:"),
    ] {
        refused(&bench, name, content, &[name, says]);
    }
    // In each case the summary does not fit one of the other files: it is of another design or of another rollout.
    for (key, other) in [
        ("/V", "design.json"),
        ("/V_act", "design.json"),
        ("/displacement/0", "trajectory.json"),
    ] {
        let mut wrong = bench.json("run/summary.json");
        let number = wrong.pointer_mut(key).unwrap();
        *number = (number.as_f64().unwrap() + 1e-6).into();
        let changed = number.to_string();
        let says = ["summary.json", other, &changed, "not all from one run"];
        refused(&bench, "summary.json", wrong.to_string(), &says);
    }
    bench.cosmic("report run --quiet").ok();
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

#[test]
fn a_page_that_cannot_be_written_exits_with_4() {
    let bench = finished();
    // A folder at the path of the page prevents writing the page, even for root.
    fs::create_dir_all(bench.path("run/report.html/in the way")).unwrap();
    report(&bench).fails(4, &["cannot write", "report.html"]);
}

/// Bars of plain numbers have no Euler safety. The smallest of a run with parts is in its summary, and every skeleton bar's
/// in `bars.csv` and on the page.
#[test]
fn the_euler_safety_of_parts_is_shown() {
    let bench = finished();
    let parts = "\n[parts]\nskeleton = 'strut'\nmaterial = 'pla'\nouter = 0.003\njoint = 1e3\nend_mass = 0.001\n";
    bench.write("parts.toml", format!("{SCENE}{parts}"));
    let told = bench.ok("optimize parts.toml --out made");
    assert!(told.out.contains("skeleton: Euler safety "), "{told:?}");
    let summary = bench.json("made/summary.json");
    let least = summary["loads"]["euler_safety"].as_f64().unwrap();
    assert!(least > 0.0, "{least}");
    let plain = bench.json("run/summary.json");
    assert!(plain["loads"]["euler_safety"].is_null());

    bench.ok("export made --csv");
    let bars = bench.read("made/export/bars.csv");
    let mut rows = bars.lines().map(|row| row.split(',').collect::<Vec<_>>());
    let head = rows.next().unwrap();
    let column = |name: &str| head.iter().position(|column| *column == name).unwrap();
    let (safety, material) = (column("euler_safety"), column("material"));
    let (of_actuators, of_skeleton): (Vec<_>, Vec<_>) =
        rows.partition(|row| row[material] == "actuator");
    assert!(of_actuators.iter().all(|row| row[safety].is_empty()));
    let known = of_skeleton
        .iter()
        .filter_map(|row| row[safety].parse().ok());
    let smallest = known.fold(f64::INFINITY, f64::min);
    // The table has nine decimals.
    assert!((smallest - least).abs() < 1e-9, "{smallest} {least}");

    bench.ok("report made");
    assert!(bench.read("made/report.html").contains("Euler safety"));
    report(&bench).ok();
    assert!(bench.read("run/report.html").contains("not known"));
    let alone = bench.ok("report run run --all").out;
    assert!(!alone.contains("euler_safety"), "{alone}");
    let both = bench.ok("report run made --all").out;
    assert!(both.contains("euler_safety"), "{both}");
}

#[test]
fn a_comparison_has_a_row_for_every_run() {
    let bench = finished();
    let told = bench.cosmic("report run run --out compare.html").ok().out;
    let rows: Vec<&str> = told.lines().collect();
    assert!(rows.len() == 6 && rows[1] == rows[2] && rows[1].starts_with("run "));
    // Two or more spaces separate the columns.
    let columns = rows[0].split("  ").filter(|name| !name.is_empty());
    assert_eq!(columns.count(), 6, "{told}");
    assert!(rows[4] == rows[5] && rows[4].starts_with("run: "), "{told}");
    let summary = bench.json("run/summary.json");
    let median = format!(
        "{:.3}",
        summary["displacement_robust_p50"].as_f64().unwrap()
    );
    assert!(rows[1].replace('\u{2212}', "-").contains(&median));
    let html = bench.read("compare.html");
    // Two tables, of six and of all columns, have a head and two rows each.
    assert_eq!(html.matches("<tr>").count(), 6);
    assert_eq!(html.matches("<dt>run</dt>").count(), 2);
    fetches_nothing(&html);
    assert_eq!(html.matches("\"name\":\"run\"").count(), 2);
    // A run without its trajectory is only in the table.
    let trajectory = bench.read("run/trajectory.json");
    bench.remove("run/trajectory.json");
    bench.cosmic("report run run --out compare.html").ok();
    let html = bench.read("compare.html");
    assert!(html.matches("<tr>").count() == 6 && !html.contains("<script"));
    bench.write("run/trajectory.json", trajectory);

    let json = bench.cosmic("report run run --json").json();
    assert_eq!(json["runs"][1]["run"], "run");
    let items = json["runs"][0]["verdict"].as_array().unwrap();
    assert!(
        rows[4].contains(items[0]["text"].as_str().unwrap()),
        "{items:?}"
    );
    let compared = &json["runs"][0]["summary"];
    let quoted = "displacement_robust_p50";
    assert_eq!(compared[quoted], summary[quoted]);

    // The other run has the same folder name, but its task has a loss.
    assert!(!rows[0].contains("loss"));
    fs::create_dir_all(bench.path("other/run")).unwrap();
    let text = bench.read("run/summary.json");
    let with_loss = text.replacen("\"seed\":", "\"loss_p50\": -1.25,\n\"seed\":", 1);
    bench.write("other/run/summary.json", with_loss);
    let told = bench.cosmic("report run other/run --all").ok().out;
    assert!(
        told.ends_with("other/run: no verdict, because its folder has no scene\n"),
        "{told}"
    );
    // A run without a loss has a dash in its column.
    let cells = |row: &str| -> Vec<String> {
        let cells = row.split("  ").map(|cell| cell.trim().to_owned());
        cells.filter(|cell| !cell.is_empty()).collect()
    };
    let rows: Vec<Vec<String>> = told.lines().take(3).map(cells).collect();
    let loss = rows[0].iter().position(|name| name.starts_with("loss_p50"));
    let losses = [1, 2].map(|row| &rows[row][loss.unwrap()][..]);
    assert_eq!(losses, ["–", "\u{2212}1.2500"]);

    bench.cosmic("report run none").fails(4, &["none"]);
    bench.cosmic("report").fails(2, &[]);
    for option in ["--all", "--out page.html"] {
        let told = bench.cosmic(&format!("report run {option}"));
        told.fails(2, &["--out and --all are for several runs"]);
    }
}
