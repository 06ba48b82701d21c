//! Files, folders and numbers that a command cannot use. Each error says what is wrong and what to do.

use crate::common::{Bench, scene};
use crate::program::has;
use cosmic::case::Case;
use std::fs;

/// Makes a test folder in which `run` is a finished run of a few iterations.
fn finished() -> Bench {
    let bench = Bench::with(&scene(24, 64, ""));
    bench.run("run", "--iterations 3 --quiet");
    bench
}

#[test]
fn a_decimal_comma_has_its_own_error() {
    let bench = Bench::default();
    let says = ["`9,81` is not a number", "use a decimal point: 9.81"];
    bench.fails("scene show stability --set physics.gravity=9,81", 2, &says);
    bench.write(
        "comma.toml",
        "[physics]\nsteps = 64\ngravity = 9,81 # 1,5\n",
    );
    let place = ["comma.toml:3:11"];
    bench.fails("scene check comma.toml", 2, &[&says[..], &place].concat());
    bench.write("text.toml", "[physics]\ngravity = \"9,81\"\n");
    let says = ["is a string: \"9,81\"", "use a decimal point: 9.81"];
    bench.fails("scene check text.toml", 2, &says);
    bench.write("list.toml", "[volume]\nsolid = [0,5, 0,6]\n");
    let told = bench.cosmic("scene check list.toml");
    assert!(
        told.code == 2 && !told.error.contains("decimal point"),
        "{told:?}"
    );
    bench.fails(
        "robustness run --friction 0,2",
        2,
        &["use a decimal point: 0.2"],
    );
}

#[test]
fn a_file_without_a_robot_is_named_by_its_kind() {
    let bench = finished();
    for (file, kind) in [
        ("summary.json", "the summary of a run"),
        ("snapshot.json", "the saved state of a run"),
        ("history.jsonl", "the history of a run"),
        ("designs.jsonl", "the history of a run's designs"),
        ("trajectory.json", "the motion of a robot"),
    ] {
        let says = format!(
            "run/{file} is {kind} and contains no robot; the robot of this run is in run\n"
        );
        for command in ["evaluate", "check"] {
            bench.fails(&format!("{command} run/{file}"), 2, &[&says]);
        }
    }
    fs::rename(bench.path("run/summary.json"), bench.path("summary.json")).unwrap();
    let says = "name the folder of a run, a design.json, a reference case or a scene";
    bench.fails("evaluate summary.json", 2, &[says]);
}

#[test]
fn a_folder_that_is_not_a_run_is_refused() {
    let bench = finished();
    fs::create_dir(bench.path("empty")).unwrap();
    let lacks = |folder: &str, file: &str| {
        format!("cannot read {folder}: it is not the folder of a run, because it has no {file}; ")
    };
    for (command, file) in [
        ("report", "summary.json"),
        ("export --csv", "summary.json"),
        ("report run", "summary.json"),
        ("robustness", "design.json"),
        ("evaluate", "design.json"),
        ("resume", "snapshot.json"),
    ] {
        let says = lacks("empty", file) + "name the folder that `cosmic optimize` wrote";
        bench.fails(&format!("{command} empty"), 4, &[&says]);
        let says = lacks(".", file) + "a run is in ./run";
        bench.fails(&format!("{command} ."), 4, &[&says]);
        if command != "evaluate" {
            let told = bench.cosmic(&format!("{command} nowhere"));
            told.fails(4, &["cannot read nowhere: No such file"]);
        }
    }
    let says = "tiny.toml: this is neither the folder of a run nor a design.json";
    bench.fails("report tiny.toml", 2, &[says]);
    let says = "cannot read tiny.toml: it is a file; name the folder of a run";
    bench.fails("resume tiny.toml", 4, &[says]);
}

/// Tests truncated designs and truncated cases.
#[test]
fn a_truncated_file_is_refused_with_its_place() {
    let bench = finished();
    let case = Case::of_scene(&bench.plan().scene, 0).unwrap();
    bench.write("case.json", case.to_json());
    for file in ["run/design.json", "case.json"] {
        let text = bench.read(file);
        let half = text.len() / 2;
        bench.write(file, &text[..half]);
        let place = format!("{file}:1:{half}");
        let command = format!("evaluate {file}");
        bench.fails(&command, 2, &[&place, "truncated or damaged"]);
    }
}

