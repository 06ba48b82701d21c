//! Writes the report of a run, or of a design without a run.

use super::files::{RobotFiles, RunFiles};
use super::gait::Gait;
use super::motion::DrawnMotion;
use super::{animation, page, robot};
use crate::files::write_texts;
use crate::walk::Walk;
use cosmic::Registry;
use cosmic::error::{Error, Result};
use cosmic::record::TrajectoryFile;
use cosmic::record::files::{make_folder, write_atomic};
use cosmic::record::run::DESIGN;
use cosmic::record::snapshot::SNAPSHOT;
use cosmic::record::summary::SUMMARY;
use cosmic::record::trajectory_file::TRAJECTORY;
use std::path::{Path, PathBuf};

/// Writes the report of a run or of a design alone, and returns the paths.
///
/// The report of a run is `report.html`, `robot.svg` and `gait.gif`. The report of a design alone is `report.html`. A
/// design alone is a `.json` file, or a folder with a design but without a run. Its scene is the file `scene.toml`
/// beside it.
///
/// # Errors
/// The errors of [`RunFiles::read`] and [`RobotFiles::read`]; [`Error::Write`].
pub fn write(path: &Path, registry: &Registry) -> Result<Vec<PathBuf>> {
    match Subject::read(path, registry)? {
        Subject::Run(run) => of_run(&run),
        Subject::Design(folder, design, robot) => {
            let page = page::of_design(&robot, &design.display().to_string());
            write_texts(&folder, [("report.html", page)])
        }
    }
}

/// Writes only the page of a run or of a design alone, to this file, and leaves the folder of the run as it is.
///
/// # Errors
/// The errors of [`write()`].
pub fn write_page(path: &Path, file: &Path, registry: &Registry) -> Result<()> {
    let page = match Subject::read(path, registry)? {
        Subject::Run(run) => {
            let robot = run.robot.drawn();
            let motion = DrawnMotion::new(&robot, &run.trajectory);
            page::of_run(&run, &motion, &Gait::new(&run)?)
        }
        Subject::Design(_, design, robot) => page::of_design(&robot, &design.display().to_string()),
    };
    write_atomic(file, |out| out.write_all(page.as_bytes()))
}

/// What a report is about: a run, or a design alone with its folder and its file.
enum Subject {
    Run(Box<RunFiles>),
    Design(PathBuf, PathBuf, Box<RobotFiles>),
}

impl Subject {
    fn read(path: &Path, registry: &Registry) -> Result<Self> {
        let (folder, design) = if path.is_file() {
            if path.extension().is_none_or(|name| name != "json") {
                return Err(Error::Usage(format!(
                    "{}: this is neither the folder of a run nor a design.json; give one of these",
                    path.display()
                )));
            }
            (path.with_file_name(""), path.to_owned())
        } else {
            (path.to_owned(), path.join(DESIGN))
        };
        let has = |name: &&str| folder.join(name).exists();
        let is_of_run =
            design == folder.join(DESIGN) && [SUMMARY, SNAPSHOT, TRAJECTORY].iter().any(has);
        if is_of_run || !design.exists() {
            return Ok(Self::Run(Box::new(RunFiles::read(&folder, registry)?)));
        }
        let robot = Box::new(RobotFiles::read(&design, registry)?);
        Ok(Self::Design(folder, design, robot))
    }
}

fn of_run(run: &RunFiles) -> Result<Vec<PathBuf>> {
    let robot = run.robot.drawn();
    let motion = DrawnMotion::new(&robot, &run.trajectory);
    let page = page::of_run(run, &motion, &Gait::new(run)?);
    let texts = [("report.html", page), ("robot.svg", robot::draw(&motion))];
    let mut written = write_texts(&run.folder, texts)?;
    written.push(animate(&run.folder.join("gait.gif"), &motion)?);
    Ok(written)
}

/// Writes a robot's walk to goals into a folder, and returns the paths: the page `walk.html`, and `walk.gif`. `title` is
/// the heading of the page.
///
/// # Errors
/// [`Error::Write`].
pub fn write_walk(
    folder: &Path,
    (robot, walk): (&RobotFiles, &Walk),
    title: &str,
) -> Result<Vec<PathBuf>> {
    make_folder(folder)?;
    let robot = robot.drawn();
    let motion = DrawnMotion::new(&robot, &walk.trajectory).with_goals(&walk.goals);
    let page = page::of_walk(walk, &motion, title);
    let mut written = write_texts(folder, [("walk.html", page)])?;
    written.push(animate(&folder.join("walk.gif"), &motion)?);
    Ok(written)
}

/// Writes a motion of a robot as a GIF.
///
/// # Errors
/// [`Error::Write`].
///
/// # Panics
/// If the trajectory has no states.
pub fn write_animation(
    path: &Path,
    robot: &RobotFiles,
    trajectory: &TrajectoryFile,
) -> Result<PathBuf> {
    animate(path, &DrawnMotion::new(&robot.drawn(), trajectory))
}

fn animate(path: &Path, motion: &DrawnMotion) -> Result<PathBuf> {
    write_atomic(path, |file| animation::write_gif(motion, file))?;
    Ok(path.to_owned())
}
