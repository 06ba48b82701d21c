//! The question of an engineer: does the distance depend on the time step, the integrator or the precision?

use autodiff::Real;
use rayon::prelude::*;

use super::accuracy::Method;
use super::probe::{Probe, largest_stable_step, moved_starts};
use crate::report::sheet::{Chart, Line, Section};
use crate::table::{Cell, Emphasis, Table};
use cosmic::case::Case;
use cosmic::judge::verdict::{Item, Level};
use cosmic::judge::{LEAST_MEDIAN, Quantiles, STEADY};
use cosmic::lattice::State;
use cosmic::numbers::{brief, fixed};
use cosmic::world::together;

/// The number of perturbed starts. Single distances of a chaotic robot differ with every change; their median does not.
const STARTS: usize = 16;
/// The time steps to compare, as shares of the scene's time step.
const FRACTIONS: [f64; 4] = [1.0, 0.5, 0.25, 0.125];
/// The share of the distance up to which another distance counts as equal, and up to which it depends only a little.
/// The medians over perturbed starts of a chaotic robot differ by a few per cent.
pub const SAME: [f64; 2] = [0.05, STEADY];

/// A way to simulate the case, and the distances that it finds.
struct Trial {
    method: Method,
    /// The time step of the controller, s.
    dt: f64,
    precision: &'static str,
    /// The quantiles of the distance over the perturbed starts, m. Not finite if rollouts diverged.
    spread: Quantiles,
    /// True if the time step is below the stability limit of the robot at its start.
    is_stable: bool,
}

/// Simulates a case with shorter time steps, another integrator and in single precision, every time from the same
/// perturbed starts, and compares the median distances. Of a delivered robot, checks that half the time step and the other
/// integrator change the median by at most 20 %.
pub fn distance(case: &Case, is_delivered: bool) -> Section {
    let own = Method::of(case);
    let steps = FRACTIONS.map(|fraction| trial::<f64>(case, own, fraction, "f64"));
    let others = own.others().into_iter();
    let methods: Vec<Trial> = others.map(|m| trial::<f64>(case, m, 1.0, "f64")).collect();
    let single = trial::<f32>(case, own, 1.0, "f32");
    let mut section = Section {
        title: "Distance".to_owned(),
        charts: vec![chart(&steps)],
        ..Section::default()
    };
    let median = steps[0].spread.p50;
    section.check(median.is_finite(), "the robot diverges");
    let least = LEAST_MEDIAN * case.lattice.scale;
    let reference = Reference { median, least };
    if is_delivered && median.is_finite() {
        let half = std::iter::once((&steps[1], "half the time step".to_owned()));
        let methods = methods.iter().filter(|trial| trial.is_stable);
        let methods = methods.map(|trial| (trial, trial.method.name()));
        for (trial, name) in half.chain(methods) {
            let off = reference.apart(&[trial]);
            let failure = format!("{name} changes the distance by {} %", brief(100.0 * off));
            section.check(off <= STEADY, failure);
        }
    }
    section.answers = answers(case, &reference, (&steps, &methods, &single));
    let rows: Vec<Trial> = steps.into_iter().chain(methods).chain([single]).collect();
    section.tables = vec![table(&rows)];
    section
}

/// Simulates a case from perturbed starts by one method in numbers of one type, with a time step that is `fraction` times the
/// scene's.
fn trial<R: Real + Into<f64>>(
    case: &Case,
    method: Method,
    fraction: f64,
    precision: &'static str,
) -> Trial {
    let starts = moved_starts(case, STARTS);
    let here = method.applied(case, fraction, case.scene.physics.steps);
    let probe = Probe::new(&here);
    let observed = [here.scene.physics.steps];
    let groups = starts.par_chunks(together(STARTS));
    let ends = groups.map(|starts| probe.run::<R>(starts, &observed));
    let ends = ends.collect::<Vec<_>>().concat();
    let marker = here.body().marker;
    let along = |(start, end): (&State<f64>, &Vec<State<f64>>)| {
        let moved = marker.place(&start.x, &end[0]) - start.x[marker.payload];
        match end[0].is_absurd() {
            true => f64::NAN,
            false => probe.world.ground().along(moved),
        }
    };
    let distances: Vec<f64> = starts.iter().zip(&ends).map(along).collect();
    Trial {
        method,
        dt: here.scene.physics.dt,
        precision,
        spread: Quantiles::of(&distances),
        is_stable: here.scene.physics.dt < largest_stable_step(&here),
    }
}

/// The median distance that others are compared with.
pub struct Reference {
    /// The median distance with the scene's own settings, m.
    pub median: f64,
    /// The distance that counts at least, m: differences of a robot that stays in place are not magnified.
    pub least: f64,
}

impl Reference {
    /// The difference of a distance from the own one, as a share of the own one. Infinite if it is not finite.
    pub fn off(&self, distance: f64) -> f64 {
        let off = (distance - self.median).abs() / self.median.abs().max(self.least);
        if off.is_nan() { f64::INFINITY } else { off }
    }

    /// True if no median is larger than the distance that counts at least.
    pub fn hardly_moves(&self, medians: impl IntoIterator<Item = f64>) -> bool {
        medians.into_iter().all(|median| median.abs() < self.least)
    }

