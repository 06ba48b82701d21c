//! Measures the error, time and memory of every way to compute a gradient, over rollouts of different lengths
//! (horizons).

use autodiff::DoubleDouble;
use rayon::prelude::*;

use super::chaos::Chaos;
use super::clock::measured;
use super::gradcheck::{Moved, in_motion};
use super::probe::{Probe, distance, most, norm, relative_error};
use super::subject::{DIRECTIONS, Slopes, Subject};
use crate::report::chart::{Line, LogChart};
use crate::report::sheet::Section;
use crate::table::{Standing, Table};
use cosmic::case::Case;
use cosmic::geometry::Vector;

/// The longest horizon in steps.
const LONGEST: usize = 4096;
/// The longest horizon is halved this many times to get the shorter horizons.
const HALVINGS: u32 = 6;
/// The payload must have a gradient over this many steps; otherwise the robot is moved so that it has one.
const MOTION: usize = 256;
/// The half-widths of central differences to try. A half-width is the distance by which the inputs are moved along a
/// direction of length 1.
const WIDTHS: [f64; 10] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10];
/// The half-width of the central differences in double-double that give the true slopes. The rounding error of these
/// slopes is 1e-32 divided by the half-width, and their truncation error is the square of the half-width. The motion
/// magnifies both errors.
const TINY: f64 = 1e-15;
/// The largest memory for a full tape, in bytes. A tape that would need more is not computed, and its row says so.
const MOST_MEMORY: u64 = 3 << 30;
/// The slopes at this many slightly moved starts are compared with the slopes at the case's own start.
const STARTS: usize = 8;
/// A gradient with a larger relative error than this does not have two correct digits. A row is not checked if rounding
/// alone may cause such an error.
const WORTHLESS: f64 = 1e-2;

/// The main source of a gradient's error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// The rounding of f64.
    Rounding,
    /// The rounding of f32.
    Single,
    /// The error of central differences: rounding if the half-width is too small, curvature if it is too large.
    Width,
    /// The gradient leaves out the early steps of the rollout.
    Truncation,
}

/// A method of computing a gradient.
pub struct Way {
    /// The name.
    pub name: &'static str,
    /// The main source of its error.
    pub limit: Limit,
    /// The function that computes the gradient. It computes either the whole gradient over a horizon, or only the
    /// slopes along the directions of the subject.
    run: fn(&Subject, &Horizon) -> Found,
}

enum Found {
    Gradient(Vec<f64>),
    Slopes(Slopes),
}

const fn way(name: &'static str, limit: Limit, run: fn(&Subject, &Horizon) -> Found) -> Way {
    Way { name, limit, run }
}

/// The index of the way that the program itself uses.
pub const DRIVER: usize = 3;
const FULL_TAPE: usize = 6;
/// All methods of computing a gradient, in the order in which they are measured. The full tape comes last because it
/// holds the most memory.
pub static WAYS: [Way; 7] = [
    way(
        "central differences, best h",
        Limit::Width,
        |subject, of| Found::Slopes(subject.differences(of.width, &[of.steps])[0]),
    ),
    way("forward duals f64", Limit::Rounding, |subject, of| {
        Found::Slopes(subject.duals(of.steps))
    }),
    way("rollout driver f32", Limit::Single, |subject, of| {
        let single = subject.driver::<f32>(of.steps).into_iter();
        Found::Gradient(single.map(f64::from).collect())
    }),
    way("rollout driver f64", Limit::Rounding, |subject, of| {
        Found::Gradient(subject.driver(of.steps))
    }),
    way(
        "driver, last 1/2 of the steps",
        Limit::Truncation,
        |subject, of| Found::Gradient(subject.truncated(of.steps, of.steps.div_ceil(2))),
    ),
    way(
        "driver, last 1/4 of the steps",
        Limit::Truncation,
        |subject, of| Found::Gradient(subject.truncated(of.steps, of.steps.div_ceil(4))),
    ),
    way("full tape f64", Limit::Rounding, |subject, of| {
        Found::Gradient(subject.full_tape(of.steps))
    }),
];

