//! Gradients: error, time and memory of every way to compute one, over horizons.

mod sheet;
mod case_slopes;

use autodiff::DoubleDouble;
use rayon::prelude::*;

use super::chaos::Chaos;
use super::clock::measured;
use super::probe::{Probe, distance, most, norm};
use case_slopes::{CaseSlopes, DIRECTIONS};
use cosmic::case::Case;

/// The longest horizon, and the number of its halvings.
const LONGEST: usize = 4096;
const HALVINGS: u32 = 6;
/// Half-widths of central differences, along directions of length one.
const WIDTHS: [f64; 10] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10];
/// A full tape that would need more memory, in bytes, is left out with a note.
const MOST_MEMORY: u64 = 3 << 30;
/// A full tape and the driver round their sums in different orders: they may differ by this, or by as
/// much as both may be wrong.
const SAME: f64 = 1e-10;
/// Starts from which gradients are compared, and the perturbation of their coordinates, m.
const STARTS: usize = 8;
const MOVED: f64 = 1e-9;
/// The error of a gradient without two right digits. Beyond it nothing can be checked.
const WORTHLESS: f64 = 1e-2;

/// A way to a gradient.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Central differences in f64, of the half-width that is best for this horizon.
    Differences,
    /// Forward duals in f64, all directions at once.
    Duals,
    /// The same in f32.
    SingleDuals,
    /// The rollout driver in f64.
    Driver,
    /// The same in f32.
    SingleDriver,
    /// The driver in f64, a share of the last steps carrying the gradient: one in so many.
    Truncated(usize),
    /// A tape of every operation, in f64.
    FullTape,
}

impl Way {
    /// In the order in which they are measured: the tape, which holds the most memory, comes last.
    const ALL: [Self; 8] = [
        Self::Differences,
        Self::SingleDuals,
        Self::Duals,
        Self::SingleDriver,
        Self::Driver,
        Self::Truncated(2),
        Self::Truncated(4),
        Self::FullTape,
    ];

    /// The name in tables.
    pub fn name(self) -> String {
        match self {
            Self::Differences => "central differences, best h".to_owned(),
            Self::Duals => "forward duals f64".to_owned(),
            Self::SingleDuals => "forward duals f32".to_owned(),
            Self::Driver => "rollout driver f64".to_owned(),
            Self::SingleDriver => "rollout driver f32".to_owned(),
            Self::Truncated(share) => format!("driver, last 1/{share} of the steps"),
            Self::FullTape => "full tape f64".to_owned(),
        }
    }

    /// True if it gives the whole gradient at once.
    pub fn is_reverse(self) -> bool {
        !matches!(self, Self::Differences | Self::Duals | Self::SingleDuals)
    }

    fn is_single(self) -> bool {
        matches!(self, Self::SingleDuals | Self::SingleDriver)
    }

    /// True if it should be right but for rounding.
    fn is_exact(self) -> bool {
        matches!(self, Self::Duals | Self::Driver | Self::FullTape)
    }
}

/// One way over one horizon.
#[derive(Clone, Debug, PartialEq)]
pub struct Slopes {
    /// The way.
    pub way: Way,
    /// The horizon.
    pub steps: usize,
    /// Length of the error of the slopes along 8 directions over the length of the right ones.
    pub error: f64,
    /// Angle between the two vectors of slopes, degrees.
    pub angle: f64,
    /// Processor time, s: of the whole gradient, or of the 8 slopes.
    pub time: f64,
    /// The time of a whole gradient, s; where it would take many times 8 slopes, that multiple.
    pub whole: f64,
    /// Memory in addition to that held before, bytes; `None` if the system does not tell.
    pub memory: Option<u64>,
    /// True if it was left out because of its memory; `memory` is then an estimate.
    pub left_out: bool,
}

/// The gradients of a case in every way.
#[derive(Clone, Debug, PartialEq)]
pub struct Gradients {
    /// The horizons, ascending.
    pub horizons: Vec<usize>,
    /// Every way over every horizon.
    pub slopes: Vec<Slopes>,
    /// Errors of central differences: per half-width, per horizon.
    pub sweep: Vec<(f64, Vec<f64>)>,
    /// Largest difference of the driver's gradient and the full tape's over the latter's largest
    /// entry, per horizon for which there is a full tape.
    pub driver_against_tape: Vec<f64>,
    /// The most that the slopes change, as a share, where the start is moved by 1e-9 m, per
    /// horizon.
    pub moved: Vec<f64>,
    /// The largest distance of a node in f64 from that in double-double until each horizon, m.
    pub rounding: Vec<f64>,
    /// The count of numbers in the gradient.
    pub numbers: usize,
    /// How fast motions diverge.
    pub chaos: Chaos,
}