    /// The largest difference of the medians of some trials.
    fn apart(&self, trials: &[&Trial]) -> f64 {
        let off = trials.iter().map(|trial| self.off(trial.spread.p50));
        off.fold(0.0, f64::max)
    }

    /// Says in a sentence whether the distance depends on the property `name`, in which the trials differ.
    fn answer(&self, name: &str, trials: &[&Trial], of: impl Fn(&Trial) -> String) -> Item {
        let off = self.apart(trials);
        let level = Level::up_to(SAME, off);
        let (depends, share) = depends(level, off);
        let metres = |trial: &Trial| match trial.spread.p50 {
            x if x.is_finite() => format!("{} m", fixed(x, 2)),
            _ => "diverged".to_owned(),
        };
        let found = |trial: &&Trial| format!("{} {}", metres(trial), of(trial));
        let found: Vec<String> = trials.iter().map(found).collect();
        let says = format!("The distance {depends} {name}{share}: {}", found.join(", "));
        Item::figure(says, level)
    }
}

/// The words for how much a number depends on a setting, and in brackets by which share.
pub(super) fn depends(level: Level, off: f64) -> (&'static str, String) {
    let depends = match level {
        Level::Remark | Level::Good => "does not depend on",
        Level::Doubtful => "depends a little on",
        Level::Bad => "depends on",
    };
    let share = match level != Level::Good && off.is_finite() {
        true => format!(" (by {} %)", brief(100.0 * off)),
        false => String::new(),
    };
    (depends, share)
}

/// Answers the questions, each in a sentence.
fn answers(
    case: &Case,
    reference: &Reference,
    (steps, methods, single): (&[Trial], &[Trial], &Trial),
) -> Vec<Item> {
    let own = &steps[0];
    let Quantiles { p10, p50, p90 } = own.spread;
    if !p50.is_finite() {
        return vec![Item::figure("The robot diverges", Level::Bad)];
    }
    let seconds = brief(case.scene.physics.steps as f64 * case.scene.physics.dt);
    let figure = format!(
        "The robot moves by {} m in {} s ({} to {} m from perturbed starts)",
        fixed(p50, 2),
        seconds,
        fixed(p10, 2),
        fixed(p90, 2)
    );
    let all: Vec<&Trial> = steps.iter().collect();
    let at = |trial: &Trial| format!("at {} ms", brief(1e3 * trial.dt));
    // The distance of a run with an unstable time step has no meaning.
    let others = methods.iter().filter(|trial| trial.is_stable);
    let compared: Vec<&Trial> = std::iter::once(own).chain(others).collect();
    let everything = all.iter().chain(&compared).chain([&single]);
    let medians = everything.map(|trial| trial.spread.p50);
    if reference.hardly_moves(medians) {
        let says = format!(
            "The robot hardly moves: {} m in {} s, less than half of the distance of neighbouring nodes, so its \
             distances are not compared",
            fixed(p50, 3),
            seconds
        );
        return vec![Item::figure(says, Level::Doubtful)];
    }
    let by_method = match compared.len() {
        1 => Item::figure(
            "Every other integrator needs a shorter time step than the scene's",
            Level::Doubtful,
        ),
        _ => reference.answer("the integrator", &compared, |t| {
            format!("by {}", t.method.name())
        }),
    };
    vec![
        Item::figure(figure, Level::Good),
        reference.answer("the time step", &all, at),
        by_method,
        reference.answer("the precision", &[own, single], |t| {
            format!("in {}", t.precision)
        }),
    ]
}

fn chart(steps: &[Trial]) -> Chart {
    let line = |name: &str, of: fn(&Quantiles) -> f64| {
        let points = steps.iter().map(|trial| [trial.dt, of(&trial.spread)]);
        Line::new(name, points)
    };
    Chart {
        title: "Distance from perturbed starts, m".to_owned(),
        along: "time step, s".to_owned(),
        is_log: [true, false],
        lines: vec![
            line("90 % quantile", |spread| spread.p90),
            line("median", |spread| spread.p50),
            line("10 % quantile", |spread| spread.p10),
        ],
    }
}

fn table(trials: &[Trial]) -> Table {
    let title = format!("Distance along the ground from {STARTS} perturbed starts");
    let first = |trial: &Trial| std::ptr::eq(trial, &trials[0]);
    let status = |trial: &Trial| match (trial.spread.p50.is_finite(), trial.is_stable) {
        (true, true) => "ok",
        (_, false) => "unstable time step",
        (false, true) => "diverged",
    };
    let quantile = |of: fn(&Quantiles) -> f64| move |t: &Trial| Cell::if_finite(of(&t.spread));
    let (p10, p50, p90) = (
        quantile(|spread| spread.p10),
        quantile(|spread| spread.p50),
        quantile(|spread| spread.p90),
    );
    Table::of("distance", &title, trials)
        .column("method", "integrator and substeps", |t| t.method.name())
        .column("dt_s", "time step of the controller, s", |t| t.dt)
        .column("precision", "number type", |t| t.precision)
        .column("p10_m", "10 % quantile of the distance", p10)
        .column("median_m", "median distance", p50)
        .column("p90_m", "90 % quantile of the distance", p90)
        .column("status", "the outcome", status)
        .mark(Emphasis::Default, first)
        .done()
}