/// The measurement of one method over one horizon.
#[derive(Debug)]
pub struct Row {
    /// The index of the method in [`WAYS`].
    pub way: usize,
    /// The number of steps of the horizon.
    pub steps: usize,
    /// The relative error of the slopes along all directions: the norm of the error vector divided by the norm of the
    /// true slopes.
    pub error: f64,
    /// The largest error that the rounding of f64 can explain for an exact method.
    allowed: f64,
    /// The angle between the vector of computed slopes and the vector of true slopes, in degrees.
    angle: f64,
    /// The processor time in seconds that the method takes for its result: the whole gradient, or only the slopes.
    time: f64,
    /// The processor time in seconds for a whole gradient. If the method computes only slopes, this is extrapolated.
    whole: f64,
    /// The memory that the method needs, in bytes; `None` if the operating system does not report it.
    memory: Option<u64>,
    /// True if the method was not run because it needs too much memory. Then `memory` is an estimate.
    left_out: bool,
}

impl Row {
    /// Measures one method over one horizon. `last` is the row measured before, possibly of another method.
    fn new(subject: &Subject, way: usize, horizon: &Horizon, last: Option<&Self>) -> Self {
        let steps = horizon.steps;
        // The memory is estimated from the previous horizon: it grows in proportion to the number of steps.
        let last = last.filter(|row| row.way == way);
        let expected = last.map_or(0, |row| {
            row.memory.unwrap_or(0) / row.steps as u64 * steps as u64
        });
        let left_out = way == FULL_TAPE && expected > MOST_MEMORY;
        let (found, time, memory) = match left_out {
            true => {
                let nothing = Found::Slopes([f64::NAN; DIRECTIONS]);
                (nothing, f64::NAN, Some(expected))
            }
            false => measured(|| (WAYS[way].run)(subject, horizon)),
        };
        let (slopes, times) = match &found {
            Found::Gradient(gradient) => (subject.along(gradient), 1.0),
            Found::Slopes(slopes) => (*slopes, subject.numbers() as f64 / DIRECTIONS as f64),
        };
        Self {
            way,
            steps,
            error: relative_error(&slopes, &horizon.truth),
            allowed: horizon.allowed,
            angle: angle(&slopes, &horizon.truth),
            time,
            whole: time * times,
            memory,
            left_out,
        }
    }

    /// True if the row can be checked: its error comes only from the rounding of f64, and two digits or more should be
    /// correct.
    fn is_checked(&self) -> bool {
        let exact = WAYS[self.way].limit == Limit::Rounding && !self.left_out;
        exact && self.allowed < WORTHLESS
    }

    /// True if the row is checked, and its error is too large or NaN.
    fn is_wrong(&self) -> bool {
        let right = self.error <= self.allowed;
        self.is_checked() && !right
    }

    /// The outcome of the row in a few words.
    fn status(&self) -> &'static str {
        match WAYS[self.way].limit {
            _ if self.left_out => "left out: too much memory",
            _ if !self.error.is_finite() => "failed: not finite",
            _ if self.is_wrong() => "failed: wrong",
            _ if self.is_checked() => "checked",
            Limit::Truncation if self.angle > 90.0 => "useless: points away from the gradient",
            Limit::Truncation => "truncated",
            _ if self.error > WORTHLESS => "useless: fewer than two correct digits",
            _ => "ok",
        }
    }
}

/// The length of a rollout in steps, with the true slopes over these steps and the errors to expect.
struct Horizon {
    steps: usize,
    truth: Slopes,
    /// The largest error that the rounding of f64 can explain for an exact method.
    allowed: f64,
    /// The half-width for which central differences have the smallest error.
    width: f64,
}

impl Horizon {
    /// Returns all horizons up to the longest, in ascending order. The error that rounding explains is the sum of two
    /// parts:
    ///
    /// - The sums in a step and the sums over the steps may each lose 7 binary digits.
    /// - Rounding changes the motion, and thereby the slopes. This change is estimated by moving the start as far as
    ///   rounding moves the motion. It is allowed 4 more binary digits, because rounding acts during the motion and not
    ///   at the start.
    fn all(case: &Case, subject: &Subject, longest: usize) -> Vec<Self> {
        let mut steps: Vec<usize> = (0..=HALVINGS).rev().map(|k| longest >> k).collect();
        steps.retain(|&steps| steps > 0);
        let truth = subject.truth(TINY, &steps);
        let sweep = WIDTHS
            .par_iter()
            .map(|&h| (h, subject.differences(h, &steps)));
        let sweep: Vec<(f64, Vec<Slopes>)> = sweep.collect();
        let (moved, rounding) = (moved(case, subject, &steps), rounding(case, &steps));
        let moved_by = subject.probe.moved_by();
        let horizon = |k: usize| {
            let errors = sweep
                .iter()
                .map(|(h, slopes)| (*h, relative_error(&slopes[k], &truth[k])));
            let better =
                |best: (f64, f64), new: (f64, f64)| if new.1 < best.1 { new } else { best };
            Self {
                steps: steps[k],
                truth: truth[k],
                allowed: 128.0 * 128.0 * f64::EPSILON + 16.0 * moved[k] / moved_by * rounding[k],
                width: errors.fold((WIDTHS[0], f64::INFINITY), better).0,
            }
        };
        (0..steps.len()).map(horizon).collect()
    }
}

