//! Gradients: error, time and memory of every way to compute one, over horizons.

mod sheet;
mod slopes;

use autodiff::DoubleDouble;
use rayon::prelude::*;

use super::chaos::Chaos;
use super::clock::measured;
use super::probe::{MOVED, Probe, distance, norm, relative_error};
use cosmic::case::Case;
pub use sheet::gradients;
use slopes::{DIRECTIONS, Slopes, Subject};

/// The longest horizon, and the number of its halvings.
const LONGEST: usize = 4096;
const HALVINGS: u32 = 6;
/// Half-widths of central differences, along directions of length one.
const WIDTHS: [f64; 10] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10];
/// A full tape that would need more memory, in bytes, is left out with a note.
const MOST_MEMORY: u64 = 3 << 30;
/// Starts from which gradients are compared.
const STARTS: usize = 8;
/// The error of a gradient without two right digits. Beyond it nothing can be checked.
const WORTHLESS: f64 = 1e-2;

/// What limits a gradient.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Limit {
    /// Only the rounding of f64.
    Rounding,
    /// The rounding of f32.
    Single,
    /// The half-width of differences.
    Width,
    /// Early steps are left out.
    Truncation,
}

/// A way to a gradient.
struct Way {
    name: &'static str,
    limit: Limit,
    /// The whole gradient over so many steps, or the slopes along all directions; differences take
    /// the half-width that is best for the horizon.
    run: fn(&Subject, usize, f64) -> Found,
}

enum Found {
    Gradient(Vec<f64>),
    Slopes(Slopes),
}

const fn way(name: &'static str, limit: Limit, run: fn(&Subject, usize, f64) -> Found) -> Way {
    Way { name, limit, run }
}

const DRIVER: usize = 4;
const FULL_TAPE: usize = 7;
/// In the order in which they are measured: the full tape, which holds the most memory, comes last.
static WAYS: [Way; 8] = [
    way(
        "central differences, best h",
        Limit::Width,
        |subject, steps, h| Found::Slopes(subject.differences(h, &[steps])[0]),
    ),
    way("forward duals f32", Limit::Single, |subject, steps, _| {
        let slopes = subject.duals::<f32, DIRECTIONS>(0, &[steps])[0];
        Found::Slopes(slopes.map(f64::from))
    }),
    way("forward duals f64", Limit::Rounding, |subject, steps, _| {
        Found::Slopes(subject.duals(0, &[steps])[0])
    }),
    way("rollout driver f32", Limit::Single, |subject, steps, _| {
        let single = subject.driver::<f32>(steps).into_iter();
        Found::Gradient(single.map(f64::from).collect())
    }),
    way(
        "rollout driver f64",
        Limit::Rounding,
        |subject, steps, _| Found::Gradient(subject.driver(steps)),
    ),
    way(
        "driver, last 1/2 of the steps",
        Limit::Truncation,
        |subject, steps, _| Found::Gradient(subject.truncated(steps, (steps / 2).max(1))),
    ),
    way(
        "driver, last 1/4 of the steps",
        Limit::Truncation,
        |subject, steps, _| Found::Gradient(subject.truncated(steps, (steps / 4).max(1))),
    ),
    way("full tape f64", Limit::Rounding, |subject, steps, _| {
        Found::Gradient(subject.full_tape(steps))
    }),
];

/// A way over a horizon.
#[derive(Debug)]
struct Row {
    /// An index of [`WAYS`].
    way: usize,
    steps: usize,
    /// Length of the error of the slopes along the directions over the length of the right ones.
    error: f64,
    /// The error that rounding explains in an exact way in f64.
    allowed: f64,
    /// Angle between the two vectors of slopes, degrees.
    angle: f64,
    /// Processor time, s: of the whole gradient, or of the slopes.
    time: f64,
    /// The time of a whole gradient, s: a multiple of `time` if that is for the slopes.
    whole: f64,
    /// Memory in addition to that held before, bytes; `None` if the system does not tell.
    memory: Option<u64>,
    /// True if it was left out because of its memory; `memory` is then an estimate.
    left_out: bool,
}

/// The gradients of a case: every way over every horizon.
struct Gradients {
    rows: Vec<Row>,
    /// The count of numbers in the gradient.
    numbers: usize,
    chaos: Chaos,
}

/// A horizon, the right slopes over it, and what is known of the errors.
struct Horizon {
    steps: usize,
    truth: Slopes,
    /// The error that rounding explains in an exact way in f64.
    allowed: f64,
    /// The half-width with which central differences are best.
    width: f64,
}

impl Gradients {
    /// Differentiates a case in every way. The truth is computed in parallel, run times and
    /// memory are measured alone.
    fn of(case: &Case) -> Self {
        let longest = LONGEST.min(case.physics.steps.max(1));
        let mut case = case.clone();
        case.physics.steps = case.physics.steps.max(longest);
        let subject = Subject::new(&case);
        let horizons = horizons(&case, &subject, longest);
        let mut rows = Vec::new();
        for way in 0..WAYS.len() {
            for horizon in &horizons {
                rows.push(row(&subject, way, horizon, rows.last()));
            }
        }
        Self {
            rows,
            numbers: subject.numbers(),
            chaos: Chaos::of(&case),
        }
    }
}

