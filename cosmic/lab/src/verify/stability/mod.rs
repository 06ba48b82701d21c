//! Tries extreme robots with time steps below and above the largest stable one.
//!
//! Each row of the table is a robot with a time step. The limit of stability follows from the robot's largest
//! frequency. If the time step is below the limit, the trial is expected to be stable, and nothing may grow. Otherwise
//! the check of the time step must call it unstable, and something must grow. If a number is not finite, a divergence
//! must have been reported.

mod extremes;
mod trial;

use crate::report::sheet::Section;
use crate::table::{Cell, Standing, Table};
use crate::verify::probe::{frequencies, step_off_bars};
use cosmic::case::Case;
use cosmic::scene::{Integrator, Named, PhysicsSettings, stable_step};
pub use extremes::{case_trials, extreme_trials};
use rayon::prelude::*;
pub use trial::{Found, Outcome, Trial};

/// Tries a case and all extreme robots. Checks every trial, and also the case's own time step.
pub fn stability(case: &Case) -> Section {
    let trials = [case_trials(case), extreme_trials()].concat();
    let found: Vec<Found> = trials.par_iter().map(Trial::run).collect();
    let mut section = stable_steps(case);
    for found in &found {
        let failure = format!("{}: {}", found.trial.group, found.trial.what);
        section.check(found.is_ok(), failure);
    }
    section.tables.push(extremes(&found));
    section.notes = notes(&found);
    section
}

const BOUND: &str = "stable according to the bound from single edges";
const LIMIT: &str = "stable according to the largest frequency";

fn word(stable: bool) -> &'static str {
    if stable { "stable" } else { "unstable" }
}

/// Makes a table of the largest stable time steps of a case at its start, for every integrator. Checks that the case's
/// own time step is stable.
pub fn stable_steps(case: &Case) -> Section {
    let [exact, bound, damping] = frequencies(case, &case.start.x);
    let own = (case.physics.integrator, case.physics.substeps);
    let mut offered: Vec<_> = Integrator::ALL.iter().map(|(_, i)| (*i, 1)).collect();
    if !offered.contains(&own) {
        offered.push(own);
    }
    let limit = |&(integrator, substeps): &(Integrator, usize), frequency| {
        let physics = PhysicsSettings {
            integrator,
            substeps,
            ..case.physics.clone()
        };
        let off_bars = step_off_bars(case, &physics, &case.start.x);
        stable_step(&physics, frequency, damping).min(off_bars)
    };
    // If the limit is NaN, the comparison is false, so no time step counts as stable.
    let is_stable = |offer: &_| case.physics.dt < limit(offer, exact);
    let if_finite = |offer: &_, frequency| Cell::if_finite(limit(offer, frequency));
    let integrator = |offer: &(Integrator, usize)| offer.0.name();
    let title = "Time steps below which the design is stable at its start";
    let of_own = "the scene's time step with this integrator";
    let table = Table::of("stable_steps", title, &offered)
        .column("integrator", "how a step is integrated", integrator)
        .column("substeps", "mechanical steps per time step", |o| o.1)
        .column("dt_s", "the scene's time step", |_| case.physics.dt)
        .column("bound_s", BOUND, |offer| if_finite(offer, bound))
        .column("limit_s", LIMIT, |offer| if_finite(offer, exact))
        .column("at_dt_s", of_own, |offer| word(is_stable(offer)))
        .mark(Standing::Default, |offer| *offer == own)
        .mark(Standing::Failed, |o| *o == own && !is_stable(o))
        .done();
    let mut section = Section {
        title: "Stability".to_owned(),
        tables: vec![table],
        ..Section::default()
    };
    let failure = "the scene's time step is above the largest stable one";
    section.check(is_stable(&own), failure);
    section
}

fn notes(found: &[Found]) -> Vec<String> {
    let unstable = found.iter().filter(|f| !f.expected_stable()).count();
    let silent = found.iter().filter(|f| f.unannounced).count();
    vec![
        format!(
            "{} extreme robots, {unstable} of them with a time step that is expected to be unstable. \
             Rows with numbers that were not finite although no divergence was reported: {silent}.",
            found.len()
        ),
        "The limit is the smallest time step with which the fastest vibration about rest grows. Below \
         the limit, a robot must stay bounded. Otherwise, the check of the time step must call the \
         robot unstable before the run, and the robot's energy or speed must grow."
            .to_owned(),
        "For robots without ground, gravity and actuation, the energy is watched. For other robots, the \
         speed is watched, relative to what drives them. `growth` is the largest energy or speed, \
         divided by the largest that a stable time step can reach."
            .to_owned(),
    ]
}

fn extremes(found: &[Found]) -> Table {
    let outcome = |f: &Found| match &f.outcome {
        Outcome::Bounded => "bounded".to_owned(),
        Outcome::Grew => "grew".to_owned(),
        Outcome::Diverged(d) => format!("diverged: node {}, {}", d.node, d.term),
    };
    // The growth of a diverged state is meaningless.
    let growth = |f: &Found| (f.outcome == Outcome::Bounded).then_some(f.growth);
    let step = |f: &Found| match &f.outcome {
        Outcome::Diverged(divergence) => divergence.step.into(),
        Outcome::Bounded | Outcome::Grew => Cell::Missing,
    };
    let verdict = |f: &Found| if f.is_ok() { "ok" } else { "wrong" };
    let of_expected = "stable or unstable, according to the limit";
    let expected = |f: &Found| word(f.expected_stable());
    let said = |f: &Found| format!("{:?}", f.grade).to_lowercase();
    let nodes = |f: &Found| f.trial.case.lattice.nodes();
    Table::of("extremes", "Robots at the extremes", found)
        .column("extreme", "what is extreme", |f| f.trial.group)
        .column("what", "the robot", |f| f.trial.what.clone())
        .column("nodes", "number of nodes of the lattice", nodes)
        .column("dt_s", "time step", |f| f.trial.case.physics.dt)
        .column("bound_s", BOUND, |f| Cell::if_finite(f.bound))
        .column("limit_s", LIMIT, |f| Cell::if_finite(f.trial.limit))
        .column("expected", of_expected, expected)
        .column(
            "said",
            "the verdict of the check of the time step, before the run",
            said,
        )
        .column("outcome", "what happened", outcome)
        .column(
            "growth",
            "largest energy or speed, divided by the largest that a stable time step can reach; 1 or more is growth",
            growth,
        )
        .column("step", "the step of the divergence, if any", step)
        .column("verdict", "whether the trial went as expected", verdict)
        .mark(Standing::Default, |f| f.trial.group == "scene")
        .mark(Standing::Failed, |f| !f.is_ok())
        .done()
}
