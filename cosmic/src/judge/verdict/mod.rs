//! The verdict on a robot: what an engineer wants to know first, in plain words. Each item has a level, which follows
//! from stated thresholds: whether a robot of real bars and muscles could do what the simulation shows.
//!
//! `docs/files.md` has the thresholds in a table.

mod hints;
mod lacks;
mod sheet;
mod steps;
mod walk;

pub use steps::HalfStep;

use serde::Serialize;

use super::{Reliability, Standstill};
use crate::design::{Structure, VolumeBounds};
use crate::lattice::Lattice;
use crate::numbers::{brief, fixed, mass, percent};
use crate::scene::{DataSheet, Riser};
use crate::walk::{Energy, Loads};

/// Distances of a walk in lengths of the robot, from which it is sound, and from which it is doubtful. Below the second one,
/// it [stays in place](Lattice::least_walk).
pub const WALKS: [f64; 2] = [0.5, Lattice::STAYS];
/// A robot with a task other than distance must have a loss that is below its loss at rest by more than this fraction.
const LEAST_GAIN: f64 = 0.02;
/// The share of time in which bars may pass through each other until a robot counts as impossible. In flat robots, a
/// short brush can be avoided by a little play; longer contact cannot.
pub const BRUSHES: f64 = 0.01;
/// Strains of the skeleton up to which it is sound, and up to which it is doubtful. Hard plastics yield at 1 to 2 %,
/// tough ones such as nylon at about 5 %, metals earlier.
pub const SKELETON_STRAINS: [f64; 2] = [0.01, 0.05];
/// Strains of a muscle as multiples of its largest target strain, up to which it is sound, and up to which it is
/// doubtful. Real muscles have a hard end, which gives way a little.
pub const STROKES: [f64; 2] = [1.05, 1.25];
/// Powers of a muscle (the 99 % quantile) divided by its mass, or by the mean mass of a bar if it is not known, up to which
/// it is sound, and up to which it is doubtful, W/kg. Servos and the muscles of animals reach about 300 W/kg; only pneumatic muscles and catapults reach 3000 W/kg.
pub const MUSCLE_POWERS: [f64; 2] = [300.0, 3000.0];
/// Euler safeties of a skeleton bar from which it is sound, and from which it is doubtful. Columns are designed with a
/// safety of about 2; below 1, a straight bar buckles.
pub const EULER_SAFETIES: [f64; 2] = [2.0, 1.0];
/// How long the robot walks on its battery: from the first time on it is sound, from the second time on doubtful, s.
pub const ENDURANCES: [f64; 2] = [600.0, 60.0];
/// The energy of a battery that is a fifth of the robot's mass, J per kg of the robot: 150 Wh per kg of battery.
pub const BATTERY: f64 = 0.2 * 150.0 * 3600.0;

/// The angle between the way of a robot in space and its heading up to which the heading is sound, degrees. From 10
/// degrees on, a robot is more than a sixth of its way off its line.
pub const HEADING: f64 = 10.0;
/// The share of its distance that a sound robot still covers with [less friction](crate::judge::LOW_FRICTION).
pub const SURE_FOOTED: f64 = 0.5;

/// How good an item of a verdict is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// It is not judged: it says what a user must know, whatever the numbers are.
    Remark,
    /// Nothing speaks against it.
    Good,
    /// It may be a problem, or it is not known.
    Doubtful,
    /// A robot that is built like this does not work.
    Bad,
}

impl Level {
    /// The level of a number that is good up to `limits[0]` and doubtful up to `limits[1]`.
    pub fn up_to(limits: [f64; 2], number: f64) -> Self {
        if number <= limits[0] {
            Self::Good
        } else if number <= limits[1] {
            Self::Doubtful
        } else {
            // NaN is bad too.
            Self::Bad
        }
    }

    /// The level of a number that is good from `limits[0]` on and doubtful from `limits[1]` on.
    pub fn from_on(limits: [f64; 2], number: f64) -> Self {
        Self::up_to(limits.map(|limit| -limit), -number)
    }

