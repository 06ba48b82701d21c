//! Damaged files of runs: a crash of the machine may cut a file or leave any bytes in it.

use super::files::{DESIGN, SCENE, begin_again};
use super::history::{DESIGNS, LINES};
use super::snapshot::SNAPSHOT;
use super::summary::SUMMARY;
use super::trajectory_file::TRAJECTORY;
use crate::error::{Error, command, in_shell};
use crate::scene::TrussFile;
use serde::de::IgnoredAny;
use std::fs;
use std::path::Path;

/// Adds to the error about a malformed file of a run that the file is damaged, and how the run goes on or begins again.
/// Other errors do not change, and neither does an error about a file outside of a run, or about a law, a loss or a policy
/// that only another program has.
pub fn explained(path: &Path) -> impl FnOnce(Error) -> Error {
    move |mut error| {
        if let Error::Malformed {
            message, report, ..
        } = &mut error
            && !message.contains("names an unknown")
            && let Some(remedy) = remedy(path)
        {
            // A crash leaves zero bytes, bytes of another file, or the end of the text out.
            let is_damaged = ["damaged", "UTF-8", "is empty"]
                .iter()
                .any(|says| message.contains(says));
            let what = match message.starts_with("the format is") {
                true => "another program wrote the file",
                false if is_damaged => "the file is damaged",
                false => "if the file is damaged",
            };
            *report += &format!("\n  = {what}: {remedy}");
        }
        error
    }
}

/// How a run with a damaged file goes on. What is advised loses nothing: a file is removed only if the files that have its
/// content are whole.
fn remedy(path: &Path) -> Option<String> {
    let (folder, name) = (path.parent()?, path.file_name()?.to_str()?);
    let file = |name: &str| in_shell(&folder.join(name));
    let is_there = |name: &&str| folder.join(name).exists();
    let (has_begun, is_finished) = (is_there(&SNAPSHOT), is_there(&SUMMARY));
    let has_snapshot = is_whole_json(&folder.join(SNAPSHOT));
    Some(match name {
        SNAPSHOT if is_finished && is_there(&SCENE) => format!(
            "a finished run with a scene.toml does not need it; remove it with: rm {}",
            file(name)
        ),
        SNAPSHOT => format!("restore it from a copy, or {}", begin_again(folder)),
        _ if !has_begun => return None,
        SCENE | TrussFile::COPY | SUMMARY | DESIGN | TRAJECTORY if !has_snapshot => {
            "restore it from a copy; the run's snapshot, which could replace it, is damaged too"
                .to_owned()
        }
        SCENE | TrussFile::COPY => {
            let copies = [SCENE, TrussFile::COPY].into_iter().filter(is_there);
            let copies: Vec<String> = copies.map(file).collect();
            format!(
                "the run's snapshot has its content; remove it with: rm {}",
                copies.join(" ")
            )
        }
        LINES | DESIGNS if is_finished => {
            format!(
                "the result does not need it; remove it with: rm {}",
                file(name)
            )
        }
        SUMMARY | DESIGN | TRAJECTORY if is_finished => format!(
            "write the result again with: rm {} && {}",
            file(SUMMARY),
            command(format_args!("resume {}", in_shell(folder)))
        ),
        _ => return None,
    })
}

/// True if a file can be read as JSON of any kind.
fn is_whole_json(path: &Path) -> bool {
    let bytes = fs::read(path).unwrap_or_default();
    serde_json::from_slice::<IgnoredAny>(&bytes).is_ok()
}
