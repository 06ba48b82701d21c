//! `cosmic verify`.

use crate::common::Bench;
use crate::program::has;
use serde_json::Value;

const SMALL: &str = "base = \"stability\"\n[lattice]\ncolumns = 2\nrows = 2\n\
                     [physics]\nsteps = 64\nintegrator = \"leapfrog\"\nsubsteps = 2\n\
                     [schedule]\nhorizon = [32, 64]\n[loss]\nwindow = 16\nevery = 4\n\
                     [controller]\nhidden = 2\n";

/// The kinds of extreme robots, which are the groups in the part about stability.
const EXTREMES: [&str; 12] = [
    "scene",
    "stiffness",
    "mass",
    "ratio",
    "damping",
    "integrator",
    "time step",
    "friction",
    "layout",
    "controller",
    "coincidence",
    "lattice",
];

/// `verify` checks the output folder before anything else, because its measurements take minutes.
#[test]
fn an_impossible_folder_is_refused_before_any_work() {
    let told = Bench::with(SMALL).cosmic("verify tiny.toml --out tiny.toml");
    told.fails(4, &["cannot write tiny.toml"]);
    assert_eq!(told.out, "");
}

#[test]
fn a_scene_is_verified_into_a_folder() {
    let bench = Bench::with(SMALL);
    let told = bench.ok("verify tiny.toml --out new/sheet --json");
    let read = |name: &str| bench.read(&format!("new/sheet/{name}"));

    let json = bench.json("new/sheet/verify.json");
    assert_eq!(json["format"], "cosmic-verification");
    assert_eq!(json["version"], 1);
    let said: Value = serde_json::from_str(&told.out).unwrap();
    assert_eq!(said["sections"], json["sections"]);
    let sections = json["sections"].as_array().unwrap();
    let titles = [
        "Distance",
        "Accuracy of trajectories",
        "Gradients",
        "Stability",
    ];
    assert!(sections.iter().map(|s| &s["title"]).eq(&titles));

    // The table has a row for the scene's own integrator, which is marked as the default.
    let rows = sections[1]["tables"][0]["rows"].as_array().unwrap();
    let marked = rows.iter().filter(|row| row["standing"] == "default");
    let [marked] = marked.collect::<Vec<_>>()[..] else {
        panic!("{rows:?}");
    };
    assert_eq!(marked["method"], "leapfrog x2");
    assert_eq!(marked["dt_s"], 0.002);
    assert_eq!(marked["precision"], "f64");

    // The file of each table has a header and one line per row. Every figure is in a file and also on the page.
    for table in sections
        .iter()
        .flat_map(|s| s["tables"].as_array().unwrap())
    {
        let name = format!("{}.csv", table["name"].as_str().unwrap());
        let rows = table["rows"].as_array().unwrap().len();
        assert_eq!(read(&name).lines().count(), rows + 1, "{name}");
    }
    let page = read("verify.html");
    assert!(page.contains("<table"));
    for figure in ["work_precision.svg", "gradient_error.svg"] {
        assert!(page.contains(&read(figure)), "{figure}");
    }
    let names = page.matches("http://www.w3.org/2000/svg").count();
    assert_eq!(page.matches("http://").count(), names);
    let written: Vec<&str> = told.error.lines().collect();
    for (k, line) in written.iter().enumerate() {
        assert!(bench.path(line).is_file(), "{line}");
        assert!(!written[..k].contains(line), "{line} twice");
    }
    stability(&sections[3]);
    // The first part answers three questions.
    let answers = sections[0]["verdict"].as_array().unwrap();
    let says = ["moves by", "the time step", "integrator", "the precision"];
    assert_eq!(answers.len(), says.len(), "{answers:?}");
    for (answer, says) in answers.iter().zip(says) {
        assert!(answer["text"].as_str().unwrap().contains(says), "{answer}");
    }
    // Four time steps, other integrators, and single precision.
    let rows = sections[0]["tables"][0]["rows"].as_array().unwrap();
    let single = rows.iter().filter(|row| row["precision"] == "f32");
    assert!(rows.len() > 5 && single.count() == 1, "{rows:?}");
}

/// Asserts that robots of every kind were tried, and that the report calls the right robots unstable.
fn stability(section: &Value) {
    let tables = section["tables"].as_array().unwrap();
    let names = ["stable_steps", "extremes"];
    assert!(tables.iter().map(|table| &table["name"]).eq(&names));
    let rows = tables[1]["rows"].as_array().unwrap();
    for group in EXTREMES {
        assert!(rows.iter().any(|row| row["extreme"] == group), "no {group}");
    }
    for row in rows {
        let [expected, said] = ["expected", "said"].map(|key| row[key] == "unstable");
        assert_eq!(expected, said, "{row}");
        assert!(
            row["verdict"] == "ok" && row["standing"] != "failed",
            "{row}"
        );
    }
}

/// The comparison of stiff bars takes long, so it is done only if asked for.
#[test]
fn stiff_bars_are_compared_on_demand() {
    let bench = Bench::with(SMALL);
    let told = bench.ok("verify tiny.toml --stiff --rows --out sheet");
    has(
        &told.out,
        &[
            "STIFF BARS",
            "explicit and implicit steps",
            "checks, 0 failed",
        ],
    );
    for name in ["ACCURACY", "GRADIENTS", "STABILITY"] {
        assert!(!told.out.contains(name), "{name}");
    }
    let sections = bench.json("sheet/verify.json");
    let rows = &sections["sections"][0]["tables"][0]["rows"];
    let methods = rows.as_array().unwrap().iter().map(|row| &row["method"]);
    for method in ["symplectic euler", "leapfrog", "implicit"] {
        assert!(methods.clone().any(|name| name == method), "no {method}");
    }
    for world in ["air", "ground"] {
        assert!(
            bench
                .path(&format!("sheet/stiff_{world}_1e6.svg"))
                .is_file()
        );
    }
}

#[test]
fn one_part_can_be_verified_alone_and_a_failure_exits_with_1() {
    let stiff = format!("{SMALL}[materials]\nstiffness = [1e6, 1e6, 1e6]\n");
    let told = Bench::with(&stiff).cosmic("verify tiny.toml --stability --rows");
    told.fails(1, &["error: 1 of ", " checks failed: the scene's"]);
    has(&told.out, &["STABILITY", "Robots at the extremes"]);
    assert!(!told.out.contains("GRADIENTS"));
}