#[test]
fn a_truncated_snapshot_is_refused_with_a_remedy() {
    let bench = finished();
    bench.remove("run/summary.json");
    let text = bench.read("run/snapshot.json");
    let begin_again =
        "restore the file from a copy, or begin again with: cosmic optimize run/scene.toml";
    for (kept, says) in [
        (text.len() / 2, "the file is truncated or damaged"),
        (0, "the file is empty"),
    ] {
        bench.write("run/snapshot.json", &text[..kept]);
        let place = format!("run/snapshot.json:1:{}", kept.max(1));
        let told = bench.cosmic("resume run");
        told.fails(2, &[says, &place, begin_again]);
    }
    bench.write("run/snapshot.json", &text);
    bench.ok("resume run --quiet");
}

/// Python's `json` may write NaN. The error names it in every file of a run that a command reads.
#[test]
fn a_number_that_is_not_finite_is_named_in_every_file() {
    let bench = finished();
    for (file, key, command) in [
        ("design.json", "\"b1\":[", "evaluate run"),
        ("summary.json", "\"V\":", "report run"),
        ("trajectory.json", "\"dt\":", "report run"),
        ("history.jsonl", "\"V\":", "report run"),
        ("snapshot.json", "\"seconds\":", "resume run"),
    ] {
        let path = format!("run/{file}");
        let text = bench.read(&path);
        assert!(text.contains(key), "{file}: {text}");
        bench.write(&path, text.replacen(key, &format!("{key}NaN, \"x\": "), 1));
        if command == "resume run" {
            bench.remove("run/summary.json");
        }
        let column = text.find(key).unwrap() + key.len() + 1;
        let place = format!("{path}:1:{column}");
        let says = "NaN is not a JSON number; write null for a number that is not finite";
        bench.fails(command, 2, &[says, &place]);
        bench.write(&path, text);
    }
    let truss =
        r#"{"format": "cosmic-truss", "version": 1, "nodes": [[0, -Infinity]], "edges": []}"#;
    bench.write("truss.json", truss);
    let told = bench.cosmic("scene check tiny.toml --set lattice.file=truss.json");
    told.fails(2, &["-Infinity is not a JSON number", "truss.json:1:56"]);
}

/// Paths of runs may contain equals signs: the names of a sweep's folders contain settings.
#[test]
fn a_path_with_an_equals_sign_is_a_path_on_the_command_line() {
    let bench = Bench::default();
    fs::create_dir(bench.path("tiny+friction=0.6-0")).unwrap();
    let truss = r#"{"format": "cosmic-truss", "version": 1,
        "nodes": [[0, 0], [0.1, 0], [0.05, 0.1]], "edges": [[0, 1], [1, 2], [0, 2]]}"#;
    bench.write("tiny+friction=0.6-0/truss.json", truss);
    for begin in ["", "./"] {
        let file = format!("lattice.file={begin}tiny+friction=0.6-0/truss.json");
        let shown = bench.cosmic(&format!("check tiny.toml --steps 16 --set {file}"));
        has(&shown.out, &["truss.json, 3 nodes"]);
    }
}

/// Writing to `/dev/full` fails as on a full disk.
#[cfg(target_os = "linux")]
#[test]
fn a_run_continues_after_a_full_disk() {
    use std::os::unix::fs::symlink;
    let bench = finished();
    let remedy = "free some space there, then resume the run or repeat the command";
    bench.fails(
        "evaluate run --out /dev/full",
        4,
        &["cannot write /dev/full: No space left on device", remedy],
    );
    let before = bench.results("run");
    for name in ["summary.json", "trajectory.json"] {
        bench.remove(&format!("run/{name}"));
    }
    symlink("/dev/full", bench.path("run/trajectory.json")).unwrap();
    let told = bench.cosmic("resume run --quiet");
    let go_on = "the run is saved; free some space, then continue with: cosmic resume run\n";
    told.fails(
        4,
        &[
            "run/trajectory.json: No space left on device",
            remedy,
            go_on,
        ],
    );
    bench.remove("run/trajectory.json");
    bench.ok("resume run --quiet");
    assert_eq!(bench.results("run"), before);
}

/// In files and pipes, the progress consists of whole lines; only terminals get progress bars.
#[test]
fn progress_in_a_pipe_has_no_carriage_returns() {
    let bench = Bench::default();
    for (line, lines) in [
        ("optimize tiny.toml --out a", 3),
        ("optimize tiny.toml --starts 2 --out b", 6),
        ("sweep run tiny.toml --seeds 2 --iterations 3 --out s", 2),
        ("report a", 0),
    ] {
        let told = bench.ok(line);
        assert!(!told.error.contains(['\r', '\u{1b}']), "{told:?}");
        assert!(told.error.lines().count() >= lines, "{told:?}");
    }
}
