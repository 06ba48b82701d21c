//! A case's time step beside the one that its springs bear.

use crate::report::sheet::Section;
use crate::table::{Cell, Column, Row, Standing, Table};
use cosmic::case::Case;
use cosmic::scene::{Integrator, Named, PhysicsSettings};
use cosmic::simulator::stability::{Vibration, stable_step};

/// The stable time steps of a case's start by every integrator.
pub fn stable_steps(case: &Case) -> Section {
    let body = case.body();
    let vibration = Vibration::new(&case.lattice, &body, &case.physics, &case.start.x);
    let frequencies = [vibration.largest_frequency(), vibration.edge_bound()];
    let asked = (case.physics.integrator, case.physics.substeps);
    let mut offered: Vec<_> = Integrator::ALL.iter().map(|(_, i)| (*i, 1)).collect();
    if !offered.contains(&asked) {
        offered.push(asked);
    }
    let rows = offered.iter().map(|&(integrator, substeps)| {
        let physics = PhysicsSettings {
            integrator,
            substeps,
            ..case.physics.clone()
        };
        let [exact, bound] = frequencies.map(|frequency| stable_step(&physics, frequency));
        let standing = match (physics.dt < exact, (integrator, substeps) == asked) {
            (false, _) => Standing::Failed,
            (true, true) => Standing::Default,
            (true, false) => Standing::Plain,
        };
        let cells = vec![
            integrator.name().into(),
            substeps.into(),
            Cell::Number(physics.dt),
            Cell::if_finite(bound),
            Cell::if_finite(exact),
        ];
        Row { cells, standing }
    });
    let table = Table {
        name: "stable_steps".to_owned(),
        title: "Time steps below which the design at its start does not ring".to_owned(),
        columns: vec![
            Column::new("integrator", "how a step is integrated"),
            Column::new("substeps", "mechanical steps per time step"),
            Column::new("dt_s", "the scene's time step"),
            Column::new("bound_s", "stable for certain, by the bound over the edges"),
            Column::new("limit_s", "stable, by the largest frequency itself"),
        ],
        rows: rows.collect(),
    };
    let own = table.rows.iter().zip(&offered);
    let unstable = own.filter(|(row, offer)| row.standing == Standing::Failed && **offer == asked);
    Section {
        title: "Stability".to_owned(),
        notes: Vec::new(),
        checks: 1,
        failures: unstable
            .map(|_| "the scene's time step is beyond the stable one".to_owned())
            .collect(),
        tables: vec![table],
        figures: Vec::new(),
    }
}
