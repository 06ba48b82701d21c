//! Helpers for the tests of both crates together: reference files, comparisons with them, and small robots.

mod bare;
pub mod laws;
pub mod readers;
mod robot;

pub use bare::Bare;
pub use robot::{assert_smooth, farthest, few_directions, least_height, robot, robot_of, states};

use std::fmt::Display;
use std::path::{Path, PathBuf};

use cosmic::case::Case;
use serde_json::Value;

/// The folder of reference cases. The environment variable `REFERENCE_DIR` names it; by default it is the folder of
/// this project.
pub fn reference_folder() -> PathBuf {
    std::env::var_os("REFERENCE_DIR").map_or_else(own_reference_folder, PathBuf::from)
}

/// The folder with the reference cases of this project.
pub fn own_reference_folder() -> PathBuf {
    workspace().join("tests/data/reference")
}

/// The subfolder `name` of the folder of reference cases, or, if it does not exist, the subfolder of this project's own
/// cases.
pub fn reference_subfolder(name: &str) -> PathBuf {
    let given = reference_folder().join(name);
    match given.is_dir() {
        true => given,
        false => own_reference_folder().join(name),
    }
}

/// The root folder of the workspace.
pub fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The paths directly in a folder, sorted by name.
///
/// # Panics
/// If the folder cannot be listed.
pub fn entries(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder)
        .unwrap_or_else(|error| panic!("cannot list {}: {error}", folder.display()));
    let path = |entry: std::io::Result<std::fs::DirEntry>| entry.expect("an entry is readable");
    let mut paths: Vec<_> = entries.map(|entry| path(entry).path()).collect();
    paths.sort();
    paths
}

/// The files in a folder and its subfolders whose name ends with one of these extensions.
///
/// # Panics
/// If a folder cannot be listed.
pub fn files_below(folder: &Path, extensions: &[&str]) -> Vec<PathBuf> {
    let below = entries(folder)
        .into_iter()
        .flat_map(|path| match path.is_dir() {
            true => files_below(&path, extensions),
            false => vec![path],
        });
    below
        .filter(|path| has_extension(path, extensions))
        .collect()
}

fn has_extension(path: &Path, extensions: &[&str]) -> bool {
    let extension = path.extension().unwrap_or_default();
    extensions.iter().any(|one| extension == *one)
}

/// A reference file that has been read.
#[derive(Clone, Debug)]
pub struct Reference {
    /// The path of the file.
    pub path: PathBuf,
    /// The content of the file as text.
    pub text: String,
    /// The content of the file as JSON.
    pub json: Value,
}

impl Reference {
    /// The name of the file, for messages about failures.
    pub fn name(&self) -> String {
        self.path.display().to_string()
    }

    /// Reads the case in the file, which may have the laws of the [example programs](laws).
    ///
    /// # Panics
    /// If the file is not a case.
    pub fn case(&self) -> Case {
        let case = Case::parse_with(&laws::registry(), &self.name(), &self.text);
        case.unwrap_or_else(|error| panic!("{error}"))
    }

    /// Asserts that `got` agrees with `expected`. The file states the tolerance under the name `tolerance`. A failure
    /// message calls the compared numbers `result`.
    ///
    /// # Panics
    /// If they do not agree, or the file does not have that tolerance.
    pub fn check(&self, result: &str, tolerance: &str, [got, expected]: [&[f64]; 2]) {
        let name = self.name();
        let bound = number(&self.json["tolerance"], tolerance);
        let error = relative_error(got, expected);
        assert!(
            error <= bound,
            "{name}: {result} has the error {error:e}, but at most {bound:e} is allowed"
        );
    }
}

/// Reads every `*.json` file directly in a folder, sorted by name.
///
/// # Panics
/// If there is no such file, because a test without cases would prove nothing.
pub fn references(folder: &Path) -> Vec<Reference> {
    let mut paths = entries(folder);
    paths.retain(|path| has_extension(path, &["json"]));
    assert!(!paths.is_empty(), "no JSON file in {}", folder.display());
    paths.into_iter().map(read).collect()
}

fn read(path: PathBuf) -> Reference {
    let text = std::fs::read_to_string(&path)
        .unwrap_or_else(|error| panic!("cannot read {}: {error}", path.display()));
    let json = serde_json::from_str(&text)
        .unwrap_or_else(|error| panic!("{} is not JSON: {error}", path.display()));
    Reference { path, text, json }
}

/// The number `key` of a JSON object.
///
/// # Panics
/// If the object has no number of that name.
pub fn number(object: &Value, key: &str) -> f64 {
    object[key]
        .as_f64()
        .unwrap_or_else(|| panic!("`{key}` is missing or not a number in {object}"))
}

/// All numbers in a JSON value, in the order of the text. The value is a number or a list, and lists may be nested.
///
/// # Panics
/// If the value holds anything but numbers and lists.
pub fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(list) => list.iter().flat_map(numbers).collect(),
        other => vec![
            other
                .as_f64()
                .unwrap_or_else(|| panic!("{other} is not a number")),
        ],
    }
}

/// Asserts that `got` differs from `expected` by at most `bound`. If the assertion fails, the message begins with `of`.
///
/// # Panics
/// If it is not within the bound.
#[track_caller]
pub fn assert_near(got: f64, expected: f64, bound: f64, of: &dyn Display) {
    let error = (got - expected).abs();
    assert!(
        error <= bound,
        "{of}: found {got}, expected {expected}; off by {error:e}, at most {bound:e} is allowed"
    );
}

/// The relative error `|got - expected| / |expected|` of a vector in the L2 norm. If the expected vector is zero, the
/// absolute error.
pub fn relative_error(got: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(got.len(), expected.len(), "the fields differ in length");
    let norm = |terms: &mut dyn Iterator<Item = f64>| terms.map(|x| x * x).sum::<f64>().sqrt();
    let error = norm(&mut got.iter().zip(expected).map(|(g, e)| g - e));
    let size = norm(&mut expected.iter().copied());
    if size == 0.0 { error } else { error / size }
}

/// Makes the code in the repository's README doc tests.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;

/// Makes the code of the page about a user's own parts doc tests.
#[cfg(doctest)]
#[doc = include_str!("../../docs/extending.md")]
struct Extending;
