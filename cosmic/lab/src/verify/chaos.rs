//! Measures how fast neighbouring motions diverge. After that time, the error at a single time has no meaning.

use rayon::prelude::*;

use super::probe::{MOVED, Probe, distance};
use crate::table::{Standing, Table};
use cosmic::case::Case;
use cosmic::codesign::Quantiles;
use cosmic::lattice::State;
use cosmic::task::together;

/// The number of perturbed starts. The motion from each perturbed start is compared with the motion from the
/// unperturbed start.
const STARTS: usize = 16;
/// If two motions are farther apart than this distance, in metres, their difference no longer counts as a small
/// perturbation.
const PARTED: f64 = 1e-4;
/// The distance between two motions is measured whenever this number of steps is done.
const EVERY: usize = 8;
/// The number of binary digits that are lost at once, before a perturbation has doubled. The sums of some hundred terms
/// in a step and the curvature of contact cause this loss.
const SPENT: u32 = 7;

/// How the motions of a case diverge if its start is perturbed.
#[derive(Debug)]
pub struct Chaos {
    /// The number of steps in which a small perturbation doubles: the median over the perturbed starts. Infinite if it
    /// does not double once in the whole rollout.
    pub doubling: f64,
    /// The time step, s.
    dt: f64,
    /// The largest growth of a perturbation, as pairs: a number of steps, and the largest factor by which the
    /// perturbation of any start has grown until then. The factor may be large even if nothing grows in the long run,
    /// because contacts stretch some directions for a while. The list ends when a perturbation is no longer small.
    pub grown: Vec<(usize, f64)>,
    steps: usize,
    /// The quantiles of the displacement along the ground after all steps, over the perturbed starts, in metres.
    pub spread: Quantiles,
    /// The displacement from the unperturbed start, in metres.
    unmoved: f64,
}

impl Chaos {
    /// Simulates a case from its own start and from the perturbed starts.
    pub fn of(case: &Case) -> Self {
        let (probe, steps) = (Probe::new(case), case.physics.steps);
        let mut observed: Vec<usize> = (0..steps).step_by(EVERY).collect();
        observed.push(steps);
        let run = |starts: &[_]| probe.run_batch(starts, &observed);
        let unmoved = run(std::slice::from_ref(&case.start)).remove(0);
        let starts = probe.moved_starts(STARTS);
        let groups = starts.par_chunks(together(STARTS));
        let moved = groups.map(run).collect::<Vec<_>>().concat();
        let reach = |states: &Vec<State<f64>>| {
            let (first, last) = (states[0].x[0], states[states.len() - 1].x[0]);
            probe.task.ground().along(last - first)
        };
        let distances = |states: &Vec<State<f64>>| {
            let pairs = states.iter().zip(&unmoved);
            pairs.map(|(a, b)| distance(a, b)).collect()
        };
        let parting: Vec<Vec<f64>> = moved.iter().map(distances).collect();
        let rates: Vec<f64> = parting.iter().map(|d| growth_rate(&observed, d)).collect();
        let rate = Quantiles::of(&rates).p50;
        let doubles = rate * steps as f64 >= 1.0;
        let reached: Vec<f64> = moved.iter().map(reach).collect();
        Self {
            doubling: if doubles { 1.0 / rate } else { f64::INFINITY },
            dt: case.physics.dt,
            grown: largest_growth(&observed, &parting),
            steps,
            spread: Quantiles::of(&reached),
            unmoved: reach(&unmoved),
        }
    }

    /// Estimates the factor by which a perturbation has grown after `steps` steps: the growth at the last measurement
    /// before that, continued at the mean rate.
    pub fn growth(&self, steps: usize) -> f64 {
        let seen = self.grown.iter().take_while(|(at, _)| *at <= steps);
        let (at, grown) = seen.last().copied().unwrap_or((0, 1.0));
        grown * ((steps - at) as f64 / self.doubling).exp2()
    }

