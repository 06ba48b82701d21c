//! Writes the report of a run, or of a design without a run.

use super::animation::{self, FILM, GIF, Pace, Shot};
use super::files::{RobotFiles, RunFiles};
use super::motion::Motion;
use super::{convergence, evolution, layout, page, robot};
use crate::files::write_texts;
use crate::walk::{self, Walk, Way};
use cosmic::Registry;
use cosmic::error::{Error, Result};
use cosmic::record::files::{make_folder, write_atomic};
use cosmic::record::run::DESIGN;
use cosmic::record::snapshot::SNAPSHOT;
use cosmic::record::summary::SUMMARY;
use cosmic::record::trajectory_file::TRAJECTORY;
use cosmic::scene::GoalKind;
use std::path::{Path, PathBuf};

/// The animations of a report or of a walk. If neither `gif` nor `mp4` is true, there is a GIF.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Animations {
    /// Whether to write a GIF: `gait.gif` or `walk.gif`.
    pub gif: bool,
    /// Whether to write a film, `gait.mp4` or `walk.mp4`, which needs ffmpeg on the path.
    pub mp4: bool,
    /// For a report, whether to also write `evolution.gif`, `evolution.mp4` or both, which show robots from the first
    /// iteration to the last.
    pub evolution: bool,
}

/// Writes the report of a run or of a design alone, and returns the paths.
///
/// The report of a run is `report.html`, `robot.svg`, animations, and `convergence.svg` if the run has a history. The
/// report of a design alone is `report.html` and `robot.svg`. A design alone is a `.json` file, or a folder with a
/// design but without a run. Its scene is the file `scene.toml` beside it.
///
/// The page of a run whose robot takes goals shows its ways to nine goals, which are simulated.
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
    let page = page::of_run(run, &motion, &ways(run)?);
    let mut texts = vec![("report.html", page), ("robot.svg", robot::draw(&motion))];
    if !run.history.is_empty() {
        texts.push(("convergence.svg", convergence::draw(run)));
    }
    let mut written = write_texts(&run.folder, texts)?;
    let whole = |pace| animation::shots(&motion, pace, f64::INFINITY, "");
    written.extend(animate(&run.folder, animations, "gait", whole)?);
    if animations.evolution {
        let walkers = evolution::walkers(run)?;
        let motions = evolution::motions(&walkers);
        let in_turn = |pace| evolution::in_turn(&walkers, &motions, pace);
        written.extend(animate(&run.folder, animations, "evolution", in_turn)?);
    }
    Ok(written)
}

/// Simulates the ways of a run's robot to nine goals. Returns an empty list if the robot does not take goals, or if
/// this program lacks laws of the scene.
fn ways(run: &RunFiles) -> Result<Vec<Way>> {
    let scene = &run.robot.scene;
    if scene.controller.goals != GoalKind::Given || !run.robot.lacks().is_empty() {
        return Ok(Vec::new());
    }
    let case = (run.robot).case(&run.folder.join(DESIGN), "the ways to goals")?;
    walk::to_nine_goals(&case, scene.goals.along)
}

/// Writes a robot's walk to goals into a folder, and returns the paths: the page `walk.html`, and `walk.gif`,
/// `walk.mp4` or both. `title` is the heading of the page.
///
/// # Errors
/// [`Error::Read`] if a film is wanted and ffmpeg is missing or fails; [`Error::Write`].
pub fn write_walk(
    folder: &Path,
    (robot, walk): (&RobotFiles, &Walk),
    title: &str,
    animations: &Animations,
) -> Result<Vec<PathBuf>> {
    make_folder(folder)?;
    let robot = robot.drawn_as(&robot.design.z);
    let motion = Motion::new(&robot, &walk.trajectory).with_goals(&walk.goals);
    let page = page::of_walk(walk, &motion, title);
    let mut written = write_texts(folder, [("walk.html", page)])?;
    let whole = |pace| animation::shots(&motion, pace, f64::INFINITY, "");
    written.extend(animate(folder, animations, "walk", whole)?);
    Ok(written)
}

/// Writes an animation as GIF, MP4 or both. `shots` returns the frames, for the pace of the format.
fn animate<'m>(
    folder: &Path,
    animations: &Animations,
    name: &str,
    shots: impl Fn(Pace) -> Vec<Shot<'m>>,
) -> Result<Vec<PathBuf>> {
    let path = |extension: &str| folder.join(format!("{name}.{extension}"));
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
