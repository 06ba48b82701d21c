//! The results on stability as a section of a sheet.

use super::{Found, Outcome, Stability};
use crate::report::sheet::Section;
use crate::table::{Cell, Standing, Table};
use cosmic::simulator::Grade;
use std::slice::from_ref;

impl Stability {
    /// Adds the results to the section on the case's own stable time steps.
    pub fn section(&self, mut section: Section) -> Section {
        for found in &self.found {
            section.check(found.is_ok(), format!("{}: {}", found.group, found.what));
        }
        // The bound must be one, to the last digits of the power iteration; NaN is none.
        let bound_holds = self.bound.least > 1.0 - 1e-9;
        section.check(bound_holds, "the bound is below the largest frequency");
        let tables = [self.extremes(), self.bounds(), self.costs()];
        section.tables.extend(tables);
        section.notes.extend(self.notes());
        section
    }

    fn notes(&self) -> Vec<String> {
        let unstable = self.found.iter().filter(|f| !f.expected_stable()).count();
        let silent = self.found.iter().filter(|f| f.unannounced).count();
        let robots = self.found.len();
        let counts = format!(
            "{robots} robots at the extremes, {unstable} of them with a time step that is expected \
             to be unstable; numbers that were not finite and not announced: {silent}."
        );
        [
            &counts,
            "A row is stable below the limit, the smallest time step with which the fastest \
             vibration about rest grows. A stable one must stay bounded; an unstable one must be \
             called so beforehand, and must grow.",
            "The energy of a robot without ground, gravity and actuation is watched; of one with \
             them the speed, against what drives it. growth is the most of it over what no stable \
             step reaches.",
        ]
        .map(str::to_owned)
        .to_vec()
    }

    fn extremes(&self) -> Table {
        let bound = "stable for certain, by the bound over the edges";
        let limit = "stable, by the largest frequency itself";
        let expected = "stable or unstable, by the limit";
        let said = "of the time step beforehand";
        let step = "that made a state absurd, where one did";
        let verdict = "whether all is as it should be";
        let judged = |found: &Found| if found.is_ok() { "ok" } else { "wrong" };
        Table::of("extremes", "Robots at the extremes", &self.found)
            .column("extreme", "what is extreme", |found| found.group)
            .column("what", "the robot", |found| found.what.clone())
            .column("nodes", "nodes of its lattice", |found| found.nodes)
            .column("dt_s", "time step", |found| found.dt)
            .column("bound_s", bound, |found| Cell::if_finite(found.bound))
            .column("limit_s", limit, |found| Cell::if_finite(found.limit))
            .column("expected", expected, |found| {
                let stable = found.expected_stable();
                if stable { "stable" } else { "unstable" }
            })
            .column("said", said, |found| match found.grade {
                Grade::Safe => "safe",
                Grade::Close => "close",
                Grade::Unstable => "unstable",
            })
            .column("outcome", "what happened", |found| match &found.outcome {
                Outcome::Bounded => "bounded".to_owned(),
                Outcome::Grew => "grew".to_owned(),
                Outcome::Diverged(d) => format!("diverged: node {}, {}", d.node, d.term),
            })
            .column("growth", "1 and more is growth", |found| {
                // A state that blew up has a growth beyond all numbers, which says nothing.
                (found.outcome == Outcome::Bounded).then_some(found.growth)
            })
            .column("step", step, |found| match &found.outcome {
                Outcome::Diverged(divergence) => divergence.step.into(),
                Outcome::Bounded | Outcome::Grew => Cell::Missing,
            })
            .column("verdict", verdict, judged)
            .mark(Standing::Default, |found| found.group == "scene")
            .mark(Standing::Failed, |found| !found.is_ok())
            .done()
    }

    fn bounds(&self) -> Table {
        let title = "The bound on the largest frequency over that frequency, random lattices";
        Table::of("bound", title, from_ref(&self.bound))
            .column("lattices", "how many", |bound| bound.lattices)
            .column("least", "ratio", |bound| bound.least)
            .column("median", "ratio", |bound| bound.median)
            .column("most", "ratio", |bound| bound.most)
            .done()
    }

    fn costs(&self) -> Table {
        let title = "What the guard against absurd states costs";
        let plain = "microseconds a step, processor time, least of many";
        let guarded = "the same with the guard, measured by turns";
        let added = "what the guard adds, median over pairs";
        Table::of("guard", title, from_ref(&self.guard))
            .column("plain_us", plain, |guard| guard.plain)
            .column("guarded_us", guarded, |guard| guard.guarded)
            .column("added_percent", added, |guard| 100.0 * guard.share)
            .done()
    }
}
