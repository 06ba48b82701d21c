//! The program `cosmic` with GPU support.

mod device;

use std::path::Path;
use std::process::Command;

/// A robot of nine nodes, designed in a few iterations.
const SCENE: &str = "
base = 'stability'
lattice = { columns = 3, rows = 3 }
[physics]
steps = 64
[schedule]
iterations = 8
attraction_from = 4
snap_at = 6
horizon = [32, 64]
horizon_over = [2, 5]
[loss]
window = 16
[gradient]
precision = 'f32'
";

/// Runs the program in a folder. Returns its exit code, standard output and standard error.
fn cosmic(folder: &Path, line: &str) -> (i32, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cosmic-gpu"));
    let done = command.args(line.split_whitespace()).current_dir(folder);
    let done = done.output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (
        done.status.code().unwrap(),
        text(done.stdout),
        text(done.stderr),
    )
}

#[track_caller]
fn ok(folder: &Path, line: &str) -> String {
    let (code, out, error) = cosmic(folder, line);
    assert_eq!(code, 0, "{line}: {out}{error}");
    out
}

/// Without an adapter, `--device gpu` says what was looked for.
#[test]
fn an_unknown_adapter_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("tiny.toml"), SCENE).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_cosmic-gpu"));
    let line = "optimize tiny.toml --starts 2 --device gpu --out run";
    command
        .args(line.split_whitespace())
        .current_dir(folder.path());
    let done = command
        .env("COSMIC_GPU", "no such adapter")
        .output()
        .unwrap();
    assert_eq!(done.status.code(), Some(2));
    let error = String::from_utf8(done.stderr).unwrap();
    assert!(error.contains("there is no GPU to run on"), "{error}");
    assert!(!folder.path().join("run").exists());
}

#[test]
fn commands_use_a_device() {
    if device::gpu().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("tiny.toml"), SCENE).unwrap();
    println!("{}", ok(folder, "devices"));
    ok(
        folder,
        "optimize tiny.toml --starts 3 --device gpu --out run",
    );
    let robust = ok(folder, "robustness run --samples 4 --device gpu --json");
    assert!(robust.contains("\"p50\""), "{robust}");
    ok(folder, "sweep plan tiny.toml --seeds 2 --out sweep");
    ok(folder, "sweep run sweep --device gpu");
    assert!(ok(folder, "sweep status sweep").contains("2"));
    let (code, _, error) = cosmic(
        folder,
        "optimize tiny.toml --set gradient.precision=f64 --device gpu --out other",
    );
    assert_eq!(code, 2);
    assert!(error.contains("double precision"), "{error}");
}
