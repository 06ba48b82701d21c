//! `cosmic walk`.

use crate::arguments::{Output, number};
use crate::output::{answer, in_json, lines};
use crate::source::design_path;
use clap::Args;
use cosmic::Registry;
use cosmic::case::Case;
use cosmic::error::{Error, Result};
use cosmic::geometry::Dimension;
use cosmic::numbers::plain;
use cosmic::policy::Goals;
use cosmic::scene::GoalsSettings;
use cosmic_lab::report::{RobotFiles, write_walk};
use cosmic_lab::walk::{self, Walk};
use serde_json::json;
use std::path::PathBuf;

/// Let a robot walk to goals, and show how near it gets
///
/// Prints a row for each goal: its place, when it begins and ends, the way to it when it begins, the distance that is
/// left when it ends, and the ratio of the two distances.
///
/// The run's scene must have `controller.goals = "given"`, as `errand` has. A goal is a place along the ground in
/// metres, counted from the payload at the start: positive is ahead. In space a goal may have a second number, its place
/// across: positive is to the left. Without --goal, the robot walks ahead, back and ahead: to the places that are a sixth
/// of `goals.along` from its ends (1.2 m and -1.2 m in `errand`), in space also a sixth of `goals.across`, for half of the
/// scene's time each, in whole seconds (8 s in `errand`).
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The folder of the run, or a design file with scene.toml beside it
    #[arg(value_name = "RUN")]
    run: PathBuf,
    /// A goal, and the time at which it begins; can be repeated, as in `--goal 1.2 --goal -1@5s`, in space also
    /// `--goal 1.2,0.5`. The first goal begins at 0 s and needs no time
    #[arg(long = "goal", value_name = "X[,Y][@TIME]", value_parser = told, allow_hyphen_values = true)]
    goals: Vec<GoalArgument>,
    /// How long the robot walks, s [default: the scene's time, or longer, until the last goal had half of that time]
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    seconds: Option<f64>,
    /// Write walk.html, on which the robot walks, and the animation walk.gif into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
}

/// The largest number of steps of a walk. The states of a longer walk may not fit into memory.
const MOST_STEPS: usize = 1_000_000;

/// A goal of the command line.
#[derive(Debug, Clone)]
struct GoalArgument {
    /// The argument, for messages.
    text: String,
    /// The place along the ground, counted from the payload at the start, m.
    along: f64,
    /// The place across, if it is given, m.
    across: Option<f64>,
    /// When the goal begins, s.
    time: Option<f64>,
}

/// The parts of a text before and after a mark.
fn cut(text: &str, mark: char) -> (&str, Option<&str>) {
    let parts = text.split_once(mark);
    parts.map_or((text, None), |(before, after)| (before, Some(after)))
}

/// Parses a goal, such as `1.2`, `-1@5s` or `1.2,0.5`.
fn told(text: &str) -> std::result::Result<GoalArgument, String> {
    let (place, time) = cut(text, '@');
    let (along, across) = cut(place, ',');
    let expected = "expected a place from -1000 to 1000 m, in space also one across, and its time after `@`, as in 1.2 or \
                    1.2,0.5 or -1@5s";
    let of_place = |text: &str| number(text, |x| x.abs() <= 1e3, expected.to_owned());
    let of_time = |time: &str| seconds(time.strip_suffix('s').unwrap_or(time));
    Ok(GoalArgument {
        text: text.to_owned(),
        along: of_place(along)?,
        across: across.map(of_place).transpose()?,
        time: time.map(of_time).transpose()?,
    })
}

/// Parses a time in seconds.
fn seconds(text: &str) -> std::result::Result<f64, String> {
    let expected = "expected a time from 0 to 1e6 s".to_owned();
    number(text, |x| (0.0..=1e6).contains(&x), expected)
}

impl Arguments {
    pub(super) fn run(&self, registry: &Registry) -> Result<()> {
        let path = design_path(&self.run)?;
        let robot = RobotFiles::read(&path, registry)?;
        let case = robot.case(&path)?;
        let ranges = &robot.scene.goals;
        let (goals, steps) = Plan::new(&case).walk(&self.goals, ranges, self.seconds)?;
        let walk = walk::walk(&case, &goals, steps)?;
        let written = match &self.out {
            None => Vec::new(),
            Some(folder) => {
                let title = format!("{} walks to goals", self.run.display());
                write_walk(folder, (&robot, &walk), &title)?
            }
        };
        self.show(&walk, &written)
    }

