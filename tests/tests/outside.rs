//! A user's crate outside of the workspace, with a Cargo.toml of its own and a law of its own.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The output of a command that succeeds.
#[track_caller]
fn done(command: &mut Command) -> String {
    let Output {
        status,
        stdout,
        stderr,
    } = command.output().expect("the command is there");
    let errors = String::from_utf8_lossy(&stderr);
    assert!(status.success(), "{command:?}\n{errors}");
    String::from_utf8(stdout).expect("text")
}

#[test]
fn a_crate_outside_of_the_workspace_has_a_law_of_its_own() {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("..")
        .canonicalize()
        .unwrap();
    let outside = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("outside");
    fs::create_dir_all(outside.join("src")).unwrap();
    let example = repository.join("cosmic/program/examples/mud.rs");
    fs::copy(example, outside.join("src/main.rs")).unwrap();
    // Offline, the versions of the workspace are those there are.
    fs::copy(repository.join("Cargo.lock"), outside.join("Cargo.lock")).unwrap();
    let manifest = fs::read_to_string(repository.join("tests/outside.toml")).unwrap();
    let manifest = manifest.replace("COSMIC", &repository.display().to_string());
    fs::write(outside.join("Cargo.toml"), manifest).unwrap();

    let cargo = std::env::var_os("CARGO").unwrap_or("cargo".into());
    let mut build = Command::new(cargo);
    build.args(["build", "--offline", "--quiet", "--target-dir", "target"]);
    // It runs for 64 steps: compiling takes longer than that.
    build.env("CARGO_PROFILE_DEV_OPT_LEVEL", "0");
    done(build.current_dir(&outside));

    let mut mud = Command::new(outside.join("target/debug/mud"));
    let short = [
        "physics.steps=64",
        "schedule.horizon=[32,32]",
        "loss.window=16",
    ];
    let check = done(
        mud.arg("gradcheck")
            .args(short.iter().flat_map(|s| ["--set", s])),
    );
    assert!(check.contains("gradient of mud"), "{check}");
    assert!(check.contains("negative control"), "{check}");
}
