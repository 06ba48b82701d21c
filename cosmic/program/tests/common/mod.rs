//! Test folders: temporary folders in which the program does small runs.

pub(crate) mod python;

use crate::program::{Told, cosmic_in};
use cosmic::Registry;
use cosmic::record::{RunPlan, optimise};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use tempfile::TempDir;

/// A temporary folder for a test. The file `tiny.toml` in it is a small scene.
pub(crate) struct Bench(TempDir);

/// Makes a test folder with the default scene. It has 24 iterations and rollouts of 64 steps. In iteration 19, the snap
/// gives every edge one material.
impl Default for Bench {
    fn default() -> Self {
        Self::new(24, 64)
    }
}

impl Bench {
    /// Makes a test folder. Its scene has 3x3 nodes, rollouts of `steps` steps, and `iterations` iterations that
    /// include all phases.
    pub(crate) fn new(iterations: usize, steps: usize) -> Self {
        Self::with(&scene(iterations, steps, ""))
    }

    /// Makes a test folder in which `tiny.toml` has this text.
    pub(crate) fn with(scene: &str) -> Self {
        let bench = Self(tempfile::tempdir().unwrap());
        bench.write("tiny.toml", scene);
        bench
    }

    /// Makes a test folder with the default scene and a finished run in the folder `a`. The run is computed once; every
    /// test gets a copy.
    pub(crate) fn finished() -> Self {
        static RUN: LazyLock<Bench> = LazyLock::new(|| {
            let bench = Bench::default();
            bench.run("a", "");
            bench
        });
        let bench = Self::default();
        fs::create_dir(bench.path("a")).unwrap();
        for file in fs::read_dir(RUN.path("a")).unwrap() {
            let file = file.unwrap();
            fs::copy(file.path(), bench.path("a").join(file.file_name())).unwrap();
        }
        bench
    }

    /// The path of a file or folder in the test folder.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file of the folder.
    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).unwrap();
    }

    /// Reads the text of a file of the folder.
    pub(crate) fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    /// Evaluates the final design of a run and returns the results. Asserts that the displacement is the same as in the
    /// summary.
    #[track_caller]
    pub(crate) fn evaluated(&self, run: &str) -> Value {
        let mut evaluated = self.cosmic(&format!("evaluate {run}/design.json")).json();
        let summary = self.json(&format!("{run}/summary.json"));
        let results = evaluated["results"].take();
        assert_eq!(results["displacement"], summary["displacement_along"]);
        results
    }

    /// The plan of the run that `cosmic optimize` makes from the scene.
    pub(crate) fn plan(&self) -> RunPlan {
        RunPlan::new(
            "tiny",
            Registry::default().read(&self.path("tiny.toml")).unwrap(),
            0,
        )
    }

    /// Delivers the robot of the scene after so many iterations into the folder `out`, as if the run were interrupted
    /// there. Before the snap, its edges are undecided.
    pub(crate) fn unfinished(&self, out: &str, iterations: usize) {
        let iterations = NonZeroUsize::new(iterations);
        let plan = RunPlan {
            iterations,
            ..self.plan()
        };
        optimise(&self.path(out), &plan, &mut ()).unwrap();
    }

    /// Runs the program in the folder with the arguments in `line`.
    pub(crate) fn cosmic(&self, line: &str) -> Told {
        cosmic_in(&self.path(""), line)
    }

    /// Runs the program in the folder and asserts that it succeeds.
    #[track_caller]
    pub(crate) fn ok(&self, line: &str) -> Told {
        self.cosmic(line).ok()
    }

    /// Runs the program in the folder. Asserts that it fails with exit code `code`, and that the error contains all of
    /// `words`.
    #[track_caller]
    pub(crate) fn fails(&self, line: &str, code: i32, words: &[&str]) {
        self.cosmic(line).fails(code, words);
    }

    /// Runs `cosmic optimize` on the scene, with the folder `out` and the options `more`.
    pub(crate) fn optimize(&self, out: &str, more: &str) -> Told {
        self.cosmic(&format!("optimize tiny.toml --out {out} {more}"))
    }

    /// Calls [`Bench::optimize`] and asserts that it succeeds.
    #[track_caller]
    pub(crate) fn run(&self, out: &str, more: &str) -> Told {
        self.optimize(out, more).ok()
    }

    /// Counts the complete lines of a file, which may still be growing.
    pub(crate) fn lines(&self, name: &str) -> usize {
        let bytes = fs::read(self.path(name)).unwrap_or_default();
        bytes.iter().filter(|&&byte| byte == b'\n').count()
    }

    /// Reads a JSON file of the folder.
    pub(crate) fn json(&self, name: &str) -> Value {
        serde_json::from_str(&self.read(name)).unwrap()
    }

    /// Reads the rows of a JSON Lines file.
    pub(crate) fn rows(&self, name: &str) -> Vec<Value> {
        let row = |line| serde_json::from_str(line).unwrap();
        self.read(name).lines().map(row).collect()
    }

    /// Returns the files of a run as text, by name, without snapshots and without wall times. Two equal runs have equal
    /// results.
    pub(crate) fn results(&self, run: &str) -> BTreeMap<String, String> {
        let mut results = BTreeMap::new();
        collect(&self.path(run), "", &mut results);
        results
    }
}

/// The text of the scene that [`Bench::new`] writes. `physics` is added to its section `[physics]`.
pub(crate) fn scene(iterations: usize, steps: usize, physics: &str) -> String {
    let at = |share: f64| (share * iterations as f64) as usize;
    format!(
        "base = \"stability\"\n[lattice]\ncolumns = 3\nrows = 3\n\
         [physics]\nsteps = {steps}\n{physics}\n\
         [schedule]\niterations = {iterations}\nattraction_from = {}\nsnap_at = {}\n\
         horizon = [{}, {steps}]\nhorizon_over = [{}, {}]\n\
         [binarisation]\nthreshold_over = [{}, {}]\n\
         [loss]\nwindow = 16\nevery = 4\n",
        at(0.57),
        at(0.8),
        steps / 2,
        at(0.27),
        at(0.5),
        at(0.07),
        at(0.6),
    )
}

fn collect(folder: &Path, prefix: &str, results: &mut BTreeMap<String, String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = format!("{prefix}{}", path.file_name().unwrap().to_str().unwrap());
        if path.is_dir() {
            collect(&path, &format!("{name}/"), results);
        } else if !name.ends_with("snapshot.json") {
            let text = fs::read_to_string(&path).unwrap();
            results.insert(name, timeless(&text));
        }
    }
}

/// Removes wall times from the text of a file.
fn timeless(text: &str) -> String {
    let mut parts = text.split("\"seconds\":");
    let first = parts.next().unwrap().to_owned();
    let number = |c: char| c.is_ascii_digit() || ".e-+".contains(c);
    parts.fold(first, |text, part| text + part.trim_start_matches(number))
}