impl Gradients {
    /// Differentiates a case in every way. The truth is computed in parallel, run times and
    /// memory are measured alone.
    pub fn of(case: &Case) -> Self {
        let longest = LONGEST.min(case.physics.steps.max(1));
        let mut horizons: Vec<usize> = (0..=HALVINGS).rev().map(|k| longest >> k).collect();
        horizons.retain(|&steps| steps > 0);
        let mut case = case.clone();
        case.physics.steps = case.physics.steps.max(longest);
        let subject = CaseSlopes::new(&case);
        let truth = truth(&subject, &horizons);
        let errors = |&h: &f64| -> (f64, Vec<f64>) {
            let slopes = subject.differences(h, &horizons);
            let pairs = slopes.iter().zip(&truth);
            (h, pairs.map(|(s, t)| error(s, t)).collect())
        };
        let sweep = WIDTHS.par_iter().map(errors).collect();
        let mut found = Self {
            slopes: Vec::new(),
            driver_against_tape: Vec::new(),
            moved: moved(&case, &subject, &horizons),
            rounding: rounding(&case, &horizons),
            numbers: subject.numbers(),
            sweep,
            horizons,
            chaos: Chaos::of(&case),
        };
        for way in Way::ALL {
            for (k, truth) in truth.iter().enumerate() {
                found.take(&subject, way, k, truth);
            }
        }
        found
    }

    /// Adds the row of a way over the k-th horizon.
    fn take(&mut self, subject: &CaseSlopes, way: Way, k: usize, truth: &[f64; DIRECTIONS]) {
        let steps = self.horizons[k];
        let expected = self.expected_memory(way, steps);
        let left_out = way == Way::FullTape && expected > MOST_MEMORY;
        let (found, time, memory) = match way {
            _ if left_out => ([f64::NAN; DIRECTIONS], f64::NAN, Some(expected)),
            Way::Differences => {
                let (width, _) = best(&self.sweep, k);
                measured(|| subject.differences(width, &[steps])[0])
            }
            Way::Duals => measured(|| subject.duals::<f64, DIRECTIONS>(0, &[steps])[0]),
            Way::SingleDuals => {
                measured(|| subject.duals::<f32, DIRECTIONS>(0, &[steps])[0].map(f64::from))
            }
            Way::Driver => measured(|| subject.along(&subject.driver::<f64>(steps))),
            Way::SingleDriver => measured(|| {
                let gradient = subject.driver::<f32>(steps).into_iter().map(f64::from);
                subject.along(&gradient.collect::<Vec<_>>())
            }),
            Way::Truncated(share) => {
                measured(|| subject.along(&subject.truncated(steps, (steps / share).max(1))))
            }
            Way::FullTape => {
                let (gradient, time, memory) = measured(|| subject.full_tape::<f64>(steps));
                let off = difference(&subject.driver::<f64>(steps), &gradient);
                self.driver_against_tape.push(off);
                (subject.along(&gradient), time, memory)
            }
        };
        let multiple = if way.is_reverse() {
            1.0
        } else {
            subject.numbers() as f64 / DIRECTIONS as f64
        };
        self.slopes.push(Slopes {
            way,
            steps,
            error: error(&found, truth),
            angle: angle(&found, truth),
            time,
            whole: time * multiple,
            memory,
            left_out,
        });
    }

    /// Memory in proportion to that of the last horizon.
    fn expected_memory(&self, way: Way, steps: usize) -> u64 {
        let last = self.slopes.iter().rfind(|row| row.way == way);
        let each = |row: &Slopes| row.memory.unwrap_or(0) / row.steps as u64;
        last.map_or(0, |row| each(row) * steps as u64)
    }

    /// The largest error that rounding in f64 explains: 7 binary digits for the sums of a step and 7
    /// for sums over the steps. To this comes the change of the slopes with a start that is moved as
    /// far as rounding moves the motion, with 4 binary digits on top, because rounding acts on the way
    /// and not at the start.
    pub fn tolerance(&self, steps: usize) -> f64 {
        let horizon = self.horizons.iter().position(|at| *at == steps);
        horizon.map_or(f64::NAN, |k| {
            128.0 * 128.0 * f64::EPSILON + 16.0 * self.moved[k] / MOVED * self.rounding[k]
        })
    }

    /// True if the gradients of driver and full tape may differ this much over a horizon. If less than
    /// two digits are left they may differ in all.
    pub fn may_differ(&self, steps: usize, difference: f64) -> bool {
        let allowed = self.tolerance(steps);
        difference <= SAME.max(2.0 * allowed) || allowed >= WORTHLESS
    }

