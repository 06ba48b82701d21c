//! `errands.json`: how the robot of a finished run walks to goals that it has never seen, also if it is disturbed.

use crate::walk::{Leg, Push, Walker, place};
use cosmic::Registry;
use cosmic::case::Case;
use cosmic::codesign::quantile;
use cosmic::domain::draw_goals;
use cosmic::error::Result;
use cosmic::geometry::{Ground, Profile, Range, Vector};
use cosmic::policy::Goals;
use cosmic::random::{Purpose, stream_of, symmetric};
use cosmic::record::files::{Format, read_json, write_json};
use cosmic::record::{DesignFile, Summary, run};
use cosmic::scene::{GoalKind, GoalsSettings};
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use rand::seq::IteratorRandom;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::iter::empty;
use std::path::Path;

const FORMAT: Format = Format::new("cosmic-errands", 1);

/// The name of the file in a run's folder.
const ERRANDS: &str = "errands.json";
/// The number of sequences of goals.
const SEQUENCES: u64 = 16;
/// The speed of a push for a robot of 0.5 m on earth, m/s: about the speed at which it walks.
const SPEED: f64 = 0.5;
/// The largest height of rough ground, in spacings of the lattice.
const ROUGHNESS: f64 = 0.2;
/// The largest number of heights of rough ground on each side of the robot.
const HEIGHTS: usize = 31;

/// The walks of a delivered robot to 16 sequences of goals, undisturbed and disturbed in three ways.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Errands {
    /// The robot as designed, on the ground of its scene.
    pub undisturbed: Loops,
    /// At a random time, all nodes of the robot are pushed ahead or back.
    pub pushed: Loops,
    /// The ground is rough, except below the robot at its start.
    pub rough: Loops,
    /// One actuator, drawn anew for each sequence, is passive.
    pub lost: Loops,
}

/// Walks of one robot with feedback and without it, to the same goals.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Loops {
    /// For each sequence of goals, its errands.
    pub closed: Vec<Vec<Errand>>,
    /// The same in open loop: the controller always observes the robot as it is at the start. It knows the goal as seen
    /// from there, and the clock.
    pub open: Vec<Vec<Errand>>,
}

/// The walk to one goal of a sequence.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Errand {
    /// The place of the goal along the ground, counted from the payload at the start, m.
    pub goal: f64,
    /// True if the goal is ahead of the robot when it begins. For a robot that diverges: if it is ahead of the goal
    /// before.
    pub ahead: bool,
    /// The distance from the goal when it ends, divided by the distance when it began; `None` if the robot diverged.
    pub ratio: Option<f64>,
}

/// What disturbs a robot.
#[derive(Clone, Copy)]
enum Disturbance {
    Undisturbed,
    Pushed,
    Rough,
    Lost,
}

/// A sequence of goals, with the disturbances on the way.
struct Drawn {
    goals: Goals,
    push: Push,
    ground: Profile,
    /// The edge whose actuator is lost; `None` for a robot without actuators.
    lost: Option<usize>,
}

/// The walks of a robot under one disturbance: the beginning of the names of its columns, its title in tables, and the
/// function that takes these walks from all.
pub(crate) type Disturbed = (&'static str, &'static str, fn(&Errands) -> &Loops);

/// A number that is taken from the walks of a robot: the end of the name of its column, its heading in tables, whether
/// it is in open loop, which errands count, and the quantile of their ratios.
pub(crate) type Measured = (&'static str, &'static str, bool, fn(&Errand) -> bool, f64);

impl Errands {
    pub(crate) const DISTURBED: [Disturbed; 4] = [
        ("errand", "none", |errands| &errands.undisturbed),
        ("errand_pushed", "a push", |errands| &errands.pushed),
        ("errand_rough", "rough ground", |errands| &errands.rough),
        ("errand_lost", "an actuator lost", |errands| &errands.lost),
    ];
    pub(crate) const MEASURED: [Measured; 6] = [
        ("p50", "median", false, |_| true, 0.5),
        ("p75", "75 %", false, |_| true, 0.75),
        ("ahead_p50", "ahead", false, |errand| errand.ahead, 0.5),
        ("behind_p50", "behind", false, |errand| !errand.ahead, 0.5),
        ("open_p50", "open loop", true, |_| true, 0.5),
        ("open_p75", "open loop, 75 %", true, |_| true, 0.75),
    ];

