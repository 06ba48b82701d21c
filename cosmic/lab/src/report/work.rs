//! Writes the report of a run, or of a design without a run.

use super::animation::{self, FILM, GIF, Pace, Shot};
use super::files::{RobotFiles, RunFiles};
use super::motion::Motion;
use super::{convergence, evolution, layout, page, robot};
use crate::files::write_texts;
use cosmic::Registry;
use cosmic::error::{Error, Result};
use cosmic::record::files::write_atomic;
use cosmic::record::run::DESIGN;
use cosmic::record::snapshot::SNAPSHOT;
use cosmic::record::summary::SUMMARY;
use cosmic::record::trajectory_file::TRAJECTORY;
use std::path::{Path, PathBuf};

/// The animations of a report. If neither `gif` nor `mp4` is true, the report of a run has a GIF.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Animations {
    /// Whether to write `gait.gif`.
    pub gif: bool,
    /// Whether to write `gait.mp4`, which needs ffmpeg on the path.
    pub mp4: bool,
    /// Whether to also write `evolution.gif`, `evolution.mp4` or both, which show robots from the first iteration to
    /// the last.
    pub evolution: bool,
}

/// Writes the report of a run or of a design alone, and returns the paths.
///
/// The report of a run is `report.html`, `robot.svg`, animations, and `convergence.svg` if the run has a history. The
/// report of a design alone is `report.html` and `robot.svg`. A design alone is a `.json` file, or a folder with a
/// design but without a run. Its scene is the file `scene.toml` beside it.
///
/// The errors of [`RunFiles::read`] and [`RobotFiles::read`]; [`Error::Usage`] if animations are wanted of a design
/// alone, or an evolution of a run without recorded walks; [`Error::Read`] if a film is wanted and ffmpeg is missing or
/// fails; [`Error::Write`].
pub fn write(path: &Path, animations: &Animations, registry: &Registry) -> Result<Vec<PathBuf>> {
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
        return of_run(&RunFiles::read(&folder, registry)?, animations);
    }
    let robot = RobotFiles::read(&design, registry)?;
    if *animations != Animations::default() {
        let design = design.display();
        return Err(Error::Usage(format!(
            "{design}: a design without a run has no rollout to animate; leave out --gif, --mp4 and --evolution"
        )));
    }
    let title = design.display().to_string();
    let texts = [
        ("report.html", page::of_design(&robot, &title)),
        ("robot.svg", layout::draw_layout(&robot)),
    ];
    write_texts(&folder, texts)
}

fn of_run(run: &RunFiles, animations: &Animations) -> Result<Vec<PathBuf>> {
    let robot = run.robot.drawn_as(&run.robot.design.z);
    let motion = Motion::new(&robot, &run.trajectory);
    let page = page::of_run(run, &motion);
    let mut texts = vec![("report.html", page), ("robot.svg", robot::draw(&motion))];
    if !run.history.is_empty() {
        texts.push(("convergence.svg", convergence::draw(run)));
    }
    let mut written = write_texts(&run.folder, texts)?;
    let whole = |pace| animation::shots(&motion, pace, f64::INFINITY, "");
    written.extend(animate(run, animations, "gait", whole)?);
    if animations.evolution {
        let walkers = evolution::walkers(run)?;
        let motions = evolution::motions(&walkers);
        let in_turn = |pace| evolution::in_turn(&walkers, &motions, pace);
        written.extend(animate(run, animations, "evolution", in_turn)?);
    }
    Ok(written)
}

/// Writes an animation as GIF, MP4 or both. `shots` returns the frames, for the pace of the format.
fn animate<'m>(
    run: &RunFiles,
    animations: &Animations,
    name: &str,
    shots: impl Fn(Pace) -> Vec<Shot<'m>>,
) -> Result<Vec<PathBuf>> {
    let path = |extension: &str| run.folder.join(format!("{name}.{extension}"));
    let mut written = Vec::new();
    if animations.gif || !animations.mp4 {
        written.push(path("gif"));
        write_atomic(&written[0], |file| animation::write_gif(&shots(GIF), file))?;
    }
    if animations.mp4 {
        written.push(path("mp4"));
        let film = animation::film(&shots(FILM))?;
        write_atomic(&path("mp4"), |file| file.write_all(&film))?;
    }
    Ok(written)
}
