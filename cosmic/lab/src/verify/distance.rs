//! The question of an engineer: does the distance depend on the time step, the integrator or the precision?

use rayon::prelude::*;

use super::accuracy::Method;
use super::probe::{Probe, stable_step_at};
use crate::report::sheet::Section;
use crate::table::{Cell, Standing, Table, decimals};
use cosmic::case::Case;
use cosmic::codesign::{LEAST_WALK, Quantiles, STEADY};
use cosmic::lattice::State;
use cosmic::task::together;
use cosmic::verdict::{Item, Level, plain};

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

/// Simulates a case with shorter time steps, other integrators and in single precision, every time from the same
/// perturbed starts, and compares the median distances.
pub fn distance(case: &Case) -> Section {
    let own = Method::of(case);
    let step = |fraction: &f64| trial(case, own, *fraction, false);
    let steps: Vec<Trial> = FRACTIONS.iter().map(step).collect();
    let others = Method::all(case).into_iter().filter(|m| *m != own);
    let methods: Vec<Trial> = others.map(|m| trial(case, m, 1.0, false)).collect();
    let single = trial(case, own, 1.0, true);
    let mut section = Section {
        title: "Distance".to_owned(),
        verdict: verdict(case, &steps, &methods, &single),
        ..Section::default()
    };
    section.check(
        steps[0].spread.p50.is_finite(),
        "the median distance with the scene's own settings diverged",
    );
    let rows: Vec<Trial> = steps.into_iter().chain(methods).chain([single]).collect();
    section.tables = vec![table(&rows)];
    section
}

/// Simulates a case from perturbed starts by one method, with a time step that is `fraction` times the scene's, in f32 if
/// `single`, otherwise in f64.
fn trial(case: &Case, method: Method, fraction: f64, single: bool) -> Trial {
    let starts = Probe::new(case).moved_starts(STARTS);
    let mut here = case.clone();
    let physics = &mut here.physics;
    method.set(physics);
    physics.dt *= fraction;
    physics.steps = (physics.steps as f64 / fraction) as usize;
    let is_stable = here.physics.dt < stable_step_at(&here, &here.start.x);
    let (probe, observed) = (Probe::new(&here), [0, here.physics.steps]);
    let reached: Vec<Vec<State<f64>>> = if single {
        let run = |start: &State<f64>| {
            let case = Case {
                start: start.clone(),
                ..here.clone()
            };
            Probe::new(&case).run::<f32>(&observed)
        };
        starts.par_iter().map(run).collect()
    } else {
        let groups = starts.par_chunks(together(STARTS));
        let reached = groups.map(|starts| probe.run_batch(starts, &observed));
        reached.collect::<Vec<_>>().concat()
    };
    let marker = here.body().marker;
    let along = |states: &Vec<State<f64>>| {
        let [first, last] = [&states[0], &states[1]];
        let moved = marker.place(&first.x, last) - first.x[marker.payload];
        match last.is_absurd() {
            true => f64::NAN,
            false => probe.task.ground().along(moved),
        }
    };
    Trial {
        method,
        dt: here.physics.dt,
        precision: if single { "f32" } else { "f64" },
        spread: Quantiles::of(&reached.iter().map(along).collect::<Vec<_>>()),
        is_stable,
    }
}

/// Answers the questions, each in a sentence.
fn verdict(case: &Case, steps: &[Trial], methods: &[Trial], single: &Trial) -> Vec<Item> {
    let own = &steps[0];
    let Quantiles { p10, p50, p90 } = own.spread;
    let seconds = case.physics.steps as f64 * case.physics.dt;
    if !p50.is_finite() {
        return vec![Item::figure("the robot diverges", Level::Bad)];
    }
    let figure = format!(
        "The robot moves by {} m in {} s ({} to {} m from perturbed starts)",
        decimals(p50, 2),
        plain(seconds),
        decimals(p10, 2),
        decimals(p90, 2)
    );
    let least = LEAST_WALK * case.lattice.scale;
    let list = |trials: &[&Trial], of: &dyn Fn(&Trial) -> String| {
        let texts: Vec<String> = trials.iter().map(|trial| of(trial)).collect();
        texts.join(", ")
    };
    let metres = |trial: &Trial| match trial.spread.p50 {
        x if x.is_finite() => decimals(x, 2),
        _ => "diverged".to_owned(),
    };
    let judged = |name: &str, trials: &[&Trial], at: String| {
        let off = most_apart(p50, trials.iter().map(|trial| trial.spread.p50), least);
        let level = Level::up_to(SAME, off);
        let metres = list(trials, &metres);
        Item::figure(
            format!(
                "{} {name}{}: {metres} m {at}",
                depends(level),
                share(level, off)
            ),
            level,
        )
    };
    let all: Vec<&Trial> = steps.iter().collect();
    let ms = |trial: &Trial| plain(1e3 * trial.dt);
    let at = format!("at {} ms", list(&all, &ms));
    let by_step = judged("the time step", &all, at);
    // A method whose time step is too long for the robot tells nothing about the distance.
    let others = methods.iter().filter(|trial| trial.is_stable);
    let compared: Vec<&Trial> = std::iter::once(own).chain(others).collect();
    let names = |trial: &Trial| trial.method.name();
    let by_method = match compared.len() {
        1 => Item::figure(
            "Every other integrator needs a shorter time step than the scene's",
            Level::Doubtful,
        ),
        _ => judged(
            "the integrator",
            &compared,
            format!("by {}", list(&compared, &names)),
        ),
    };
    let both = [own, single];
    let by_precision = judged("the precision", &both, "in f64, f32".to_owned());
    let first = Item::figure(figure, Level::Good);
    vec![first, by_step, by_method, by_precision]
}

/// The largest difference of one of the distances from `own`, as a share of `own`, which counts at least as `least`; all in
/// metres. Infinite if one of them is not finite.
pub fn most_apart(own: f64, distances: impl Iterator<Item = f64>, least: f64) -> f64 {
    let off = distances.map(|x| (x - own).abs() / own.abs().max(least));
    off.map(|off| if off.is_nan() { f64::INFINITY } else { off })
        .fold(0.0, f64::max)
}

fn depends(level: Level) -> &'static str {
    match level {
        Level::Good => "The distance does not depend on",
        Level::Doubtful => "The distance depends a little on",
        Level::Bad => "The distance depends on",
    }
}

fn share(level: Level, off: f64) -> String {
    match level {
        Level::Good => String::new(),
        _ if off.is_finite() => format!(" (by {} %)", plain(100.0 * off)),
        _ => String::new(),
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
    Table::of("distance", &title, trials)
        .column(
            "method",
            "integrator, and substeps if there are more than one",
            |t| t.method.name(),
        )
        .column("dt_s", "time step of the controller, s", |t| t.dt)
        .column("precision", "number type", |t| t.precision)
        .column("p10_m", "10 % quantile of the distance", |t| {
            Cell::if_finite(t.spread.p10)
        })
        .column("median_m", "median distance", |t| {
            Cell::if_finite(t.spread.p50)
        })
        .column("p90_m", "90 % quantile of the distance", |t| {
            Cell::if_finite(t.spread.p90)
        })
        .column("status", "the outcome", status)
        .mark(Standing::Default, first)
        .done()
}
