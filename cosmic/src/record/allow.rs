//! Letting a run go on although its time step became unstable.

use super::folder::take_up;
use super::run::{SCENE, keep_scene};
use super::snapshot::SNAPSHOT;
use crate::error::{Error, Result};
use crate::scene::UnstableStep;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Has a folder's run, and all its starts, go on as if the scene had said
/// `unstable_step = "warn"`. Nothing is done for one that is finished.
///
/// # Errors
/// Those of reading and writing a snapshot, [`Error::Usage`] where `scene.toml` is not the scene
/// that the run began with, or where another process is at work on the run.
pub fn allow_unstable(folder: &Path) -> Result<()> {
    let Some((_lock, mut snapshot)) = take_up(folder)? else {
        return Ok(());
    };
    if snapshot.progress.as_ref().is_some_and(|p| p.own_loss) {
        return Err(Error::Usage(format!(
            "{}: the run is for a loss of its own: the program that began it begins anew, with \
             `physics.unstable_step = \"warn\"` in its scene",
            folder.display()
        )));
    }
    if snapshot.plan.scene.physics.unstable_step != UnstableStep::Warn {
        let scene = folder.join(SCENE);
        keep_scene(folder, &snapshot.plan.scene)?;
        // It comes back from the snapshot. In this order a crash leaves no two that differ.
        fs::remove_file(&scene).map_err(|source| Error::Write {
            path: scene,
            source,
        })?;
        snapshot.plan.to_mut().scene.physics.unstable_step = UnstableStep::Warn;
        snapshot.write(folder)?;
        keep_scene(folder, &snapshot.plan.scene)?;
    }
    starts(folder)?
        .iter()
        .try_for_each(|start| allow_unstable(start))
}

/// The folders of a run's starts that have begun.
fn starts(folder: &Path) -> Result<Vec<PathBuf>> {
    let path = folder.join("starts");
    let entries = match fs::read_dir(&path) {
        Ok(entries) => entries,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        Err(source) => return Err(Error::Read { path, source }),
    };
    let folders = entries.flatten().map(|entry| entry.path());
    Ok(folders.filter(|f| f.join(SNAPSHOT).exists()).collect())
}
