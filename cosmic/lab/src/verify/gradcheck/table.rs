//! The result of a gradient check as text.

use std::fmt;

use autodiff::check::{Direction, WRONG_BY};

use super::{GradientCheck, Group, Moved, NegativeControl, WORN};
use crate::table::Table;

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

/// Writes a table and notes below it. Each row of the table shows the direction of a group that has the worst verdict.
impl fmt::Display for GradientCheck {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let slope = |x: f64| format!("{x:.9e}");
        let forward = |group: &Group| group.worst().forward.unwrap_or(f64::NAN);
        let table = Table::of("gradcheck", "", &self.groups)
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
            .column("error", "relative", |g| format!("{:.1e}", g.worst().error))
            .column("verdict", "the verdict on the group", |group| {
                match group.is_empty(self.rounding) {
                    true => "nothing compared".to_owned(),
                    false => group.verdict.to_string(),
                }
            });
        write!(out, "{}", table.done().to_text())?;
        if self.moved != Moved::No {
            writeln!(
                out,
                "{}: at the robot's own start the loss does not depend on them; all slopes are those of {}",
                self.still.join(", "),
                self.moved
            )?;
        }
        if self.groups.iter().all(|group| group.name != "z") {
            writeln!(
                out,
                "z: left out, because every edge has one material, so that the design has no variables"
            )?;
        }
        let lifted = self.groups.iter().filter(|group| group.lifted);
        let lifted: Vec<&str> = lifted.map(|group| &group.name[..]).collect();
        if !lifted.is_empty() {
            writeln!(
                out,
                "{}: nodes start on the ground, where the loss has a kink; the slopes are those of a \
                 robot lifted by {} m",
                lifted.join(", "),
                self.lift
            )?;
        }
        let empty = self.empty();
        if !empty.is_empty() {
            writeln!(
                out,
                "{}: nothing could be compared, because the loss does not depend on them here; try more --steps or \
                 another scene",
                empty.join(", ")
            )?;
        }
        if self.rounding > WORN {
            writeln!(
                out,
                "the motion magnifies rounding errors to about {:.0e} of the slopes; use fewer steps",
                self.rounding
            )?;
        }
        match &self.control {
            Some(NegativeControl { group, verdict }) => write!(
                out,
                "negative control: the gradient with respect to {group}, made wrong by {} %, is called {verdict}",
                100.0 * WRONG_BY
            ),
            None => write!(
                out,
                "negative control: none, because no group has a smooth gradient that is large enough for differences"
            ),
        }
    }
}
