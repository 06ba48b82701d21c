//! Crates of users can be built outside the workspace. They have their own `Cargo.toml` and their own laws.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Runs a command, asserts that it succeeds, and returns its output.
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

/// Creates a crate in a new folder. It consists of its own manifest and of files from the repository. Each entry of
/// `files` has a source and a destination.
fn outside(name: &str, manifest: &str, files: &[(&str, &str)]) -> PathBuf {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("..")
        .canonicalize()
        .unwrap();
    let outside = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    for (from, to) in files {
        let folder = outside.join(to).parent().map(Path::to_owned);
        fs::create_dir_all(folder.expect("a folder")).unwrap();
        fs::copy(repository.join(from), outside.join(to)).unwrap();
    }
    // Without a network, cargo can use only the versions that the workspace uses.
    fs::copy(repository.join("Cargo.lock"), outside.join("Cargo.lock")).unwrap();
    let manifest = fs::read_to_string(repository.join(manifest)).unwrap();
    let manifest = manifest.replace("COSMIC", &repository.display().to_string());
    fs::write(outside.join("Cargo.toml"), manifest).unwrap();
    outside
}

/// Builds the crate in a folder. Returns the folder of its binaries.
fn build(folder: &Path) -> PathBuf {
    // The folder of the repository's own builds, so that other packages are not compiled again.
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    let cargo = std::env::var_os("CARGO").unwrap_or("cargo".into());
    let mut build = Command::new(cargo);
    build.args(["build", "--offline", "--quiet", "--target-dir"]);
    // With this variable, which check.sh sets, some packages are compiled differently.
    build.arg(target).env_remove("RUSTC_BOOTSTRAP");
    done(build.current_dir(folder));
    target.join("debug")
}

#[test]
fn a_build_script_emits_an_adjoint() {
    let files = ["build.rs", "src/drag.rs", "src/main.rs"];
    let files = files.map(|file| (format!("tests/build_script/{file}"), file));
    let files: Vec<(&str, &str)> = files
        .iter()
        .map(|(from, to)| (from.as_str(), *to))
        .collect();
    let drag = outside("build_script", "tests/build_script/manifest.toml", &files);
    let output = done(&mut Command::new(build(&drag).join("drag")));
    assert!(output.contains("is that of dual numbers"), "{output}");
}

#[test]
fn a_crate_outside_of_the_workspace_has_a_law_of_its_own() {
    // One of the settings of the second law is an enum, although the crate does not depend on serde.
    let examples = [
        ("cosmic/program/examples/mud.rs", "src/main.rs"),
        ("cosmic/program/examples/tendon.rs", "src/bin/tendon.rs"),
    ];
    let outside = outside("outside", "tests/outside.toml", &examples);
    let binaries = build(&outside);

    let short = [
        "lattice.columns=3",
        "lattice.rows=2",
        "controller.hidden=4",
        "physics.steps=64",
        "schedule.horizon=[32,32]",
        "loss.window=16",
    ];
    for name in ["mud", "tendon"] {
        let mut law = Command::new(binaries.join(name));
        law.arg("check");
        let check = done(law.args(short.iter().flat_map(|s| ["--set", s])));
        assert!(check.starts_with(&format!("{name}: ")), "{check}");
        assert!(check.contains("negative control"), "{check}");
    }
}

/// The dependencies of the pages work as they are pasted: the packages are at their paths, and the features exist. The
/// settings for building them are those of the workspace.
#[test]
fn the_dependencies_of_the_pages_resolve() {
    let repository = cosmic_tests::workspace().canonicalize().unwrap();
    for page in [
        "autodiff/README.md",
        "autodiff/programs/README.md",
        "docs/extending.md",
    ] {
        let text = fs::read_to_string(repository.join(page)).unwrap();
        let block = text.split("```toml\n").nth(1).expect("a block of TOML");
        let block = block.split("```").next().expect("its end");
        if let Some((_, profile)) = block.split_once("[profile.release]") {
            let of_workspace = fs::read_to_string(repository.join("Cargo.toml")).unwrap();
            for line in profile.lines() {
                assert!(of_workspace.contains(line), "{page}: {line}");
            }
        }
        // The reader's clone is beside the reader's crate.
        let block = block.replace("../cosmic/", &format!("{}/", repository.display()));
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(page.replace('/', "_"));
        fs::create_dir_all(folder.join("src")).unwrap();
        fs::write(folder.join("src/lib.rs"), "").unwrap();
        let mut package = "[package]\nname = \"pasted\"\nedition = \"2024\"\n".to_owned();
        // The manifest of a new crate ends with this line.
        if !block.starts_with("[dependencies]") {
            package += "[dependencies]\n";
        }
        let mut features =
            "[features]\nall = [\"autodiff/derive\", \"autodiff/nalgebra\", \"autodiff/rayon\""
                .to_owned();
        if block.contains("autodiff_programs") {
            features += ", \"autodiff_programs/derive\"";
        }
        features += "]\n";
        // Until a release is published, its versions are those of the workspace.
        let member =
            |name, path| format!("cosmic-{name}.path = \"{}/{path}\"\n", repository.display());
        let patch = member("autodiff", "autodiff")
            + &member("autodiff-programs", "autodiff/programs")
            + &member("codesign", "cosmic")
            + &member("program", "cosmic/program");
        let manifest = format!("{package}{block}{features}[workspace]\n[patch.crates-io]\n{patch}");
        fs::write(folder.join("Cargo.toml"), manifest).unwrap();
        fs::copy(repository.join("Cargo.lock"), folder.join("Cargo.lock")).unwrap();
        let cargo = std::env::var_os("CARGO").unwrap_or("cargo".into());
        let mut resolved = Command::new(cargo);
        // In contrast to `metadata`, this needs no packages for other systems.
        resolved.args(["tree", "--offline", "--all-features"]);
        let tree = done(resolved.current_dir(&folder));
        assert!(tree.contains("cosmic-autodiff"), "{page}");
    }
}
