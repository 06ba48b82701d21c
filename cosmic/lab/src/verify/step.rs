//! A case's time step beside the stable ones.

use super::probe::frequencies;
use crate::report::sheet::Section;
use crate::table::{Cell, Standing, Table};
use cosmic::case::Case;
use cosmic::scene::{Integrator, Named, PhysicsSettings};
use cosmic::simulator::stability::stable_step;

/// The stable time steps of a case at its start, for every integrator.
pub fn stable_steps(case: &Case) -> Section {
    let [exact, bound, damping] = frequencies(case, &case.start.x);
    let asked = (case.physics.integrator, case.physics.substeps);
    let mut offered: Vec<_> = Integrator::ALL.iter().map(|(_, i)| (*i, 1)).collect();
    if !offered.contains(&asked) {
        offered.push(asked);
    }
    let limits = |&(integrator, substeps): &(Integrator, usize)| {
        let physics = PhysicsSettings {
            integrator,
            substeps,
            ..case.physics.clone()
        };
        [exact, bound].map(|frequency| stable_step(&physics, frequency, damping))
    };
    let is_unstable = |offer: &_| {
        let [exact, _] = limits(offer);
        // No step is below a limit that is NaN.
        let stable = case.physics.dt < exact;
        !stable
    };
    let title = "Time steps below which the design at its start does not ring";
    let integrator = "how a step is integrated";
    let substeps = "mechanical steps per time step";
    let bound = "stable for certain, by the bound over the edges";
    let limit = "stable, by the largest frequency itself";
    let table = Table::of("stable_steps", title, &offered)
        .column("integrator", integrator, |offer| offer.0.name())
        .column("substeps", substeps, |offer| offer.1)
        .column("dt_s", "the scene's time step", |_| case.physics.dt)
        .column("bound_s", bound, |offer| Cell::if_finite(limits(offer)[1]))
        .column("limit_s", limit, |offer| Cell::if_finite(limits(offer)[0]))
        .mark(Standing::Default, |offer| *offer == asked)
        .column(
            "at_dt_s",
            "the scene's time step with this integrator",
            |offer| {
                if is_unstable(offer) {
                    "unstable"
                } else {
                    "stable"
                }
            },
        )
        .mark(Standing::Failed, |offer| {
            *offer == asked && is_unstable(offer)
        })
        .done();
    let mut section = Section {
        title: "Stability".to_owned(),
        tables: vec![table],
        ..Section::default()
    };
    let failure = "the scene's time step is beyond the stable one";
    section.check(!is_unstable(&asked), failure);
    section
}