/// Returns, for each horizon, the largest relative change of the slopes when the case begins at one of the moved
/// starts.
fn moved(case: &Case, subject: &Subject, horizons: &[usize]) -> Vec<f64> {
    let slopes = |subject: &Subject| -> Vec<Slopes> {
        let gradient = |&steps: &usize| subject.along(&subject.driver::<f64>(steps));
        horizons.iter().map(gradient).collect()
    };
    let here = slopes(subject);
    let starts = Probe::new(case).moved_starts(STARTS);
    let there = starts.into_par_iter().map(|start| {
        let case = Case {
            start,
            ..case.clone()
        };
        slopes(&Subject::new(&case))
    });
    let there: Vec<_> = there.collect();
    let largest = |k: usize| {
        let changes = there
            .iter()
            .map(|moved| relative_error(&moved[k], &here[k]));
        changes.fold(0.0, f64::max)
    };
    (0..horizons.len()).map(largest).collect()
}

/// Returns, for each horizon, the largest distance between the motions in f64 and in double-double up to its end, in
/// metres.
fn rounding(case: &Case, horizons: &[usize]) -> Vec<f64> {
    let probe = Probe::new(case);
    let observed: Vec<usize> = (0..=horizons[horizons.len() - 1]).collect();
    let (wide, double) = rayon::join(
        || probe.run::<DoubleDouble>(&observed),
        || probe.run::<f64>(&observed),
    );
    let apart: Vec<f64> = wide
        .iter()
        .zip(&double)
        .map(|(a, b)| distance(a, b))
        .collect();
    let largest = |&steps: &usize| most(apart[..=steps].iter().copied());
    horizons.iter().map(largest).collect()
}

/// Returns the angle between two vectors of slopes, in degrees. A small angle is computed from the difference of the
/// unit vectors, because its cosine would round to 1.
pub fn angle(slopes: &Slopes, truth: &Slopes) -> f64 {
    if slopes == truth {
        // A vector of zeros has no direction. If both vectors are zero, the angle counts as 0.
        return 0.0;
    }
    let unit = |v: &Slopes| v.map(|x| x / norm(v));
    let half = 0.5 * relative_error(&unit(slopes), &unit(truth));
    2.0 * half.clamp(0.0, 1.0).asin().to_degrees()
}

/// The measurements of every method of computing the gradient, over every horizon.
pub struct Gradients {
    /// The measurements of every way over every horizon, in the order of [`WAYS`].
    pub rows: Vec<Row>,
    /// The number of entries of the gradient.
    numbers: usize,
    /// How the robot differs from that of the case. A robot that stands still has no gradient to compare.
    moved: Moved,
    chaos: Chaos,
}

/// Computes the gradient of a case by every method and reports the errors. Checks the methods whose error comes only
/// from rounding.
pub fn gradients(case: &Case) -> Section {
    Gradients::of(case).section()
}

impl Gradients {
    /// Computes the gradient of a case by every method. The true slopes are computed in parallel; run times and memory
    /// are measured while nothing else runs.
    pub fn of(case: &Case) -> Self {
        let longest = LONGEST.min(case.physics.steps.max(1));
        let (moved, mut case) = in_motion(case, longest.min(MOTION));
        case.physics.steps = case.physics.steps.max(longest);
        let subject = Subject::new(&case);
        let horizons = Horizon::all(&case, &subject, longest);
        let mut rows = Vec::new();
        for way in 0..WAYS.len() {
            for horizon in &horizons {
                rows.push(Row::new(&subject, way, horizon, rows.last()));
            }
        }
        Self {
            rows,
            numbers: subject.numbers(),
            moved,
            chaos: Chaos::of(&case),
        }
    }

