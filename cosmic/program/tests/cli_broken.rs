//! What a user may do wrong: each error names the file that the user knows, and the way out of it works.

use crate::common::Bench;
use crate::program::has;
use std::fs;

const SWEEP: &str = "seeds = 2\niterations = 2\n[[trials]]\nscene = 'tiny.toml'\n";

/// Replaces the first occurrence of `from` in a file.
fn replace(bench: &Bench, file: &str, from: &str, to: &str) {
    let text = bench.read(file);
    assert!(text.contains(from), "{text}");
    bench.write(file, text.replacen(from, to, 1));
}

#[test]
fn every_command_refuses_a_run_whose_scene_was_changed() {
    let bench = Bench::finished();
    bench.ok("sweep run tiny.toml --iterations 2 --out s --quiet");
    for run in ["a", "s/runs/tiny-0"] {
        replace(
            &bench,
            &format!("{run}/scene.toml"),
            "gravity = 4.8",
            "gravity = 3.0",
        );
    }
    let says = "scene.toml: this is not the scene with which the run began; remove the file";
    for command in [
        "resume a",
        "report a",
        "report a a",
        "evaluate a",
        "check a",
        "robustness a",
        "export a",
        "walk a",
        "optimize --from a --iterations 2",
        "sweep merge s",
        "sweep run tiny.toml --iterations 2 --out s",
    ] {
        bench.fails(command, 2, &[says]);
    }
    bench.remove("a/scene.toml");
    bench.ok("resume a");
}

/// The runs of a sweep are counted by their folders, so a copy of a run would count twice.
#[test]
fn a_copied_run_does_not_count_as_another() {
    let bench = Bench::default();
    bench.ok("sweep run tiny.toml --iterations 2 --seeds 2 --out s --quiet");
    fs::copy(
        bench.path("s/runs/tiny-0/summary.json"),
        bench.path("s/runs/tiny-1/summary.json"),
    )
    .unwrap();
    bench.fails(
        "sweep merge s",
        2,
        &["s/runs/tiny-1: this is the run of `tiny` with the seed 0"],
    );
}

#[test]
fn a_sweep_keeps_out_of_other_folders() {
    let bench = Bench::finished();
    let says = "the folder is not empty, but it does not contain a sweep";
    bench.fails("sweep run tiny.toml --out a", 2, &[says]);
    bench.fails("sweep run tiny.toml --out a --index 0", 2, &[says]);
    assert!(!bench.path("a/sweep.json").exists() && !bench.path("a/runs").exists());
    for (folder, says) in [
        (
            "a",
            "cannot read a: it is not the folder of a sweep, because it has no sweep.json",
        ),
        (
            "tiny.toml",
            "cannot read tiny.toml: it is not the folder of a sweep",
        ),
    ] {
        bench.fails(&format!("sweep merge {folder}"), 4, &[says]);
    }
}

#[test]
fn an_error_of_one_trial_names_the_trial() {
    let bench = Bench::default();
    let says = "error: trial tiny+dt=1: the time step of 1 s is unstable";
    bench.fails(
        "sweep run tiny.toml --set physics.dt=0.002,1 --out s",
        2,
        &[says],
    );
    assert!(!bench.path("s").exists());
}

#[test]
fn a_folder_is_not_a_scene() {
    let bench = Bench::finished();
    let says = "cannot read a: it is a folder; name a scene file, such as the scene.toml in the folder of a run";
    for command in ["optimize a", "scene check a", "sweep run a --out s"] {
        bench.fails(command, 4, &[says]);
    }
}

#[test]
fn a_sweep_is_not_a_scene() {
    let bench = Bench::default();
    bench.write("my sweep.toml", SWEEP);
    bench.write("outer.toml", "[[trials]]\nscene = 'my sweep.toml'\n");
    let says = [
        "this is the file of a sweep, not a scene",
        "my sweep.toml:3:3",
        "run it with: cosmic sweep run 'my sweep.toml' --out DIR",
    ];
    fs::copy(bench.path("my sweep.toml"), bench.path("sweep.toml")).unwrap();
    let says_short = [
        says[0],
        "sweep.toml:3:3",
        "cosmic sweep run sweep.toml --out DIR",
    ];
    for command in [
        "optimize sweep.toml",
        "scene check sweep.toml",
        "evaluate sweep.toml",
        "check sweep.toml",
        "sweep run sweep.toml tiny.toml --out s",
    ] {
        bench.fails(command, 2, &says_short);
    }
    bench.fails("sweep run outer.toml --out s", 2, &says);
    bench.ok("sweep run sweep.toml --out s --quiet");
}

