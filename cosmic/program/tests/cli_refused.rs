//! `cosmic optimize`: refused arguments, unstable time steps and numbers that are not finite.

use crate::common::{Bench, scene};
use crate::program::{Told, has};
use cosmic::record::optimise;
use std::fs;

#[test]
fn unsuitable_output_folders_are_refused() {
    let bench = Bench::default();
    fs::create_dir(bench.path("empty")).unwrap();
    // A run that is killed during its first write leaves only a file of this name.
    bench.write("empty/.cosmic-half", "{");
    bench.run("empty", "");
    let before = bench.results("empty");
    assert!(!before.contains_key(".cosmic-half"));
    bench
        .optimize("empty", "")
        .fails(2, &["empty: the folder is not empty"]);
    assert_eq!(bench.results("empty"), before);
    // Root can write anywhere, but not even root can make a folder at or below the path of a file.
    for out in ["tiny.toml", "tiny.toml/run"] {
        bench
            .optimize(out, "")
            .fails(4, &[&format!("cannot write {out}: ")]);
    }
    bench.fails("optimize no_such_scene", 4, &[]);
    bench.write("bad.toml", "[physics]\ndt = \"fast\"\n");
    bench.fails("optimize bad.toml", 2, &["bad.toml:2:6"]);
    assert!(!bench.path("runs").exists());
}

#[test]
fn errors_about_numbers_out_of_range_say_what_is_allowed() {
    let bench = Bench::default();
    let seeds = "expected a whole number from 0 to 18446744073709551615";
    let threads = "expected a whole number from 1 to 1024";
    let counts = "expected a whole number, 1 or more";
    let samples = "expected a whole number from 1 to 65535";
    for (line, allowed) in [
        ("optimize tiny.toml --starts 0", counts),
        ("optimize tiny.toml --starts -3", counts),
        ("optimize tiny.toml --iterations 0", counts),
        ("optimize tiny.toml --iterations 1.5", counts),
        ("optimize tiny.toml --threads 0", threads),
        ("optimize tiny.toml --threads 1025", threads),
        ("optimize tiny.toml --seed -1", seeds),
        ("resume a --threads -1", threads),
        ("check --seed -1", seeds),
        ("robustness a --samples 0", samples),
        ("robustness a --seed -1", seeds),
        ("robustness a --start -1", "expected a number from 0 to 1"),
        ("sweep run --out s --first-seed -1", seeds),
        ("sweep run --out s --seeds 0", counts),
    ] {
        let mut words = line.rsplit(' ');
        let (value, option) = (words.next().unwrap(), words.next().unwrap());
        let place = format!("invalid value '{value}' for '{option} <");
        let said = bench.cosmic(line);
        said.fails(2, &[&place, allowed]);
        assert_eq!(said.out, "", "{line}");
    }
    assert!(!bench.path("runs").exists());
}

/// The controller of this robot reacts to the slightest velocity. Therefore derivatives overflow although states do
/// not.
#[test]
fn gradients_that_are_not_finite_are_counted_and_skipped() {
    let chaos = "[controller]\nvelocity_scale = 1000.0\noffset_scale = 100.0\n\
                 [gradient]\ncotangent_bound = \"off\"\n";
    let bench = Bench::with(&(scene(12, 8192, "damping = 1.0") + chaos));
    let said = bench.run("a", "");
    let summary = bench.json("a/summary.json");
    let skipped = summary["skipped_gradients"].as_u64().unwrap();
    let rows = bench.rows("a/history.jsonl");
    assert_eq!(rows.len(), 12);
    let of_rows = rows.iter().map(|row| row["skipped"].as_u64().unwrap());
    assert_eq!(skipped, of_rows.sum::<u64>());
    assert!(skipped > 0 && summary["displacement_p50"].is_number());
    let says = format!("{skipped} gradients skipped");
    has(&said.error, &[&says]);
}

#[test]
fn a_robot_that_flies_apart_gives_an_error_and_its_last_states() {
    // Time steps of 10 ms are unstable for such stiff springs.
    let text =
        scene(24, 256, "dt = 0.01\ndamping = 0.0") + "[materials]\nstiffness = [1e-7, 4e3, 30.0]\n";
    let bench = Bench::with(&text);
    let said = bench.optimize("a", "--allow-unstable");
    let words = [
        "diverged in step ",
        "node ",
        "velocity [",
        "a/diverged.json",
    ];
    said.fails(3, &words);
    // Every rollout overflows, so the design never changes. The run gives up after 10 of its 24 iterations.
    assert_eq!(bench.lines("a/history.jsonl"), 10);
    for says in [
        "warning: after iteration 1: the loss is NaN",
        "warning: these results are not finite: the loss; after iteration 10 the loss is NaN",
    ] {
        assert_eq!(said.error.matches(says).count(), 1, "{said:?}");
    }
    let again = bench.cosmic("evaluate a/diverged.json");
    let (_, step) = said.error.split_once("diverged in step ").unwrap();
    let (step, _) = step.split_once(':').unwrap();
    again.fails(3, &[&format!("diverged in step {step}:")]);
    assert!(!bench.path("a/summary.json").exists());
    bench.fails("resume a", 3, &[]);
    // A run with several such starts fails too.
    bench
        .optimize("b", "--starts 2 --allow-unstable")
        .fails(3, &["b/diverged.json"]);
}