/// Measures a way over a horizon; `last` is the row before, of the same way if there is one.
fn row(subject: &Subject, way: usize, horizon: &Horizon, last: Option<&Row>) -> Row {
    let (steps, truth) = (horizon.steps, &horizon.truth);
    // Memory in proportion to that of the last horizon.
    let last = last.filter(|row| row.way == way);
    let each = |row: &Row| row.memory.unwrap_or(0) / row.steps as u64;
    let expected = last.map_or(0, |row| each(row) * steps as u64);
    let left_out = way == FULL_TAPE && expected > MOST_MEMORY;
    let (found, time, memory) = if left_out {
        (
            Found::Slopes([f64::NAN; DIRECTIONS]),
            f64::NAN,
            Some(expected),
        )
    } else {
        measured(|| (WAYS[way].run)(subject, steps, horizon.width))
    };
    let (slopes, times) = match &found {
        Found::Gradient(gradient) => (subject.along(gradient), 1.0),
        Found::Slopes(slopes) => (*slopes, subject.numbers() as f64 / DIRECTIONS as f64),
    };
    Row {
        way,
        steps,
        error: relative_error(&slopes, truth),
        allowed: horizon.allowed,
        angle: angle(&slopes, truth),
        time,
        whole: time * times,
        memory,
        left_out,
    }
}

impl Row {
    /// True if the row can be checked: it is limited by the rounding of f64, and digits are left.
    fn is_checked(&self) -> bool {
        let exact = WAYS[self.way].limit == Limit::Rounding && !self.left_out;
        exact && self.allowed < WORTHLESS
    }

    /// True if a checked row is wrong.
    fn is_wrong(&self) -> bool {
        // A NaN is not right.
        let right = self.error <= self.allowed;
        self.is_checked() && !right
    }
}

/// The horizons up to the longest, ascending. Rounding in f64 explains an error of 7 binary digits for the
/// sums of a step and 7 for sums over the steps. To this comes the change of the slopes with a start that is
/// moved as far as rounding moves the motion, with 4 binary digits on top, because rounding acts on the way
/// and not at the start.
fn horizons(case: &Case, subject: &Subject, longest: usize) -> Vec<Horizon> {
    let mut steps: Vec<usize> = (0..=HALVINGS).rev().map(|k| longest >> k).collect();
    steps.retain(|&steps| steps > 0);
    let truth = truth(subject, &steps);
    let sweep: Vec<(f64, Vec<Slopes>)> = WIDTHS
        .par_iter()
        .map(|&h| (h, subject.differences(h, &steps)))
        .collect();
    let (moved, rounding) = (moved(case, subject, &steps), rounding(case, &steps));
    let horizon = |(k, &steps): (usize, &usize)| {
        let errors = sweep
            .iter()
            .map(|(h, slopes)| (*h, relative_error(&slopes[k], &truth[k])));
        let better = |best: (f64, f64), new: (f64, f64)| if new.1 < best.1 { new } else { best };
        Horizon {
            steps,
            truth: truth[k],
            allowed: 128.0 * 128.0 * f64::EPSILON + 16.0 * moved[k] / MOVED * rounding[k],
            width: errors.fold((WIDTHS[0], f64::INFINITY), better).0,
        }
    };
    steps.iter().enumerate().map(horizon).collect()
}

/// Slopes by duals in double-double, per horizon.
fn truth(subject: &Subject, horizons: &[usize]) -> Vec<Slopes> {
    const PART: usize = 4;
    let parts: Vec<Vec<[DoubleDouble; PART]>> = [0, PART]
        .par_iter()
        .map(|&first| subject.duals(first, horizons))
        .collect();
    let slope = |k: usize, d: usize| parts[d / PART][k][d % PART].to_f64();
    let slopes = |k: usize| std::array::from_fn(|d| slope(k, d));
    (0..horizons.len()).map(slopes).collect()
}

/// The most that the slopes change, as a share, from the case's start to one of the moved starts.
fn moved(case: &Case, subject: &Subject, horizons: &[usize]) -> Vec<f64> {
    let slopes = |subject: &Subject| -> Vec<Slopes> {
        let gradient = |&steps: &usize| subject.along(&subject.driver::<f64>(steps));
        horizons.iter().map(gradient).collect()
    };
    let here = slopes(subject);
    let starts = Probe::new(case).moved_starts(STARTS);
    let there = starts.into_par_iter().map(|start| {
        let mut case = case.clone();
        case.start = start;
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

/// The largest distance of the motion in f64 from that in double-double until each horizon.
fn rounding(case: &Case, horizons: &[usize]) -> Vec<f64> {
    let probe = Probe::new(case);
    let observed: Vec<usize> = (0..=horizons[horizons.len() - 1]).collect();
    let wide = || probe.run::<DoubleDouble>(observed.clone());
    let double = || probe.run::<f64>(observed.clone());
    let (wide, double) = rayon::join(wide, double);
    let pairs = wide.states.iter().zip(&double.states);
    let apart: Vec<f64> = pairs.map(|(a, b)| distance(a, b)).collect();
    let largest = |&steps: &usize| apart[..=steps].iter().fold(0.0, |a: f64, &b| a.max(b));
    horizons.iter().map(largest).collect()
}

/// In degrees; small ones from the difference of the unit vectors, whose cosine would be 1.
fn angle(slopes: &Slopes, truth: &Slopes) -> f64 {
    if slopes == truth {
        // Two vectors of zeros have no direction; their angle is 0 too.
        return 0.0;
    }
    let unit = |v: &Slopes| v.map(|x| x / norm(v));
    let half = 0.5 * relative_error(&unit(slopes), &unit(truth));
    2.0 * half.clamp(0.0, 1.0).asin().to_degrees()
}

#[cfg(test)]
mod tests;