    /// The errands of a robot whose run diverged, for `count` goals in a sequence.
    pub(crate) fn of_diverged(count: usize) -> Self {
        let errand = |k: usize| Errand {
            goal: f64::NAN,
            ahead: k.is_multiple_of(2),
            ratio: None,
        };
        let sequence = |k: u64| (0..count).map(|leg| errand(k as usize + leg)).collect();
        let walks: Vec<Vec<Errand>> = (0..SEQUENCES).map(sequence).collect();
        let loops = Loops {
            closed: walks.clone(),
            open: walks,
        };
        Self {
            undisturbed: loops.clone(),
            pushed: loops.clone(),
            rough: loops.clone(),
            lost: loops,
        }
    }

    /// Measures a finished run and writes `errands.json`, unless the file exists or the robot has a fixed goal. Returns
    /// `None` if the measurement was stopped.
    ///
    /// # Errors
    /// The errors of reading the run's files and of [`write_json`].
    pub(crate) fn keep(
        folder: &Path,
        registry: &Registry,
        is_stopped: &dyn Fn() -> bool,
    ) -> Result<Option<()>> {
        let path = folder.join(ERRANDS);
        if path.exists() {
            return Ok(Some(()));
        }
        let scene = run::read_scene(folder, registry)?;
        if scene.controller.goals != GoalKind::Given {
            return Ok(Some(()));
        }
        let design = folder.join(run::DESIGN);
        let case = DesignFile::read(&design)?.case(&scene, &design.display().to_string())?;
        let seed = Summary::read(folder)?.seed;
        let found = Self::measure(&case, &scene.goals, seed, is_stopped);
        found
            .map(|found| write_json(&path, FORMAT, &found))
            .transpose()
    }

    /// Reads the errands of a run.
    ///
    /// # Errors
    /// The errors of [`read_json`].
    pub fn read(folder: &Path) -> Result<Self> {
        read_json(&folder.join(ERRANDS), FORMAT)
    }

    /// Measures a robot whose goals are inputs of a rollout. The seed determines the sequences and the disturbances.
    /// Returns `None` as soon as `is_stopped` returns true.
    pub fn measure(
        case: &Case,
        settings: &GoalsSettings,
        seed: u64,
        is_stopped: &dyn Fn() -> bool,
    ) -> Option<Self> {
        let draw = |number| Drawn::new(case, settings, seed, number);
        let drawn: Vec<Drawn> = (0..SEQUENCES).map(draw).collect();
        let walks = |disturbance, is_open| {
            let errands = |drawn: &Drawn| drawn.errands(case, disturbance, is_open);
            (!is_stopped()).then(|| drawn.par_iter().map(errands).collect())
        };
        let loops = |disturbance| {
            Some(Loops {
                closed: walks(disturbance, false)?,
                open: walks(disturbance, true)?,
            })
        };
        Some(Self {
            undisturbed: loops(Disturbance::Undisturbed)?,
            pushed: loops(Disturbance::Pushed)?,
            rough: loops(Disturbance::Rough)?,
            lost: loops(Disturbance::Lost)?,
        })
    }

    /// All numbers of a robot, each with the name of its column. A number is NaN if a robot diverged, and `None` without
    /// errands.
    pub(crate) fn numbers(errands: Option<&Self>) -> Vec<(String, Option<f64>)> {
        let number = |(name, _, of): Disturbed, measured: Measured| {
            let found = errands.map(|errands| quantile_of([of(errands)], measured));
            let name = format!("{name}_{}", measured.0);
            (name, found.map(|found| found.unwrap_or(f64::NAN)))
        };
        let numbers = |disturbed| Self::MEASURED.map(|measured| number(disturbed, measured));
        Self::DISTURBED.into_iter().flat_map(numbers).collect()
    }
}

/// The quantile of the ratios of the errands of several robots. `None` if it depends on a robot that diverged, or if no
/// errand counts.
pub(crate) fn quantile_of<'l>(
    robots: impl IntoIterator<Item = &'l Loops>,
    (_, _, is_open, counts, q): Measured,
) -> Option<f64> {
    let walks = |loops: &'l Loops| if is_open { &loops.open } else { &loops.closed };
    let errands = robots.into_iter().flat_map(walks).flatten();
    // A diverged robot is worst: `quantile` counts it as the lowest number, but the worst ratio is the highest.
    let minus = |errand: &Errand| errand.ratio.map_or(f64::NAN, |ratio| -ratio);
    let ratios: Vec<f64> = errands.filter(|&e| counts(e)).map(minus).collect();
    let worse = (!ratios.is_empty()).then(|| -quantile(&ratios, 1.0 - q));
    worse.filter(|ratio| ratio.is_finite())
}

