//! What was found of stability, as a section of a sheet.

use super::{Found, Outcome, Stability};
use crate::report::sheet::Section;
use crate::table::{Cell, Column, Row, Standing, Table};
use cosmic::simulator::Grade;

impl Stability {
    /// The section, under the table of the case's own stable time steps.
    pub fn section(&self, own: Section) -> Section {
        let failed = self.found.iter().filter(|found| !found.is_ok());
        let mut failures = own.failures;
        failures.extend(failed.map(|f| format!("{}: {}", f.group, f.what)));
        // The bound must be one, to the last digits of the power iteration.
        let bound_holds = self.bound.least > 1.0 - 1e-9;
        if !bound_holds {
            failures.push("the bound is below the largest frequency".to_owned());
        }
        let mut tables = own.tables;
        tables.extend([self.extremes(), self.bounds(), self.costs()]);
        Section {
            title: own.title,
            notes: [own.notes, self.notes()].concat(),
            tables,
            figures: own.figures,
            checks: own.checks + self.found.len() + 1,
            failures,
        }
    }

    fn notes(&self) -> Vec<String> {
        let unstable = self.found.iter().filter(|f| !f.expected_stable()).count();
        let silent = self.found.iter().filter(|f| f.unannounced).count();
        vec![
            format!(
                "{} robots at the extremes, {unstable} of them with a time step that is expected \
                 to be unstable; numbers that were not finite and not announced: {silent}.",
                self.found.len()
            ),
            "A row is stable below the limit, the smallest time step with which the fastest \
             vibration about rest grows. A stable one must stay bounded; an unstable one must be \
             called so beforehand, and must grow."
                .to_owned(),
            "The energy of a robot without ground, gravity and actuation is watched; of one with \
             them the speed, against what drives it. growth is the most of it over what no stable \
             step reaches."
                .to_owned(),
        ]
    }

    fn extremes(&self) -> Table {
        Table {
            name: "extremes".to_owned(),
            title: "Robots at the extremes".to_owned(),
            columns: vec![
                Column::new("extreme", "what is extreme"),
                Column::new("what", "the robot"),
                Column::new("nodes", "nodes of its lattice"),
                Column::new("dt_s", "time step"),
                Column::new("bound_s", "stable for certain, by the bound over the edges"),
                Column::new("limit_s", "stable, by the largest frequency itself"),
                Column::new("expected", "stable or unstable, by the limit"),
                Column::new("said", "of the time step beforehand"),
                Column::new("outcome", "what happened"),
                Column::new("growth", "1 and more is growth"),
                Column::new("step", "that made a state absurd, where one did"),
                Column::new("verdict", "whether all is as it should be"),
            ],
            rows: self.found.iter().map(row).collect(),
        }
    }

    fn bounds(&self) -> Table {
        let bound = &self.bound;
        Table {
            name: "bound".to_owned(),
            title: "The bound on the largest frequency over that frequency, random lattices"
                .to_owned(),
            columns: vec![
                Column::new("lattices", "how many"),
                Column::new("least", "ratio"),
                Column::new("median", "ratio"),
                Column::new("most", "ratio"),
            ],
            rows: vec![plain(vec![
                bound.lattices.into(),
                Cell::Number(bound.least),
                Cell::Number(bound.median),
                Cell::Number(bound.most),
            ])],
        }
    }

    fn costs(&self) -> Table {
        let guard = &self.guard;
        Table {
            name: "guard".to_owned(),
            title: "What the guard against absurd states costs".to_owned(),
            columns: vec![
                Column::new(
                    "plain_us",
                    "microseconds a step, processor time, least of many",
                ),
                Column::new("guarded_us", "the same with the guard, measured by turns"),
                Column::new("added_percent", "what the guard adds, median over pairs"),
            ],
            rows: vec![plain(vec![
                Cell::Number(guard.plain),
                Cell::Number(guard.guarded),
                Cell::Number(100.0 * guard.share),
            ])],
        }
    }
}

fn plain(cells: Vec<Cell>) -> Row {
    Row {
        cells,
        standing: Standing::Plain,
    }
}

fn row(found: &Found) -> Row {
    let words = |truth: bool, [yes, no]: [&str; 2]| Cell::from(if truth { yes } else { no });
    let (outcome, step) = match &found.outcome {
        Outcome::Bounded => ("bounded".to_owned(), Cell::Missing),
        Outcome::Grew => ("grew".to_owned(), Cell::Missing),
        Outcome::Diverged(d) => (
            format!("diverged: node {}, {}", d.node, d.term),
            d.step.into(),
        ),
    };
    let said = match found.grade {
        Grade::Safe => "safe",
        Grade::Close => "close",
        Grade::Unstable => "unstable",
    };
    // Beyond all numbers once a state has blown up: how far is of no interest.
    let growth = Some(found.growth).filter(|_| found.outcome == Outcome::Bounded);
    let cells = vec![
        found.group.into(),
        Cell::Text(found.what.clone()),
        found.nodes.into(),
        Cell::Number(found.dt),
        Cell::if_finite(found.bound),
        Cell::if_finite(found.limit),
        words(found.expected_stable(), ["stable", "unstable"]),
        said.into(),
        Cell::Text(outcome),
        growth.into(),
        step,
        words(found.is_ok(), ["ok", "wrong"]),
    ];
    let standing = match (found.is_ok(), found.group) {
        (false, _) => Standing::Failed,
        (true, "scene") => Standing::Default,
        (true, _) => Standing::Plain,
    };
    Row { cells, standing }
}