/// Removing the two lines, as the error says, leaves a scene that works.
#[test]
fn the_advice_about_a_version_leads_to_a_scene() {
    let bench = Bench::default();
    let scene = bench.read("tiny.toml");
    let format = "format = \"cosmic-scene\"\n";
    for lines in [
        "version = 8\n",
        "version = 1\n",
        format,
        &format!("{format}version = 8\n"),
        &format!("{format}version = 1\n"),
    ] {
        bench.write("tiny.toml", format!("{lines}{scene}"));
        let advice = "remove `format` and `version` from a scene of your own";
        bench.fails("scene check tiny.toml", 2, &[advice]);
    }
    bench.write("tiny.toml", scene);
    bench.ok("scene check tiny.toml");
}

#[test]
fn errors_in_a_sweep_have_their_place() {
    let bench = Bench::default();
    for (from, to, says) in [
        (
            "seeds",
            "sseds",
            ["sweep.toml:1:1", "did you mean `seeds`?"],
        ),
        (
            "2",
            "[0, 1]",
            ["sweep.toml:1:9", "expected a whole number from 1 on"],
        ),
        (
            "tiny",
            "tinny",
            [
                "sweep.toml:4:9",
                "is neither a built-in scene nor a file beside this one",
            ],
        ),
        (
            "[[trials]]",
            "[[trial]]",
            ["sweep.toml:3:3", "did you mean `trials`?"],
        ),
        (
            "[[trials]]",
            "[grid]\nphysics.friction = [1, -2]\n[[trials]]",
            ["sweep.toml:4:24", "`physics.friction` is out of range: -2"],
        ),
        (
            "[[trials]]",
            "[[trials]]\nscene = 'tiny.toml'\n[[trials]]",
            [
                "sweep.toml: two trials have the name `tiny`",
                "rename one of them",
            ],
        ),
    ] {
        bench.write("sweep.toml", SWEEP.replacen(from, to, 1));
        bench.fails("sweep run sweep.toml --out s", 2, &says);
    }
    assert!(!bench.path("s").exists());
}

/// Editors of Windows write carriage returns and a byte order mark.
#[test]
fn files_of_windows_are_read() {
    let bench = Bench::default();
    let text = |text: String| format!("\u{feff}{}", text.replace('\n', "\r\n"));
    bench.write("tiny.toml", text(bench.read("tiny.toml")));
    bench.write("sweep.toml", text(SWEEP.to_owned()));
    bench.ok("sweep run sweep.toml --out s --quiet");
}

/// The cost is estimated for scenes whose rollouts cannot be shortened, too.
#[test]
fn one_long_step_has_a_cost() {
    let bench = Bench::default();
    for scene in [
        "earth",
        "errand",
        "coulomb --set physics.unstable_step=warn",
    ] {
        let line = format!("scene check {scene} --set physics.dt=1 --set physics.steps=1");
        has(
            &bench.ok(&line).out,
            &["\ncost: 1 step ", " a rollout, about "],
        );
    }
}

/// The user does not know the names of temporary files.
#[cfg(target_os = "linux")]
#[test]
fn an_error_of_writing_names_only_the_file_of_the_user() {
    let bench = Bench::default();
    for (line, says) in [
        (
            "evaluate tiny.toml --out /proc/self/e.json",
            "cannot write /proc/self/e.json: ",
        ),
        (
            "check tiny.toml --steps 4 --out /proc/self",
            "cannot write /proc/self: ",
        ),
    ] {
        let told = bench.cosmic(line);
        told.fails(4, &[says]);
        assert!(!told.error.contains(".cosmic-"), "{told:?}");
    }
}