impl Drawn {
    fn new(case: &Case, settings: &GoalsSettings, seed: u64, number: u64) -> Self {
        let (task, steps) = (case.task(), case.physics.steps);
        let mut stream = stream_of(seed, Purpose::UnseenErrands, number);
        let ahead = number.is_multiple_of(2);
        let goals = draw_goals(&task, settings, settings.count, ahead, &mut stream);
        // Robots of equal shape walk at speeds in proportion to the root of length and gravity.
        let scale = (case.lattice.length() * case.physics.gravity.abs() / (0.5 * 9.81)).sqrt();
        let push = Push {
            after: stream.random_range(1..steps.max(2)),
            speed: (SPEED * scale).copysign(symmetric(&mut stream, 1.0)),
        };
        let strains = case.body().strain;
        let actuators = (0..strains.len()).filter(|&edge| strains[edge] != 0.0);
        Self {
            goals,
            push,
            lost: actuators.choose(&mut stream),
            ground: rough(case, settings, &mut stream),
        }
    }

    /// The errands of a robot with these goals. It is not disturbed by anything but `disturbance`.
    fn errands(&self, case: &Case, disturbance: Disturbance, is_open: bool) -> Vec<Errand> {
        let mut case = case.clone();
        if let Disturbance::Rough = disturbance {
            case.physics.ground = self.ground.clone().into();
        }
        let mut task = case.task().with_goals(&self.goals);
        if is_open {
            task = task.without_feedback(&case.start);
        }
        let mut body = task.body(&case.own_design());
        if let (Disturbance::Lost, Some(edge)) = (disturbance, self.lost) {
            body.strain[edge] = 0.0;
        }
        let walker = Walker {
            task: &task,
            body,
            controller: &case.controller,
            start: &case.start,
            push: matches!(disturbance, Disturbance::Pushed).then_some(self.push),
        };
        let Ok(trajectory) = walker.walk(&self.goals, empty()) else {
            return self.diverged(&case);
        };
        // An errand to the place where the robot already is has no ratio.
        let errand = |leg: Leg| {
            Some(Errand {
                goal: leg.goal,
                ahead: leg.is_ahead,
                ratio: Some(leg.ratio()?),
            })
        };
        let legs = walker.legs(&self.goals, &trajectory).into_iter();
        legs.filter_map(errand).collect()
    }

    /// The errands of a robot that diverges.
    fn diverged(&self, case: &Case) -> Vec<Errand> {
        let (start, mut before) = (place(case, 0.0).forward(), 0.0);
        let errand = |point: Vector<f64>| {
            let goal = point.forward() - start;
            let ahead = goal > std::mem::replace(&mut before, goal);
            Errand {
                goal,
                ahead,
                ratio: None,
            }
        };
        self.goals.iter().map(errand).collect()
    }
}

/// Draws the profile of rough ground: random heights, a spacing of the lattice apart. It is level below the robot at its
/// start, and rough as far as the robot may go to its goals.
fn rough(case: &Case, settings: &GoalsSettings, stream: &mut ChaCha8Rng) -> Profile {
    let (ground, spacing) = (Ground::from(&case.physics), case.lattice.spacing);
    let nodes = Range::of(case.start.x.iter().map(|&x| ground.along(x)));
    let (payload, beyond) = (place(case, 0.0).forward(), nodes.size());
    let [low, high] = settings.along;
    let far = [
        nodes.low - (payload + low - beyond),
        payload + high + beyond - nodes.high,
    ];
    let [behind, ahead] = far.map(|far| ((far / spacing).ceil() as usize).min(HEIGHTS));
    let mut at = |along: f64| Vector::new([along, symmetric(stream, ROUGHNESS * spacing)]);
    let mut points: Vec<Vector<f64>> = Vec::new();
    points.extend(
        (1..=behind)
            .rev()
            .map(|k| at(nodes.low - k as f64 * spacing)),
    );
    points.extend([nodes.low, nodes.high].map(|along| Vector::new([along, 0.0])));
    points.extend((1..=ahead).map(|k| at(nodes.high + k as f64 * spacing)));
    Profile::new(points).expect("at most 64 points, in ascending order")
}
