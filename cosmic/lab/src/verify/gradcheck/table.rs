//! The result of a gradient check as text.

use std::fmt;

use autodiff::check::{Direction, WRONG_BY};

use super::{GradientCheck, Group, NegativeControl, WORN};
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
                match group.is_zero() {
                    true => "both zero".to_owned(),
                    false => group.verdict.to_string(),
                }
            });
        write!(out, "{}", table.done().to_text())?;
        let names = |is: fn(&Group) -> bool| -> Vec<&str> {
            let groups = self.groups.iter().filter(|group| is(group));
            groups.map(|group| &group.name[..]).collect()
        };
        let (lifted, zero) = (names(|group| group.lifted), names(Group::is_zero));
        if !lifted.is_empty() {
            writeln!(
                out,
                "{}: nodes start on the ground, where the loss has a kink; the slopes are those of a \
                 robot lifted by {} m",
                lifted.join(", "),
                self.lift
            )?;
        }
        if !zero.is_empty() {
            writeln!(
                out,
                "{}: the gradient is zero, and so are the differences; the loss does not depend on them \
                 here",
                zero.join(", ")
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