    /// The name of the level in files and style sheets.
    pub fn name(self) -> &'static str {
        match self {
            Self::Remark => "remark",
            Self::Good => "good",
            Self::Doubtful => "doubtful",
            Self::Bad => "bad",
        }
    }
}

/// A statement about a robot.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Item {
    /// The statement, in a few words.
    pub text: String,
    /// How good it is.
    pub level: Level,
    /// True for what the robot is and does, such as its speed; false for a limit of what can be built.
    #[serde(skip)]
    pub is_figure: bool,
}

impl Item {
    /// A limit of what can be built, and whether the robot respects it.
    pub fn limit(text: impl Into<String>, level: Level) -> Self {
        Self {
            text: text.into(),
            level,
            is_figure: false,
        }
    }

    /// Something to know about a robot that no number of it changes.
    pub fn remark(text: impl Into<String>) -> Self {
        Self::limit(text, Level::Remark)
    }

    /// A number that says what the robot is or does.
    pub fn figure(text: impl Into<String>, level: Level) -> Self {
        Self {
            is_figure: true,
            ..Self::limit(text, level)
        }
    }
}

/// The verdict on a robot. In JSON it is the list of its items.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Verdict {
    /// First the figures, then the limits.
    pub items: Vec<Item>,
    /// For a robot that does not get far: what may stop it, and what to try.
    #[serde(skip)]
    pub hints: Vec<String>,
}

/// A part of the sentence that a verdict is: a word or two before its items, and the items.
pub type Clause<'v> = (&'static str, Vec<&'v Item>);

impl Verdict {
    /// The worst level of all items.
    pub fn level(&self) -> Level {
        let levels = self.items.iter().map(|item| item.level);
        levels.fold(Level::Good, Level::max)
    }

    /// The verdict as the parts of a line: the figures, then the limits that are exceeded, then those that are doubtful. If
    /// all items are good, the next part has no items and says so. Remarks come last.
    pub fn clauses(&self) -> Vec<Clause<'_>> {
        let of = |is_figure: bool, level: Option<Level>| -> Vec<&Item> {
            let items = self.items.iter();
            let fits = |item: &&Item| {
                item.is_figure == is_figure && level.is_none_or(|level| level == item.level)
            };
            items.filter(fits).collect()
        };
        let limits = [
            ("Would not work as built: ", of(false, Some(Level::Bad))),
            ("Doubtful: ", of(false, Some(Level::Doubtful))),
        ];
        let limits = limits.into_iter().filter(|(_, items)| !items.is_empty());
        let mut clauses = vec![("", of(true, None))];
        clauses.extend(limits);
        let is_limit = |item: &Item| !item.is_figure && item.level != Level::Remark;
        if self.items.iter().any(is_limit) && self.level() == Level::Good {
            clauses.push(("Nothing measured here speaks against building it", vec![]));
        }
        let remarks = of(false, Some(Level::Remark));
        clauses.extend((!remarks.is_empty()).then_some(("To note: ", remarks)));
        clauses.retain(|(says, items)| !says.is_empty() || !items.is_empty());
        clauses
    }

    /// The verdict in one line. `shown` converts an item to text, for example with a colour.
    pub fn line(&self, shown: impl Fn(&Item) -> String) -> String {
        let clause = |(says, items): &Clause| {
            let items: Vec<String> = items.iter().map(|item| shown(item)).collect();
            format!("{says}{}.", items.join(", "))
        };
        let clauses: Vec<String> = self.clauses().iter().map(clause).collect();
        clauses.join(" ")
    }

    /// The verdict in one line without colours.
    pub fn to_text(&self) -> String {
        self.line(|item| item.text.clone())
    }
}

