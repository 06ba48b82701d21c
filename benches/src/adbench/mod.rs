//! Reads the files of ADBench, and compares and times answers as ADBench does.

mod files;
mod reference;
mod table;

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::objectives::{Error, Problem, problem};
pub use files::input;
pub use reference::{Gap, gap};
pub use table::table;

/// A data file of ADBench with its reference answer.
#[derive(Clone, Debug)]
pub struct Case {
    /// The name of the case. The data file and the reference file have this name.
    pub name: String,
    /// The GradBench module: `gmm`, `ba`, `lstm` or `ht`.
    pub module: String,
    /// The path of the data file.
    pub file: PathBuf,
    /// The reference answer.
    pub reference: Value,
}

impl Case {
    /// Reads the data file as a problem that is ready to run.
    ///
    /// # Errors
    /// If a file cannot be read or has the wrong format.
    pub fn open(&self) -> Result<Box<dyn Problem>, Error> {
        let model = self.file.with_file_name("model");
        problem(&self.module, input(&self.module, &self.file, &model)?)
    }
}

/// Returns all cases of a folder, sorted by name: every `reference/CASE.json` with its `data/KIND/CASE.txt`.
///
/// # Errors
/// If the folder has no case, or a case cannot be read.
pub fn cases(folder: &Path) -> Result<Vec<Case>, Error> {
    let references = folder.join("reference");
    let wrong = Error::file(&references);
    let files = std::fs::read_dir(&references).map_err(|error| wrong(error.to_string()))?;
    let paths = files.flatten().map(|file| file.path());
    let paths = paths.filter(|path| path.extension().is_some_and(|e| e == "json"));
    let cases = paths.map(|path| case(folder, &path));
    let mut cases = cases.collect::<Result<Vec<Case>, _>>()?;
    if cases.is_empty() {
        return Err(wrong(
            "the folder has no reference answers; expected files `reference/CASE.json`".into(),
        ));
    }
    cases.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(cases)
}

fn case(folder: &Path, path: &Path) -> Result<Case, Error> {
    let reference: Value = serde_json::from_str(&Error::read(path)?)?;
    let field = |key: &str| {
        let text = reference[key].as_str();
        text.ok_or_else(|| Error::file(path)(format!("the key `{key}` is missing")))
    };
    let (name, kind) = (field("case")?.to_owned(), field("kind")?);
    let kind = kind.trim_end_matches("_complicated");
    Ok(Case {
        file: folder.join("data").join(kind).join(format!("{name}.txt")),
        module: if kind == "hand" { "ht" } else { kind }.to_owned(),
        name,
        reference,
    })
}
