//! The report of a run, or of a design alone.

use super::files::{RobotFiles, RunFiles};
use super::motion::Motion;
use super::{animation, convergence, layout, page, robot};
use crate::files::write_texts;
use cosmic::error::Result;
use cosmic::record::files::write_atomic;
use cosmic::record::run::DESIGN;
use cosmic::record::snapshot::SNAPSHOT;
use cosmic::record::summary::SUMMARY;
use cosmic::record::trajectory_file::TRAJECTORY;
use std::path::{Path, PathBuf};

/// Writes the report of a run's folder, or of a design, into that folder: `report.html`, `robot.svg`
/// and, for a run, `convergence.svg` if it has a history, and `gait.gif`. The page holds all of its
/// pictures and fetches nothing. Returns the paths.
///
/// A folder without a run in it, or a file, is a design alone; its scene is `scene.toml` beside it.
///
/// # Errors
/// The errors of [`RunFiles::read`] and [`RobotFiles::read`]; [`Error::Write`](cosmic::Error::Write).
pub fn write(path: &Path) -> Result<Vec<PathBuf>> {
    let (folder, design) = if path.is_file() {
        (path.with_file_name(""), path.to_owned())
    } else {
        (path.to_owned(), path.join(DESIGN))
    };
    let has = |name: &&str| folder.join(name).exists();
    let is_of_run =
        design == folder.join(DESIGN) && [SUMMARY, SNAPSHOT, TRAJECTORY].iter().any(has);
    if is_of_run || !design.exists() {
        return of_run(&RunFiles::read(&folder)?);
    }
    let robot = RobotFiles::read(&design)?;
    let title = design.display().to_string();
    let texts = [
        ("report.html", page::of_design(&robot, &title)),
        ("robot.svg", layout::draw_layout(&robot)),
    ];
    write_texts(&folder, texts)
}

fn of_run(run: &RunFiles) -> Result<Vec<PathBuf>> {
    let motion = Motion::new(&run.robot, &run.trajectory);
    let page = page::of_run(run, &motion);
    let mut texts = vec![("report.html", page), ("robot.svg", robot::draw(&motion))];
    if !run.history.is_empty() {
        texts.push(("convergence.svg", convergence::draw(run)));
    }
    let mut written = write_texts(&run.folder, texts)?;
    let path = run.folder.join("gait.gif");
    write_atomic(&path, |file| animation::write(&motion, file))?;
    written.push(path);
    Ok(written)
}