/// The measurements that a verdict judges.
#[derive(Clone, Debug)]
pub struct Measured<'m> {
    /// The duration of the rollout, s.
    pub seconds: f64,
    /// The displacement along the ground in this time, m; `None` if rollouts diverged. Of a delivered robot it is the
    /// median over robots that vary a little.
    pub displacement: Option<f64>,
    /// The 10 % and the 90 % quantile of its displacement across, m; `None` for a planar robot.
    pub across: Option<(f64, f64)>,
    /// The median displacement along the ground with [less friction](crate::judge::LOW_FRICTION), m; `None` if it is not known.
    pub low_friction: Option<f64>,
    /// The length of the robot, m.
    pub length: f64,
    /// True for a robot in the plane.
    pub is_planar: bool,
    /// True if feet may slip, so that the friction matters.
    pub slips: bool,
    /// Where and since when it stands still.
    pub standstill: Option<Standstill>,
    /// Whether the displacement describes the robot.
    pub reliability: &'m Reliability,
    /// True if the robot is designed to walk far.
    pub is_far: bool,
    /// For a robot with another task: its median loss, and that of the same robot while its muscles rest.
    pub losses: Option<(f64, f64)>,
    /// For a robot with given goals: the share that it leaves of its ways to them.
    pub way_left: Option<f64>,
    /// True for a design that is not a layout.
    pub is_undecided: bool,
    /// How the bars are connected.
    pub structure: Option<Structure>,
    /// The loads of the bars.
    pub loads: Option<&'m Loads>,
    /// The mass and the energy.
    pub energy: Option<Energy>,
    /// The loads and the energy at half the time step; `None` if they are not known.
    pub half_step: Option<HalfStep<'m>>,
    /// The number of bars.
    pub bars: usize,
    /// The shares of solid edges and of actuators.
    pub volumes: [f64; 2],
    /// The bounds on these shares at the end of an optimisation.
    pub bounds: VolumeBounds,
    /// The steep places of the ground ahead of the payload, counted from it at the start.
    pub risers: Vec<Riser>,
    /// The mass of all payloads, kg.
    pub payload: f64,
    /// The weight of the payload as a share of what actuators can lift at most.
    pub load: f64,
    /// The friction as a multiple of what holds a robot on the slope; `None` on level ground.
    pub friction_margin: Option<f64>,
    /// The largest target strain of a muscle.
    pub actuator_strain: f64,
    /// What the parts can do.
    pub sheet: DataSheet,
}

