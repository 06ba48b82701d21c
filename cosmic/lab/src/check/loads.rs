//! The accuracy of a case: the errors of positions against run time, and whether the forces in the bars and the power of the
//! actuators depend on the time step.

use rayon::prelude::*;

use super::accuracy::{Accuracy, FRACTIONS, Method};
use super::distance::{SAME, depends};
use super::probe::{most, moved_starts};
use crate::report::sheet::{Section, marked};
use crate::table::{Cell, Emphasis, Table};
use cosmic::case::Case;
use cosmic::design::Material;
use cosmic::judge::Quantiles;
use cosmic::judge::verdict::{Item, Level};
use cosmic::lattice::State;
use cosmic::numbers::{brief, short};
use cosmic::walk::{self, BarLoad};
use cosmic::world::Span;

/// The number of perturbed starts. Peaks of single walks differ; their median differs less.
const STARTS: usize = 4;

/// Forces and power with one time step: medians over the starts, not finite if walks diverge.
#[derive(Clone, Copy, Debug)]
pub struct LoadsOfStep {
    /// The time step of the controller, s.
    pub dt: f64,
    /// The largest force along a bar, N.
    pub force: f64,
    /// The largest 99 % quantile of the force along a bar, N.
    pub force_p99: f64,
    /// The mean power that all actuators give, W.
    pub power: f64,
}

/// Runs a case with several integrators and time steps, and reports the errors, how fast they fall, and the run times. Checks
/// that no run with a stable time step diverged, nor the scene's own run. Also compares forces and power.
pub fn accuracy(case: &Case) -> Section {
    let (mut section, found) = (Accuracy::of(case).section(), loads_of_steps(case));
    let table = table(&found);
    section.text += &format!("\n{}", marked(&table));
    section.tables.push(table);
    section.answers.extend(answers(&found));
    section
}

/// Measures forces and power with the scene's time step and with shorter ones. An undecided design has a bar at every edge
/// here.
pub fn loads_of_steps(case: &Case) -> Vec<LoadsOfStep> {
    let starts = &moved_starts(case, STARTS);
    let ways = FRACTIONS
        .iter()
        .flat_map(|fraction| starts.iter().map(move |start| (*fraction, start)));
    let ways: Vec<_> = ways.collect();
    let found: Vec<[f64; 3]> = ways
        .par_iter()
        .map(|&(fraction, start)| loads(case, fraction, start))
        .collect();
    let of_steps = FRACTIONS.iter().zip(found.chunks_exact(STARTS));
    let of_step = |(fraction, found): (&f64, &[[f64; 3]])| {
        let median = |k: usize| {
            let numbers: Vec<f64> = found.iter().map(|numbers| numbers[k]).collect();
            Quantiles::of(&numbers).p50
        };
        LoadsOfStep {
            dt: case.scene.physics.dt * fraction,
            force: median(0),
            force_p99: median(1),
            power: median(2),
        }
    };
    of_steps.map(of_step).collect()
}

/// The largest force along a bar, its 99 % quantile, and the mean power of all actuators in one walk.
fn loads(case: &Case, fraction: f64, start: &State<f64>) -> [f64; 3] {
    let here = Method::of(case).applied(case, fraction, case.scene.physics.steps);
    let all = || vec![Material::Actuator; case.lattice.edges.len()];
    let layout = case.design.layout().map_or_else(all, <[_]>::to_vec);
    let robot = here.robot().from(start);
    let bars = walk::bar_loads(
        &here.world(),
        &layout,
        &robot,
        &Span::of_steps(here.scene.physics.steps),
    );
    let largest = |of: fn(&BarLoad) -> f64| most(bars.iter().flatten().map(of));
    let actuators = bars
        .iter()
        .zip(&layout)
        .filter(|(_, m)| **m == Material::Actuator);
    let given = actuators.map(|(bar, _)| bar.as_ref().map_or(0.0, |bar| bar.given));
    [
        largest(|bar| bar.force.peak),
        largest(|bar| bar.force.p99),
        given.sum(),
    ]
}

/// A table of forces and power, with a row for each time step.
fn table(found: &[LoadsOfStep]) -> Table {
    let title = format!("Forces and power, medians over {STARTS} perturbed starts");
    Table::of("loads", &title, found)
        .column("dt_s", "time step of the controller, s", |step| step.dt)
        .column("force_peak_n", "largest force along a bar, N", |step| {
            Cell::if_finite(step.force)
        })
        .column(
            "force_p99_n",
            "largest 99 % quantile of the force along a bar, N",
            |step| Cell::if_finite(step.force_p99),
        )
        .column("power_w", "mean power that all actuators give, W", |step| {
            Cell::if_finite(step.power)
        })
        .mark(Emphasis::Default, |step| std::ptr::eq(step, &found[0]))
        .done()
}

/// Says whether forces and power depend on the time step, each in a sentence.
pub fn answers(found: &[LoadsOfStep]) -> [Item; 2] {
    [
        answer(found, "largest force", "N", |step| step.force),
        answer(found, "power", "W", |step| step.power),
    ]
}

fn answer(found: &[LoadsOfStep], name: &str, unit: &str, of: fn(&LoadsOfStep) -> f64) -> Item {
    let own = of(&found[0]);
    let off = most(found.iter().map(|step| (of(step) - own).abs() / own.abs()));
    // Without forces, 0 is compared with 0.
    let off = match found.iter().all(|step| of(step) == own) {
        true => 0.0,
        false => off,
    };
    let level = Level::up_to(SAME, if off.is_nan() { f64::INFINITY } else { off });
    let (depends, share) = depends(level, off);
    let at = |step: &LoadsOfStep| match of(step) {
        x if x.is_finite() => format!("{} {unit} at {} ms", short(x), brief(1e3 * step.dt)),
        _ => format!("diverged at {} ms", brief(1e3 * step.dt)),
    };
    let all: Vec<String> = found.iter().map(at).collect();
    Item::figure(
        format!(
            "The {name} {depends} the time step{share}: {}",
            all.join(", ")
        ),
        level,
    )
}