    /// True if a row can be checked: an exact way, while digits are left.
    pub fn is_checked(&self, row: &Slopes) -> bool {
        let exact = row.way.is_exact() && !row.left_out;
        exact && self.tolerance(row.steps) < WORTHLESS
    }

    /// True if a checked row is wrong.
    pub fn is_wrong(&self, row: &Slopes) -> bool {
        // A NaN is not right.
        let right = row.error <= self.tolerance(row.steps);
        self.is_checked(row) && !right
    }
}

/// Slopes by duals in double-double, per horizon.
fn truth(subject: &CaseSlopes, horizons: &[usize]) -> Vec<[f64; DIRECTIONS]> {
    const PART: usize = 4;
    let parts: Vec<Vec<[DoubleDouble; PART]>> = [0, PART]
        .par_iter()
        .map(|&first| subject.duals::<DoubleDouble, PART>(first, horizons))
        .collect();
    let slope = |k: usize, d: usize| parts[d / PART][k][d % PART].to_f64();
    let slopes = |k: usize| std::array::from_fn(|d| slope(k, d));
    (0..horizons.len()).map(slopes).collect()
}

/// The most that the slopes change, as a share, from one of the moved starts to the next.
fn moved(case: &Case, subject: &CaseSlopes, horizons: &[usize]) -> Vec<f64> {
    let slopes = |subject: &CaseSlopes| -> Vec<[f64; DIRECTIONS]> {
        let gradient = |&steps: &usize| subject.along(&subject.driver::<f64>(steps));
        horizons.iter().map(gradient).collect()
    };
    let here = slopes(subject);
    let starts = Probe::new(case).moved_starts(STARTS, MOVED);
    let there = starts.into_par_iter().map(|start| {
        let mut case = case.clone();
        case.start = start;
        slopes(&CaseSlopes::new(&case))
    });
    let there: Vec<_> = there.collect();
    let largest = |k: usize| {
        let changes = there.iter().map(|moved| error(&moved[k], &here[k]));
        changes.fold(0.0, f64::max)
    };
    (0..horizons.len()).map(largest).collect()
}

/// The largest distance of the motion in f64 from that in double-double until each horizon.
fn rounding(case: &Case, horizons: &[usize]) -> Vec<f64> {
    let probe = Probe::new(case);
    let last = horizons[horizons.len() - 1];
    let observed: Vec<usize> = (0..=last).collect();
    let wide = || probe.run::<DoubleDouble>(observed.clone());
    let double = || probe.run::<f64>(observed.clone());
    let (wide, double) = rayon::join(wide, double);
    let pairs = wide.states.iter().zip(&double.states);
    let apart: Vec<f64> = pairs.map(|(a, b)| distance(a, b)).collect();
    let largest = |&steps: &usize| apart[..=steps].iter().fold(0.0, |a: f64, &b| a.max(b));
    horizons.iter().map(largest).collect()
}

/// The half-width with the least error over a horizon, and that error.
fn best(sweep: &[(f64, Vec<f64>)], horizon: usize) -> (f64, f64) {
    let errors = sweep.iter().map(|(h, errors)| (*h, errors[horizon]));
    errors.fold((f64::NAN, f64::INFINITY), |best, new| {
        if new.1 < best.1 { new } else { best }
    })
}

fn error(slopes: &[f64; DIRECTIONS], truth: &[f64; DIRECTIONS]) -> f64 {
    let away: Vec<f64> = slopes.iter().zip(truth).map(|(s, t)| s - t).collect();
    let size = norm(truth);
    // If all slopes are zero, the error is absolute.
    norm(&away) / if size > 0.0 { size } else { 1.0 }
}

/// In degrees; small ones from the difference of the unit vectors, whose cosine would be 1.
fn angle(slopes: &[f64; DIRECTIONS], truth: &[f64; DIRECTIONS]) -> f64 {
    if slopes == truth {
        // Two vectors of zeros have no direction; their angle is 0 too.
        return 0.0;
    }
    let unit = |v: &[f64; DIRECTIONS]| v.map(|x| x / norm(v));
    let (a, b) = (unit(slopes), unit(truth));
    let apart: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    let half = 0.5 * norm(&apart);
    2.0 * half.clamp(0.0, 1.0).asin().to_degrees()
}

/// The largest difference of two gradients over the second's largest entry.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    let largest = b.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let size = if largest > 0.0 { largest } else { 1.0 };
    most(a.iter().zip(b).map(|(a, b)| (a - b).abs() / size))
}

#[cfg(test)]
mod tests;