/// Without stiffness, the payload cannot move along the ground, whatever the design and the controller. So all
/// gradients are zero.
#[test]
fn optimize_warns_if_all_gradients_are_zero() {
    let slack = scene(24, 64, "") + "[materials]\nstiffness = [0.0, 0.0, 0.0]\n";
    let said = Bench::with(&slack).optimize("a", "");
    let warning = "warning: after iteration 10: all gradients of the last 10 iterations were zero";
    assert_eq!(said.error.matches(warning).count(), 1, "{said:?}");
    let said = Bench::default().run("a", "");
    assert!(!said.error.contains("were zero"), "{said:?}");
}

/// A scene that a program builds is checked like a scene file. Otherwise its run could not be resumed.
#[test]
fn a_scene_that_could_not_be_read_again_is_refused() {
    let bench = Bench::default();
    let mut plan = bench.plan();
    plan.scene.schedule.horizon = [8, 8];
    let refused = optimise(&bench.path("run"), &plan, &mut ()).unwrap_err();
    assert_eq!(refused.exit_code(), 2);
    let says = "the shortest horizon has only 8";
    assert!(refused.to_string().contains(says), "{refused}");
    assert!(!bench.path("run").exists());
}

/// A scene in which one line sets a time step that is far too long.
fn unstable() -> String {
    scene(4, 32, "dt = 0.05")
}

#[test]
fn an_unstable_time_step_is_refused_where_the_scene_sets_it() {
    let bench = Bench::with(&unstable());
    let before = unstable()
        .lines()
        .take_while(|l| !l.starts_with("dt"))
        .count();
    let said = bench.optimize("a", "");
    let words = [
        &format!("tiny.toml:{}:", before + 1),
        "the time step of 0.05 s is unstable",
        "node ",
        "set physics.dt to ",
        "--allow-unstable",
        "^",
    ];
    said.fails(2, &words);
    assert!(said.out.is_empty() && !bench.path("a").exists());
    // If the scene does not set the time step, there is no line to show.
    let stiff = "base = \"stability\"\n[materials]\nstiffness = [1e-7, 4e6, 30.0]\n";
    let bench = Bench::with(stiff);
    let said = bench.optimize("a", "");
    assert!(said.code == 2 && said.error.starts_with("error: the time step of 0.002 s is"));
}

#[test]
fn an_unstable_time_step_can_be_allowed_and_gives_a_warning() {
    let warning = "warning: the time step of 0.05 s is unstable";
    let bench = Bench::with(&unstable());
    let said = bench.optimize("a", "--allow-unstable --iterations 2");
    assert_eq!(said.error.matches(warning).count(), 1, "{said:?}");
    // If there are several starts, each has its own warning.
    let said = bench.optimize("several", "--allow-unstable --iterations 2 --starts 2");
    for seed in 0..2 {
        let warning = warning.replace("warning: ", &format!("warning: seed {seed}: "));
        assert_eq!(said.error.matches(&warning).count(), 1, "{said:?}");
    }
    let text = bench.read("a/scene.toml");
    assert!(text.contains("unstable_step = \"warn\""));
    let check = &bench.rows("a/history.jsonl")[0]["time_step"];
    let limit = check["exact"]["dt"].as_f64().unwrap();
    assert!(check["dt"] == 0.05 && limit < 0.05 && check["exact"]["node"].is_u64());
    let quiet = bench.optimize("b", "--allow-unstable --quiet --iterations 2");
    assert!(!quiet.error.contains("warning"), "{quiet:?}");
    // A scene can also allow an unstable time step itself.
    let patient = scene(4, 32, "dt = 0.05\nunstable_step = \"warn\"");
    let bench = Bench::with(&patient);
    let said = bench.optimize("a", "--iterations 2");
    assert!(said.code != 2 && said.error.contains(warning), "{said:?}");
}

/// In this scene, every edge becomes skeleton at the snap. Such a robot is too stiff for the time step.
#[test]
fn a_design_that_becomes_unstable_stops_the_run_which_can_be_resumed() {
    let text = "base = \"stability\"\n[lattice]\ncolumns = 2\nrows = 2\n[physics]\nsteps = 32\ndt = 0.0045\n\
                [volume]\nsolid = [1.0, 1.0]\nactuator = [0.0, 0.0]\n\
                [schedule]\niterations = 6\nattraction_from = 4\nsnap_at = 4\n\
                horizon = [32, 32]\n[loss]\nwindow = 16\nevery = 4\n";
    let bench = Bench::with(text);
    let said = bench.optimize("a", "");
    let refused = |said: Told, run: &str| {
        let resume = format!("cosmic resume {run} --allow-unstable");
        let step = "after iteration 4: the time step";
        said.fails(2, &[step, "set physics.dt to ", &resume]);
    };
    has(&said.error, &["tiny.toml:7:"]);
    refused(said, "a");
    let done = bench.read("a/history.jsonl");
    assert!((1..6).contains(&done.lines().count()), "{done}");
    // `resume` refuses the run for the same reason.
    refused(bench.cosmic("resume a"), "a");
    // If there are several starts, the message names the folder of the search.
    refused(bench.optimize("several", "--starts 2"), "several");
    let said = bench.cosmic("resume a --allow-unstable");
    has(&said.error, &["warning: "]);
    let all = bench.read("a/history.jsonl");
    assert!(all.lines().count() == 6 && all.starts_with(&done));
    let scene = bench.read("a/scene.toml");
    assert!(scene.contains("unstable_step = \"warn\""));
    let same = bench.optimize("b", "--allow-unstable");
    assert_eq!(same.code, said.code);
    assert_eq!(bench.read("a/design.json"), bench.read("b/design.json"));
}
