//! Tries extreme robots with time steps below and above the largest stable one.
//!
//! The limit of stability follows from a robot's largest frequency. If the time step is below the limit, the trial is
//! expected to be stable, and nothing may grow. Otherwise the check of the time step must call it unstable, and something
//! must grow. If a number is not finite, a divergence must have been reported.

mod extremes;
mod trial;

use super::accuracy::Method;
use super::probe::step_limits;
use crate::report::sheet::{Section, marked};
use crate::table::{Cell, Emphasis, Table};
use cosmic::case::Case;
use cosmic::scene::Integrator;
pub use extremes::{case_trials, extreme_trials};
use rayon::prelude::*;
pub use trial::{Found, Outcome, Trial};

/// Tries a case and all extreme robots, stiff and soft, heavy and light. Checks that every trial goes as expected.
pub fn stability(case: &Case) -> Section {
    let trials = [case_trials(case), extreme_trials(case.lattice.dimension)].concat();
    let found: Vec<Found> = trials.par_iter().map(Trial::run).collect();
    let (steps, groups) = (stable_steps(case), groups(&found));
    let mut section = Section {
        title: "Stability".to_owned(),
        text: format!("{}\n{}", marked(&steps), marked(&groups)),
        notes: vec![
            "Below the limit, a robot must stay bounded. Otherwise, the check of the time step must call the robot unstable \
             before the run, and the robot's energy or speed must grow. `growth` is the largest energy or speed, divided \
             by the largest that a stable time step can reach."
                .to_owned(),
        ],
        tables: vec![steps, groups, extremes(&found)],
        ..Section::default()
    };
    for found in &found {
        let failure = format!("{}: {}", found.trial.group, found.trial.what);
        section.check(found.is_ok(), failure);
    }
    section
}

fn word(stable: bool) -> &'static str {
    if stable { "stable" } else { "unstable" }
}

/// The smallest unstable time steps of a method, s: by the bound from single edges, and by the largest frequency.
struct Limits {
    method: Method,
    bound: f64,
    exact: f64,
}

/// Makes a table of the largest stable time steps of a case at its start, for every integrator.
fn stable_steps(case: &Case) -> Table {
    use Integrator::{Implicit, Leapfrog, SymplecticEuler};
    let own = Method::of(case);
    let mut methods = [SymplecticEuler, Leapfrog, Implicit]
        .map(Method::single)
        .to_vec();
    if !methods.contains(&own) {
        methods.push(own);
    }
    let limits = |method: Method| {
        let case = method.applied(case, 1.0, 1);
        let [exact, bound] = step_limits(&case, &case.start.x).map(|limit| limit.step());
        Limits {
            method,
            bound,
            exact,
        }
    };
    let limits: Vec<Limits> = methods.into_iter().map(limits).collect();
    let title = "Time steps below which the design is stable at its start";
    Table::of("stable_steps", title, &limits)
        .column("integrator", "integrator and substeps", |limits| {
            limits.method.name()
        })
        .column("bound_s", "by the bound from single edges", |limits| {
            Cell::if_finite(limits.bound)
        })
        .column("limit_s", "by the largest frequency", |limits| {
            Cell::if_finite(limits.exact)
        })
        .column("at_dt", "with the scene's time step", |limits| {
            word(case.scene.physics.dt < limits.exact)
        })
        .mark(Emphasis::Default, |limits| limits.method == own)
        .done()
}

/// Makes a table with a row for each kind of robots.
fn groups(found: &[Found]) -> Table {
    let groups: Vec<&[Found]> = found
        .chunk_by(|a, b| a.trial.group == b.trial.group)
        .collect();
    let count = |of: fn(&&Found) -> bool| move |group: &&[Found]| group.iter().filter(of).count();
    let growth = |group: &&[Found]| {
        let stable = group.iter().filter(|found| found.expected_stable());
        stable.map(|found| found.growth).fold(0.0, f64::max)
    };
    Table::of("groups", "Kinds of robots", &groups)
        .column("kind", "what is extreme", |group| group[0].trial.group)
        .column("robots", "number of trials", |group| group.len())
        .column(
            "stable",
            "expected to be stable",
            count(|f| f.expected_stable()),
        )
        .column(
            "unstable",
            "expected to be unstable",
            count(|f| !f.expected_stable()),
        )
        .column(
            "growth",
            "largest growth of a stable robot; 1 is unstable",
            growth,
        )
        .column(
            "wrong",
            "trials that did not go as expected",
            count(|f| !f.is_ok()),
        )
        .mark(Emphasis::Failed, |group| !group.iter().all(Found::is_ok))
        .done()
}

fn extremes(found: &[Found]) -> Table {
    let outcome = |f: &Found| match &f.outcome {
        Outcome::Bounded => "bounded".to_owned(),
        Outcome::Grew => "grew".to_owned(),
        Outcome::Diverged(d) => format!("diverged in step {}", d.step),
    };
    // The growth of a diverged state is meaningless.
    let growth = |f: &Found| (f.outcome == Outcome::Bounded).then_some(f.growth);
    let verdict = |f: &Found| if f.is_ok() { "ok" } else { "wrong" };
    let grade = |f: &Found| format!("{:?}", f.grade).to_lowercase();
    Table::of("extremes", "Robots at the extremes", found)
        .column("kind", "what is extreme", |f| f.trial.group)
        .column("robot", "the robot and its time step", |f| {
            f.trial.what.clone()
        })
        .column("dt_s", "time step", |f| f.trial.case.scene.physics.dt)
        .column("limit_s", "stable below this time step", |f| {
            Cell::if_finite(f.trial.limit)
        })
        .column("expected", "according to the limit", |f| {
            word(f.expected_stable())
        })
        .column(
            "grade",
            "by the check of the time step before the run",
            grade,
        )
        .column("outcome", "what happened", outcome)
        .column("growth", "1 or more is growth", growth)
        .column("verdict", "whether the trial went as expected", verdict)
        .mark(Emphasis::Failed, |f| !f.is_ok())
        .done()
}