    fn show(&self, walk: &Walk, written: &[PathBuf]) -> Result<()> {
        let table = walk::table(&walk.legs);
        let value = json!({ "goals": table.to_json()["rows"], "written": in_json(written) });
        answer(&self.output, &value, &(table.to_text() + &lines(written)))
    }
}

/// Decides when goals begin and how long a robot walks.
struct Plan<'a> {
    case: &'a Case,
    /// The time step, s.
    dt: f64,
    /// The number of steps for which the last goal holds at least.
    leg: usize,
}

impl<'a> Plan<'a> {
    fn new(case: &'a Case) -> Self {
        let dt = case.scene.physics.dt;
        let half = 0.5 * dt * case.scene.physics.steps as f64;
        let half = if half < 1.0 { half } else { half.floor() };
        let leg = ((half / dt).round() as usize).max(1);
        Self { case, dt, leg }
    }

    /// The time after a number of steps, in seconds, for messages.
    fn time(&self, steps: usize) -> String {
        plain(steps as f64 * self.dt, 6)
    }

    /// Returns the goals and the number of steps of a walk. Without `told` goals, the robot walks to and fro within these
    /// ranges.
    fn walk(
        &self,
        told: &[GoalArgument],
        ranges: &GoalsSettings,
        seconds: Option<f64>,
    ) -> Result<(Goals, usize)> {
        let goals = match told {
            [] => self.to_and_fro(ranges),
            [first, later @ ..] => self.told(first, later)?,
        };
        let last = goals.later.last().map_or(0, |&(steps, _)| steps);
        let steps = match seconds {
            None => self.case.scene.physics.steps.max(last + self.leg),
            Some(seconds) => (seconds / self.dt).round() as usize,
        };
        let refuse = |says: String| Err(Error::Usage(says));
        if steps <= last {
            let (seconds, begins) = (seconds.unwrap_or(0.0), self.time(last));
            return refuse(format!(
                "--seconds is {seconds}, but it must be more than {begins}, because the last goal begins at {begins} s"
            ));
        }
        if steps > MOST_STEPS {
            let [long, most] = [steps, MOST_STEPS].map(|steps| self.time(steps));
            return refuse(format!(
                "the walk would take {long} s; it must take at most {most} s ({MOST_STEPS} steps): choose earlier \
                 goals or fewer --seconds"
            ));
        }
        Ok((goals, steps))
    }

    /// Goals ahead, behind, and ahead again; in space on the left, on the right, and on the left again.
    fn to_and_fro(&self, ranges: &GoalsSettings) -> Goals {
        let [along, across] = [ranges.along, ranges.across]
            .map(|[low, high]| [(5.0 * low + high) / 6.0, (low + 5.0 * high) / 6.0]);
        let [behind, ahead] = [0, 1].map(|k| walk::place(self.case, [along[k], across[k]]));
        let goals = Goals::at(ahead).then(self.leg, behind);
        goals.then(2 * self.leg, ahead)
    }

    fn told(&self, first: &GoalArgument, later: &[GoalArgument]) -> Result<Goals> {
        let steps = |time: f64| (time / self.dt).round() as usize;
        let refuse = |told: &GoalArgument, says: String| {
            Err(Error::Usage(format!("--goal {}: {says}", told.text)))
        };
        if first.time.is_some_and(|time| steps(time) > 0) {
            let says = "the first goal must begin at 0 s; leave out its time, or put another goal before it";
            return refuse(first, says.to_owned());
        }
        let in_plane = self.case.lattice.dimension == Dimension::Plane;
        let beside = |told: &&GoalArgument| in_plane && told.across.is_some();
        if let Some(told) = [first].into_iter().chain(later).find(beside) {
            let says = "the robot is planar, so a goal is one number; write it with a decimal point, as in 1.2";
            return refuse(told, says.to_owned());
        }
        let goal =
            |told: &GoalArgument| walk::place(self.case, [told.along, told.across.unwrap_or(0.0)]);
        let mut goals = Goals::at(goal(first));
        let mut before = 0;
        for told in later {
            let Some(time) = told.time else {
                let says =
                    "only the first goal can be without a time; say when this goal begins, as in";
                return refuse(told, format!("{says} --goal {}@5s", told.text));
            };
            if steps(time) <= before {
                let [step, last] = [1, before].map(|steps| self.time(steps));
                let says = format!(
                    "it begins at {time} s, but the goal before it begins at {last} s; a goal must begin at least one \
                     step ({step} s) after the goal before it"
                );
                return refuse(told, says);
            }
            before = steps(time);
            goals = goals.then(before, goal(told));
        }
        Ok(goals)
    }
}