    /// The tables and figures of the measurements, with the checks that failed.
    pub fn section(&self) -> Section {
        let longest = self.rows.iter().rfind(|row| row.way == DRIVER);
        let by_time = |row: &Row| Vector::new([row.whole, row.error]);
        let figure = |name: &str,
                      along: &str,
                      caption: &str,
                      point: &dyn Fn(&Row) -> Vector<f64>| LogChart {
            name: String::from(name),
            caption: caption.to_owned(),
            title: "Relative error of the slopes".to_owned(),
            along: along.to_owned(),
            lines: self.lines(point),
            marked: None,
        };
        let mut section = Section {
            title: "Gradients".to_owned(),
            notes: self.notes(),
            tables: vec![self.table(), self.chaos.table()],
            figures: vec![
                figure(
                    "gradient_error",
                    "steps of the horizon",
                    "Error against the horizon.",
                    &|row| Vector::new([row.steps as f64, row.error]),
                ),
                figure(
                    "gradient_time",
                    "time of a whole gradient, s",
                    "Error against the time of a whole gradient; along each line the horizon doubles.",
                    &by_time,
                ),
            ],
            ..Section::default()
        };
        section.figures[1].marked =
            longest.map(|row| (by_time(row), format!("driver, {} steps", row.steps)));
        for row in self.rows.iter().filter(|row| row.is_checked()) {
            let failure = format!("{} over {} steps", WAYS[row.way].name, row.steps);
            section.check(!row.is_wrong(), failure);
        }
        section
    }

    fn notes(&self) -> Vec<String> {
        vec![
            self.chaos.note(),
            format!(
                "Gradients of minus the payload's position along the ground after `steps` steps, for \
                 the {} numbers of design and controller of {}. `error` and `angle` compare the slopes along \
                 {DIRECTIONS} random directions with differences in double-double. Until the payload \
                 moves, the gradient and its error are exactly zero.",
                self.numbers, self.moved
            ),
            format!(
                "`time`: processor time of one thread, for a whole gradient in reverse mode, for \
                 {DIRECTIONS} slopes in forward mode and by differences. `whole`: for a whole gradient; \
                 in forward mode and by differences it is extrapolated from the slopes. `memory`: the \
                 largest amount held in addition to what the program held before; do not trust numbers \
                 below 1 MiB."
            ),
            format!(
                "Exact methods are compared with the true slopes if rounding leaves them two correct \
                 digits. `allowed` is the error that rounding explains: 128 x 128 roundings, plus 16 \
                 times the change of the slopes if the start is moved as far as rounding moves the \
                 motion. A full tape that would take more than {} GiB is left out.",
                MOST_MEMORY >> 30
            ),
            "Truncated gradients leave out the early steps. This causes their error, not rounding."
                .to_owned(),
        ]
    }

    fn table(&self) -> Table {
        let title = "Error, time and memory over horizons";
        let (angle, whole) = (
            "angle between the two vectors of slopes",
            "time of a whole gradient",
        );
        let error = "norm of the error of the slopes divided by the norm of the slopes";
        let allowed = "the largest error that rounding explains for an exact method in f64";
        let memory = "peak memory that the method adds";
        let known = |row: &Row, x: f64| (!row.left_out).then_some(x);
        let is_failed = |row: &Row| row.status().starts_with("failed");
        let mebibytes = |bytes: u64| bytes as f64 / f64::from(1 << 20);
        let way = |row: &Row| WAYS[row.way].name;
        Table::of("gradients", title, &self.rows)
            .column("way", "how the gradient is computed", way)
            .column("steps", "steps of the horizon", |row| row.steps)
            .column("error", error, |row| known(row, row.error))
            .column("allowed", allowed, |row| row.allowed)
            .column("angle_deg", angle, |row| known(row, row.angle))
            .column("time_s", "processor time", |row| known(row, row.time))
            .column("whole_s", whole, |row| known(row, row.whole))
            .column("memory_mib", memory, |row| row.memory.map(mebibytes))
            .column("status", "the outcome", |row| row.status())
            .mark(Standing::Default, |row| row.way == DRIVER)
            .mark(Standing::Failed, is_failed)
            .done()
    }

    /// The lines of a figure: one line for every method of computing a gradient. `point` returns the point that stands
    /// for a row.
    fn lines(&self, point: &dyn Fn(&Row) -> Vector<f64>) -> Vec<Line> {
        let line = |(k, way): (usize, &Way)| {
            let dashes = match way.limit {
                Limit::Truncation => "1 5",
                Limit::Single => "6 4",
                _ => "",
            };
            let rows = self.rows.iter().filter(|row| row.way == k);
            Line::new(way.name.to_owned(), k, dashes, rows.map(point))
        };
        WAYS.iter().enumerate().map(line).collect()
    }
}
