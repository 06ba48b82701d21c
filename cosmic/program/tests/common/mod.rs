//! Small runs of the program, for the tests of `optimize` and `resume`.

use crate::program::{Told, cosmic_in};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A folder for a test, with a scene in it.
pub(crate) struct Bench {
    folder: TempDir,
    /// The scene's file.
    pub(crate) scene: String,
}

/// 24 iterations, of which the 19th is the snap, on rollouts of 64 steps.
impl Default for Bench {
    fn default() -> Self {
        Self::new(24, 64)
    }
}

impl Bench {
    /// A robot of 3x3 nodes and an optimisation of so many iterations with every phase, on
    /// rollouts of so many steps.
    pub(crate) fn new(iterations: usize, steps: usize) -> Self {
        Self::with(&scene(iterations, steps, ""))
    }

    /// Another scene.
    pub(crate) fn with(scene: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("tiny.toml");
        fs::write(&file, scene).unwrap();
        Self {
            scene: file.to_str().unwrap().to_string(),
            folder,
        }
    }

    /// A place in the folder.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The program in the folder.
    pub(crate) fn cosmic(&self, arguments: &[&str]) -> Told {
        self.cosmic_in("", arguments)
    }

    /// The program in a folder below.
    pub(crate) fn cosmic_in(&self, below: &str, arguments: &[&str]) -> Told {
        cosmic_in(&self.path(below), arguments)
    }

    /// `cosmic optimize` of the scene into a folder of the bench.
    pub(crate) fn optimize(&self, out: &str, more: &[&str]) -> Told {
        let mut arguments = vec!["optimize", &self.scene, "--out", out];
        arguments.extend(more);
        self.cosmic(&arguments)
    }

    /// A run that must go well.
    pub(crate) fn run(&self, out: &str, more: &[&str]) -> Told {
        let said = self.optimize(out, more);
        assert_eq!(said.code, 0, "{said:?}");
        said
    }

    /// A JSON file in the folder.
    pub(crate) fn json(&self, name: &str) -> serde_json::Value {
        let text = fs::read_to_string(self.path(name)).unwrap();
        serde_json::from_str(&text).unwrap()
    }

    /// What two runs must have in common: all files but the snapshot, wall times taken out.
    pub(crate) fn results(&self, run: &str) -> BTreeMap<String, Vec<u8>> {
        let mut results = BTreeMap::new();
        collect(&self.path(run), "", &mut results);
        results
    }
}

/// The scene of [`Bench::new`], with more keys for its `[physics]`.
pub(crate) fn scene(iterations: usize, steps: usize, physics: &str) -> String {
    let at = |share: f64| (share * iterations as f64) as usize;
    format!(
        "[lattice]\ncolumns = 3\nrows = 3\n\
         [physics]\nsteps = {steps}\n{physics}\n\
         [volume]\nwidening_over = [{}, {}]\n\
         [schedule]\niterations = {iterations}\nattraction_from = {}\nsnap_at = {}\n\
         horizon = [{}, {steps}]\nhorizon_over = [{}, {}]\n\
         [binarisation]\nthreshold_over = [{}, {}]\n\
         [loss]\nwindow = 16\nevery = 4\n",
        at(0.37),
        at(0.5),
        at(0.57),
        at(0.8),
        steps / 2,
        at(0.27),
        at(0.5),
        at(0.07),
        at(0.6),
    )
}

fn collect(folder: &Path, prefix: &str, results: &mut BTreeMap<String, Vec<u8>>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = format!("{prefix}{}", path.file_name().unwrap().to_str().unwrap());
        if path.is_dir() {
            collect(&path, &format!("{name}/"), results);
        } else if !name.ends_with("snapshot.json") {
            let text = fs::read_to_string(&path).unwrap();
            results.insert(name.clone(), timeless(&name, &text).into_bytes());
        }
    }
}

/// A file's text without the wall times: the last column of the history, a key elsewhere.
fn timeless(name: &str, text: &str) -> String {
    if name.ends_with(".csv") {
        let cut = |line: &str| line.rsplit_once(',').unwrap().0.to_string() + "\n";
        return text.lines().map(cut).collect();
    }
    const KEY: &str = "\"seconds\":";
    let cut = |line: &str| match line.split_once(KEY) {
        None => line.to_string() + "\n",
        Some((before, after)) => {
            let number = |c: char| c.is_ascii_digit() || ".e-+".contains(c);
            format!("{before}{}\n", after.trim_start_matches(number))
        }
    };
    text.lines().map(cut).collect()
}