    /// The note about chaos for the page, which comes before the tables.
    pub fn note(&self) -> String {
        if self.doubling.is_infinite() {
            let most = self.grown.last().map_or(1.0, |(_, grown)| *grown);
            return format!(
                "Chaos: small perturbations of this design do not double once in the whole rollout. \
                 At its largest, a perturbation is {most:.0} times its initial size."
            );
        }
        // The number of steps after which rounding has destroyed all binary digits of a number type.
        let horizon = |digits: u32| f64::from(digits - SPENT) * self.doubling;
        let [double, single] = [f64::MANTISSA_DIGITS, f32::MANTISSA_DIGITS].map(horizon);
        let [doubling, double_s, single_s] =
            [self.doubling, double, single].map(|steps| steps * self.dt);
        format!(
            "Chaos: a small perturbation of this design doubles every {:.0} steps ({doubling:.3} s). \
             Beyond {double:.0} steps ({double_s:.2} s) in f64, and {single:.0} steps \
             ({single_s:.2} s) in f32, every digit is lost to rounding and errors at single times mean \
             nothing. The spread over perturbed starts still has a meaning.",
            self.doubling,
        )
    }

    /// The table with the displacement from the unperturbed start and the quantiles over the perturbed starts.
    pub(super) fn table(&self) -> Table {
        let title = format!(
            "Displacement along the ground from {STARTS} starts, each moved by {MOVED:e} m"
        );
        let Quantiles { p10, p50, p90 } = self.spread;
        let is_finite = p10.is_finite() && self.unmoved.is_finite();
        Table::of("spread", &title, &[()])
            .column("steps", "steps of the whole rollout", |()| self.steps)
            .column(
                "unmoved_m",
                "displacement from the unperturbed start",
                |()| self.unmoved,
            )
            .column("p10_m", "10 % quantile", |()| p10)
            .column(
                "median_m",
                "median displacement: the figure to quote",
                |()| p50,
            )
            .column("p90_m", "90 % quantile", |()| p90)
            .mark(Standing::Failed, |()| !is_finite)
            .done()
    }
}

/// Returns the growth of perturbations as pairs: a step, and the largest growth of any distance until then. The list
/// ends when a distance is no longer small. `parting` has a list of distances for each perturbed start.
pub fn largest_growth(steps: &[usize], parting: &[Vec<f64>]) -> Vec<(usize, f64)> {
    let mut most: f64 = 1.0;
    let mut grown = Vec::new();
    for (k, &at) in steps.iter().enumerate() {
        let apart = parting.iter().map(|distances| distances[k]);
        if !apart.clone().all(|d| d < PARTED) {
            break;
        }
        most = most.max(apart.fold(0.0, f64::max) / parting[0][0]);
        grown.push((at, most));
    }
    grown
}

/// Returns the number of doublings per step: the slope of the line that fits the logarithms of the distances best, as
/// long as the distances are small. Returns 0 for fewer than two distances. In the first steps a perturbation still
/// turns towards the directions that grow; these steps are few, so they are included.
pub fn growth_rate(steps: &[usize], distances: &[f64]) -> f64 {
    let small = distances.iter().take_while(|&&d| d < PARTED);
    // If motions agree to the last bit, their distance is taken to be one rounding error.
    let logs: Vec<f64> = small.map(|d| d.max(f64::EPSILON).log2()).collect();
    if logs.len() < 2 {
        return 0.0;
    }
    let steps: Vec<f64> = steps[..logs.len()].iter().map(|&n| n as f64).collect();
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
    let (at, of) = (mean(&steps), mean(&logs));
    let moment = |x: &[f64], mean: f64| -> f64 {
        let product = |(n, x): (&f64, &f64)| (n - at) * (x - mean);
        steps.iter().zip(x).map(product).sum()
    };
    moment(&logs, of) / moment(&steps, at)
}
