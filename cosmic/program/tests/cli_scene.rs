//! `cosmic scene` and `cosmic completions` as a user meets them: output, messages, exit codes.

use crate::program::{command, cosmic};
use cosmic::scene::{BUILTIN, Scene};
use std::fs;
use std::process::Command;

/// As [`cosmic`], for `scene check` of a file with that text.
fn check(text: impl AsRef<[u8]>) -> (String, String, i32) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("my.toml");
    fs::write(&file, text).unwrap();
    cosmic(&["scene", "check", file.to_str().unwrap()])
}

#[test]
fn list_has_a_scene_a_line_with_its_name_first() {
    let (out, _, code) = cosmic(&["scene", "list"]);
    let names: Vec<_> = out
        .lines()
        .map(|line| line.split_whitespace().next().unwrap())
        .collect();
    assert_eq!(code, 0);
    assert_eq!(names, BUILTIN.map(|scene| scene.name));
    let (out, _, _) = cosmic(&["scene", "list", "--json"]);
    let list: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(list.as_array().unwrap().len(), BUILTIN.len());
    assert_eq!(list[0]["name"], BUILTIN[0].name);
}

#[test]
fn default_and_show_print_whole_scenes_that_read_back() {
    let (out, _, code) = cosmic(&["scene", "default"]);
    assert_eq!(code, 0);
    assert_eq!(Scene::parse("default", &out).unwrap(), Scene::default());
    for scene in BUILTIN {
        let (out, _, code) = cosmic(&["scene", "show", scene.name]);
        assert_eq!(code, 0);
        assert_eq!(
            Scene::parse(scene.name, &out).unwrap(),
            Scene::load(scene.name).unwrap()
        );
        assert_eq!(check(out).2, 0);
    }
    let (out, _, _) = cosmic(&["scene", "show", "coulomb", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(json["physics"]["friction"], 2.5);
}

#[test]
fn check_says_ok_or_where_it_is_wrong() {
    let (out, _, code) = check("[physics]\ndt = 0.001\n");
    assert!(out.ends_with("my.toml: ok\n") && code == 0, "{out}");
    assert_eq!(check("").2, 0);

    let (out, error, code) = check("[physics]\ndt = 5.0\n");
    assert_eq!((out.as_str(), code), ("", 2));
    let lines: Vec<_> = error.lines().collect();
    assert_eq!(lines[0], "error: `physics.dt` is out of range: 5.0");
    assert!(
        lines[1].starts_with(" --> ") && lines[1].ends_with("my.toml:2:6"),
        "{error}"
    );
    assert_eq!(lines[3], "2 | dt = 5.0");
    assert_eq!(lines[4], "  |      ^^^ allowed: a number from 1e-9 to 1");

    let (_, error, code) = check(b"[physics]\ndt = \xff\n");
    assert!(code == 2 && error.contains("0xff is not UTF-8") && error.contains("my.toml:2:6"));
    assert!(
        error.ends_with("\n  = allowed: a scene is UTF-8 text\n"),
        "{error}"
    );
}

#[test]
fn check_refuses_what_optimize_refuses() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("my.toml");
    fs::write(&file, "[physics]\ndt = 0.05\n").unwrap();
    let file = file.to_str().unwrap();
    let (out, error, code) = cosmic(&["scene", "check", file]);
    assert_eq!((&*out, code), ("", 2), "{error}");
    let run = folder.path().join("run");
    let (_, refused, code) = cosmic(&["optimize", file, "--out", run.to_str().unwrap()]);
    assert_eq!(code, 2, "{refused}");
    assert_eq!(refused.replace(" or say --allow-unstable", ""), error);
    assert!(error.contains("my.toml:2:6"), "{error}");
    let (out, _, code) = cosmic(&["scene", "check", file, "--json"]);
    let json: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!((&json["ok"], code), (&false.into(), 2));
    assert_eq!(json["refusals"][0]["settings"][0]["key"], "physics.dt");
    assert_eq!(json["refusals"][0]["settings"][0]["value"], "0.05");
    // Where no key of it is in the file, the settings are named.
    let (_, error, code) = check("[materials]\nstiffness = [1e-7, 1e6, 30]\n");
    let settings = "(physics.dt = 0.002, physics.substeps = 1); set physics.dt to";
    assert!(code == 2 && error.contains(settings), "{error}");
}

#[test]
fn check_warns_of_nonsense_that_runs() {
    let nonsense = "[materials]\nstiffness = [1000, 400, 30]\n[physics]\ngravity = -4.8\n";
    let (out, error, code) = check(nonsense);
    assert!(out.ends_with("my.toml: ok\n") && code == 0, "{out}{error}");
    let expected = [
        "warning: void is at least as stiff as skeleton (materials.stiffness = [1000.0, 400.0, 30.0])",
        "warning: gravity points up (physics.gravity = -4.8)",
    ];
    for warning in expected {
        assert!(error.lines().any(|line| line == warning), "{error}");
    }
    assert_eq!(check("").1, "");
}

#[test]
fn missing_scenes_exit_with_4_and_a_hint() {
    let (_, error, code) = cosmic(&["scene", "show", "stabilty"]);
    assert!(
        code == 4 && error.contains("did you mean `stability`?"),
        "{error}"
    );
    let (_, error, code) = cosmic(&["scene", "check", "no/such/file.toml"]);
    assert!(
        code == 4 && error.contains("cannot read no/such/file.toml"),
        "{error}"
    );
    assert_eq!(cosmic(&["scene", "check", "."]).2, 4);
}

#[test]
fn bad_usage_exits_with_2_and_help_with_0() {
    for arguments in [
        &["frobnicate"][..],
        &["scene", "show"],
        &["scene", "list", "--frob"],
        &[],
    ] {
        let (out, error, code) = cosmic(arguments);
        assert_eq!((out.as_str(), code), ("", 2), "{arguments:?}");
        assert!(error.contains("Usage: cosmic"), "{error}");
    }
    assert_eq!(cosmic(&["--help"]).2, 0);
    assert_eq!(cosmic(&["--version"]).2, 0);
    // Into a disk that is full.
    #[cfg(target_os = "linux")]
    {
        let full = fs::File::create("/dev/full").unwrap();
        let told = command(&["--version"]).stdout(full).output().unwrap();
        let error = String::from_utf8(told.stderr).unwrap();
        assert_eq!(told.status.code(), Some(4), "{error}");
        assert!(error.starts_with("error: cannot write standard output"));
    }
}

#[test]
fn completions_are_written_for_every_shell() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let (out, _, code) = cosmic(&["completions", shell]);
        assert!(code == 0 && out.contains("cosmic"), "{shell}");
    }
    assert_eq!(cosmic(&["completions", "abacus"]).2, 2);
}

#[cfg(unix)]
#[test]
fn a_reader_that_stops_early_is_no_error() {
    let pipe = "\"$0\" scene default | head -n 1 >/dev/null; echo ${PIPESTATUS[0]}";
    let mut command = Command::new("bash");
    let output = command
        .args(["-c", pipe, env!("CARGO_BIN_EXE_cosmic")])
        .output()
        .unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stdout).trim(), "0");
    assert!(output.stderr.is_empty());
}
