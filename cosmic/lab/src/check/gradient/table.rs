//! The result of a gradient check as text.

use std::fmt;

use autodiff::check::{Direction, Verdict, WRONG_BY};

use super::{GradientCheck, Group, NegativeControl, Perturbation, WORN};
use crate::table::{Emphasis, Table};

impl Group {
    /// The direction with the worst verdict. If several directions have that verdict, the one with the largest error.
    fn worst(&self) -> &Direction {
        let rank = |row: &&Direction| (row.verdict, row.error);
        // An error of NaN counts as the worst.
        let worse = |a, b| if rank(&b) < rank(&a) { a } else { b };
        let directions = self.report.directions.iter();
        directions
            .reduce(worse)
            .expect("a check has at least one direction")
    }
}

impl GradientCheck {
    /// A table with a row for each group, which shows the direction with the worst verdict.
    pub(super) fn table(&self) -> Table {
        let slope = |x: f64| format!("{x:.9e}");
        let forward = |group: &Group| group.worst().forward.unwrap_or(f64::NAN);
        let verdict = |group: &Group| match group.is_empty(self.rounding) {
            true => "nothing compared".to_owned(),
            false => group.verdict.to_string(),
        };
        let error = "relative error";
        Table::of("gradient", "Slopes along random directions", &self.groups)
            .column("group", "a block of the inputs", |group| group.name.clone())
            .column("numbers", "the number of parameters", |group| group.numbers)
            .column("|gradient|", "the norm of the gradient", |g| {
                format!("{:.4e}", g.norm)
            })
            .column("reverse", "slope", |g| slope(g.worst().gradient))
            .column("forward", "slope", |g| slope(forward(g)))
            .column("differences", "slope", |g| slope(g.worst().central))
            .column("step", "the step of the finite differences", |g| {
                format!("{:.1e}", g.worst().step)
            })
            .column("error", error, |g| format!("{:.1e}", g.worst().error))
            .column("verdict", "the verdict on the group", verdict)
            .mark(Emphasis::Failed, |g| {
                g.verdict == Verdict::Wrong || g.is_empty(self.rounding)
            })
            .done()
    }

    /// Sentences about the groups that need an explanation, and about the negative control.
    pub(super) fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if self.perturbation != Perturbation::No {
            notes.push(format!(
                "{}: at the robot's own start the loss does not depend on them; all slopes are those of {}",
                self.still.join(", "),
                self.perturbation
            ));
        }
        if self.groups.iter().all(|group| group.name != "z") {
            notes.push(
                "z: left out, because every edge has one material, so that the design has no variables".to_owned(),
            );
        }
        let lifted = self.groups.iter().filter(|group| group.lifted);
        let lifted: Vec<&str> = lifted.map(|group| &group.name[..]).collect();
        if !lifted.is_empty() {
            notes.push(format!(
                "{}: nodes start on the ground, where the loss has a kink; the slopes are those of a robot lifted by {} m",
                lifted.join(", "),
                self.lift
            ));
        }
        if let Some(moving) = self.groups.iter().find(|group| group.moving) {
            notes.push(format!(
                "{}: at rest the force of the law `actuator` has a kink; the slopes are those of a robot whose nodes move",
                moving.name
            ));
        }
        let empty = self.empty();
        if !empty.is_empty() {
            notes.push(format!(
                "{}: nothing could be compared, because the loss does not depend on them here; try more --steps or \
                 another scene",
                empty.join(", ")
            ));
        }
        if self.rounding > WORN {
            notes.push(format!(
                "the motion magnifies rounding errors to about {:.0e} of the slopes; use fewer --steps",
                self.rounding
            ));
        }
        notes.push(match &self.control {
            Some(NegativeControl { group, verdict }) => format!(
                "negative control: the gradient with respect to {group}, made wrong by {} %, is called {verdict}",
                100.0 * WRONG_BY
            ),
            None => "negative control: none, because no group has a smooth gradient that is large enough for differences"
                .to_owned(),
        });
        notes
    }
}

/// Writes the table and the notes below it.
impl fmt::Display for GradientCheck {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}{}", self.table().to_text(), self.notes().join("\n"))
    }
}