impl Measured<'_> {
    /// Judges the measurements. Loads and energy are judged at the time step at which they are worse.
    pub fn verdict(&self) -> Verdict {
        let loads = self.worse_loads();
        let worse = Measured {
            loads: loads.as_ref(),
            energy: self.worse_energy(),
            ..self.clone()
        };
        let figures = [
            self.speed(),
            self.passes(),
            self.objective(),
            self.mass(),
            self.carries(),
            worse.power(),
        ];
        let limits = [
            self.heading(),
            self.grip(),
            self.decided(),
            self.pieces(),
            worse.crossings(),
            worse.skeleton(),
            worse.muscle_strain(),
            worse.buckling(),
            self.at_half_step(),
        ];
        let items = figures.into_iter().chain(limits).flatten();
        Verdict {
            items: items
                .chain(worse.parts().into_iter().flatten())
                .chain(self.lacks())
                .chain(self.falls_over())
                .collect(),
            hints: self.hints(),
        }
    }

    /// Whether a robot with a task other than distance does something for it.
    fn objective(&self) -> Option<Item> {
        let (loss, idle) = self.losses?;
        let gain = idle - loss;
        let is_better = gain > LEAST_GAIN * loss.abs().max(idle.abs());
        let [loss, idle] = [loss, idle].map(|x| fixed(x, 4));
        let compared = match self.way_left {
            Some(left) => format!("leaves {} of the way to its goals", percent(left)),
            None => format!("loss {loss} ({idle} with muscles at rest)"),
        };
        Some(match is_better {
            true => Item::figure(compared, Level::Good),
            false => Item::figure(
                format!("no better for its objective than at rest: {compared}"),
                Level::Bad,
            ),
        })
    }

    fn mass(&self) -> Option<Item> {
        if self.is_undecided {
            return None;
        }
        Some(match self.energy {
            Some(energy) => Item::figure(mass(energy.mass), Level::Good),
            None => Item::figure("mass not known", Level::Doubtful),
        })
    }

    fn carries(&self) -> Option<Item> {
        let says = || Item::figure(format!("carries {}", mass(self.payload)), Level::Good);
        (self.payload > 0.0).then(says)
    }

    fn power(&self) -> Option<Item> {
        let energy = self.energy?;
        let (mass, power) = (energy.mass, energy.needed());
        let endurance = BATTERY * mass / power;
        let of_limit = format!(
            "{} of {} W/kg",
            brief(power / mass),
            brief(BATTERY / ENDURANCES[0])
        );
        let watts = brief(power);
        let air = energy.air.zip(energy.air_power).map(|(air, pressing)| {
            let litres = brief(6e4 * air);
            (litres, pressing >= energy.power)
        });
        let says = match air {
            None => format!("needs {watts} W ({of_limit})"),
            // Compressors lose about half of the power.
            Some((litres, true)) => format!(
                "needs {watts} W ({of_limit}) to press {litres} litres of air a minute (at 1 bar; about {} W with the \
                 losses of a compressor)",
                brief(2.0 * power)
            ),
            Some((litres, false)) => {
                format!(
                    "needs {watts} W ({of_limit}) and {litres} litres of air a minute (at 1 bar)"
                )
            }
        };
        // A robot that needs no power has an infinite endurance.
        Some(Item::figure(says, Level::from_on(ENDURANCES, endurance)))
    }

    fn decided(&self) -> Option<Item> {
        let says = "the materials of its edges are undecided";
        self.is_undecided.then(|| Item::limit(says, Level::Bad))
    }

    fn pieces(&self) -> Option<Item> {
        let pieces = self.structure?.pieces;
        Some(match pieces {
            1 => Item::limit("in one piece", Level::Good),
            0 => Item::limit("there are no bars", Level::Bad),
            _ => Item::limit(format!("it is in {pieces} pieces"), Level::Bad),
        })
    }

    fn crossings(&self) -> Option<Item> {
        let Loads {
            tangled,
            most_tangles,
            ..
        } = *self.loads?;
        if tangled == 0.0 {
            return Some(Item::limit("no bars pass through each other", Level::Good));
        }
        let pairs = match most_tangles {
            1 => "one pair at a time".to_owned(),
            pairs => format!("up to {pairs} pairs"),
        };
        let level = Level::up_to([0.0, BRUSHES], tangled);
        Some(Item::limit(
            format!("bars pass through each other ({pairs})"),
            level,
        ))
    }

    fn skeleton(&self) -> Option<Item> {
        let strain = self.loads?.skeleton_strain?;
        let says = format!("the skeleton stretches or shrinks by {}", percent(strain));
        Some(Item::limit(says, Level::up_to(SKELETON_STRAINS, strain)))
    }

    fn muscle_strain(&self) -> Option<Item> {
        let strain = self.loads?.strain.peak;
        let says = format!(
            "muscles move by {} (their stroke is {})",
            percent(strain),
            percent(self.actuator_strain)
        );
        let level = Level::up_to(STROKES.map(|limit| limit * self.actuator_strain), strain);
        (strain > 0.0).then(|| Item::limit(says, level))
    }

    fn buckling(&self) -> Option<Item> {
        let safety = self.loads?.euler_safety?;
        let says = match Level::from_on(EULER_SAFETIES, safety) {
            Level::Bad => format!("a bar buckles at {} of its load", percent(safety)),
            _ => format!("bars buckle at {} times their load", brief(safety)),
        };
        Some(Item::limit(says, Level::from_on(EULER_SAFETIES, safety)))
    }
}
