//! The cases of a folder: data files with reference answers.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::ba::Ba;
use super::gmm::Gmm;
use super::hand::Hand;
use super::input::{self, Error};
use super::lstm::Lstm;
use super::{Kind, Problem};

/// A data file with its reference answer.
#[derive(Clone, Debug)]
pub struct DataFile {
    /// Its name, that of its files.
    pub name: String,
    /// The problem.
    pub kind: Kind,
    /// The data.
    pub file: PathBuf,
    /// The reference answer.
    pub reference: Value,
}

impl Kind {
    /// The problem by the name that a reference answer has for it, and the folder of its data.
    fn of(name: &str) -> Option<(Self, &'static str)> {
        match name {
            "gmm" => Some((Kind::Gmm, "gmm")),
            "ba" => Some((Kind::Ba, "ba")),
            "lstm" => Some((Kind::Lstm, "lstm")),
            "hand" | "hand_complicated" => Some((Kind::Hand, "hand")),
            _ => None,
        }
    }
}

/// Reads an instance. A hand's model lies in `model`, or else in the folder of that name beside
/// the file.
///
/// # Errors
/// If a file cannot be read or is not in its format.
pub fn open(kind: Kind, file: &Path, model: Option<&Path>) -> Result<Box<dyn Problem>, Error> {
    Ok(match kind {
        Kind::Gmm => Box::new(Gmm::read(file)?),
        Kind::Ba => Box::new(Ba::read(file)?),
        Kind::Lstm => Box::new(Lstm::read(file)?),
        Kind::Hand => {
            let beside = file.with_file_name("model");
            Box::new(Hand::read(file, model.unwrap_or(&beside))?)
        }
    })
}

/// All cases of a folder, by name: every `reference/CASE.json`, with its `data/KIND/CASE.txt`.
///
/// # Errors
/// If there are none, or one cannot be read.
pub fn cases(folder: &Path) -> Result<Vec<DataFile>, Error> {
    let references = folder.join("reference");
    let unreadable = |source| Error::Unreadable {
        path: references.clone(),
        source,
    };
    let mut cases = Vec::new();
    for entry in std::fs::read_dir(&references).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        if path
            .extension()
            .is_some_and(|extension| extension == "json")
        {
            cases.push(case(folder, &path)?);
        }
    }
    if cases.is_empty() {
        return Err(Error::Malformed {
            path: references,
            what: "holds no reference answer".into(),
        });
    }
    cases.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(cases)
}

fn case(folder: &Path, path: &Path) -> Result<DataFile, Error> {
    let malformed = |what: String| Error::Malformed {
        path: path.to_owned(),
        what,
    };
    let reference: Value =
        serde_json::from_str(&input::read(path)?).map_err(|error| malformed(error.to_string()))?;
    let text = |key: &str| {
        let text = reference[key].as_str().map(str::to_owned);
        text.ok_or_else(|| malformed(format!("has no '{key}'")))
    };
    let (name, kind) = (text("case")?, text("kind")?);
    let missing = || malformed(format!("'{kind}' is no kind of problem"));
    let (kind, data) = Kind::of(&kind).ok_or_else(missing)?;
    Ok(DataFile {
        file: folder.join("data").join(data).join(format!("{name}.txt")),
        kind,
        name,
        reference,
    })
}
