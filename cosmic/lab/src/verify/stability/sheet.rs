//! The results on stability as a section of a sheet.

use super::extremes::{case_trials, extreme_trials};
use super::trial::{Found, Outcome, Trial};
use crate::report::sheet::Section;
use crate::table::{Cell, Standing, Table};
use crate::verify::probe::frequencies;
use cosmic::case::Case;
use cosmic::scene::{Integrator, Named, PhysicsSettings};
use cosmic::simulator::Grade;
use cosmic::simulator::stability::stable_step;
use rayon::prelude::*;

/// Tries a case and all extremes. Every trial is checked, and the case's own time step.
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

/// The stable time steps of a case at its start, for every integrator. The case's own time step is checked.
pub fn stable_steps(case: &Case) -> Section {
    let [exact, bound, damping] = frequencies(case, &case.start.x);
    let asked = (case.physics.integrator, case.physics.substeps);
    let mut offered: Vec<_> = Integrator::ALL.iter().map(|(_, i)| (*i, 1)).collect();
    if !offered.contains(&asked) {
        offered.push(asked);
    }
    let limit = |&(integrator, substeps): &(Integrator, usize), frequency| {
        let physics = PhysicsSettings {
            integrator,
            substeps,
            ..case.physics.clone()
        };
        stable_step(&physics, frequency, damping)
    };
    // A limit that is NaN is not above any step.
    let is_stable = |offer: &_| case.physics.dt < limit(offer, exact);
    let title = "Time steps below which the design at its start does not ring";
    let of_bound = "stable for certain, by the bound over the edges";
    let of_limit = "stable, by the largest frequency itself";
    let outcome = |offer: &_| {
        if is_stable(offer) {
            "stable"
        } else {
            "unstable"
        }
    };
    let table = Table::of("stable_steps", title, &offered)
        .column("integrator", "how a step is integrated", |offer| {
            offer.0.name()
        })
        .column("substeps", "mechanical steps per time step", |offer| {
            offer.1
        })
        .column("dt_s", "the scene's time step", |_| case.physics.dt)
        .column("bound_s", of_bound, |offer| {
            Cell::if_finite(limit(offer, bound))
        })
        .column("limit_s", of_limit, |offer| {
            Cell::if_finite(limit(offer, exact))
        })
        .column(
            "at_dt_s",
            "the scene's time step with this integrator",
            outcome,
        )
        .mark(Standing::Default, |offer| *offer == asked)
        .mark(Standing::Failed, |offer| {
            *offer == asked && !is_stable(offer)
        })
        .done();
    let mut section = Section {
        title: "Stability".to_owned(),
        tables: vec![table],
        ..Section::default()
    };
    let failure = "the scene's time step is beyond the stable one";
    section.check(is_stable(&asked), failure);
    section
}

fn notes(found: &[Found]) -> Vec<String> {
    let unstable = found.iter().filter(|f| !f.expected_stable()).count();
    let silent = found.iter().filter(|f| f.unannounced).count();
    let robots = found.len();
    let counts = format!(
        "{robots} robots at the extremes, {unstable} of them with a time step that is expected to be \
         unstable; numbers that were not finite and not announced: {silent}."
    );
    [
        &counts,
        "A row is stable below the limit, the smallest time step with which the fastest vibration \
         about rest grows. A stable robot must stay bounded. An unstable one must be called unstable \
         beforehand, and must grow.",
        "Of a robot without ground, gravity and actuation the energy is watched, of others the speed, \
         against what drives them. `growth` is the largest over the largest that a stable step reaches.",
    ]
    .map(str::to_owned)
    .to_vec()
}

fn extremes(found: &[Found]) -> Table {
    let bound = "stable for certain, by the bound over the edges";
    let limit = "stable, by the largest frequency itself";
    let word = |stable: bool| if stable { "stable" } else { "unstable" };
    Table::of("extremes", "Robots at the extremes", found)
        .column("extreme", "what is extreme", |f| f.trial.group)
        .column("what", "the robot", |f| f.trial.what.clone())
        .column("nodes", "nodes of its lattice", |f| {
            f.trial.case.lattice.nodes()
        })
        .column("dt_s", "time step", |f| f.trial.case.physics.dt)
        .column("bound_s", bound, |f| Cell::if_finite(f.bound))
        .column("limit_s", limit, |f| Cell::if_finite(f.trial.limit))
        .column("expected", "stable or unstable, by the limit", |f| {
            word(f.expected_stable())
        })
        .column("said", "of the time step beforehand", |f| match f.grade {
            Grade::Safe => "safe",
            Grade::Close => "close",
            Grade::Unstable => "unstable",
        })
        .column("outcome", "what happened", |f| match &f.outcome {
            Outcome::Bounded => "bounded".to_owned(),
            Outcome::Grew => "grew".to_owned(),
            Outcome::Diverged(d) => format!("diverged: node {}, {}", d.node, d.term),
        })
        .column("growth", "1 and more is growth", |f| {
            // The growth of a state that blew up is beyond all numbers, and means nothing.
            (f.outcome == Outcome::Bounded).then_some(f.growth)
        })
        .column(
            "step",
            "that made a state absurd, if one did",
            |f| match &f.outcome {
                Outcome::Diverged(divergence) => divergence.step.into(),
                Outcome::Bounded | Outcome::Grew => Cell::Missing,
            },
        )
        .column("verdict", "whether all is as expected", |f| {
            if f.is_ok() { "ok" } else { "wrong" }
        })
        .mark(Standing::Default, |f| f.trial.group == "scene")
        .mark(Standing::Failed, |f| !f.is_ok())
        .done()
}
