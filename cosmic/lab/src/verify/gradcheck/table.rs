//! The check of a gradient as text.

use std::fmt;

use autodiff::check::{Direction, WRONG_BY};

use super::{GradientCheck, Group, LIFT, NegativeControl, WORN};
use crate::table::Table;

impl Group {
    /// The direction with the worst verdict and error.
    fn worst(&self) -> &Direction {
        let rank = |row: &&Direction| (row.verdict, row.error);
        // An error that is NaN is not less than any other.
        let worse = |a, b| if rank(&b) < rank(&a) { a } else { b };
        let directions = self.report.directions.iter();
        directions.reduce(worse).expect("a check has a direction")
    }
}

/// A table with a row per group, for the direction with the worst verdict and error.
impl fmt::Display for GradientCheck {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let slope = |x: f64| format!("{x:.9e}");
        let forward = |group: &Group| group.worst().forward.unwrap_or(f64::NAN);
        let table = Table::of("gradcheck", "", &self.groups)
            .column("group", "a block of the inputs", |group| group.name.clone())
            .column("numbers", "how many", |group| group.numbers)
            .column("|gradient|", "its length", |g| format!("{:.4e}", g.norm))
            .column("reverse", "slope", |g| slope(g.worst().gradient))
            .column("forward", "slope", |g| slope(forward(g)))
            .column("differences", "slope", |g| slope(g.worst().central))
            .column("step", "of the differences", |g| {
                format!("{:.1e}", g.worst().step)
            })
            .column("error", "relative", |g| format!("{:.1e}", g.worst().error))
            .column("verdict", "on the group", |group| match group.is_zero() {
                true => "both zero".to_owned(),
                false => group.verdict.to_string(),
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
                "{}: nodes rest on the ground, a kink; the slopes belong to a robot lifted by {LIFT} m",
                lifted.join(", ")
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
                "the motion magnifies rounding to about {:.0e} of the slopes: take fewer steps",
                self.rounding
            )?;
        }
        match &self.control {
            Some(NegativeControl { group, verdict }) => write!(
                out,
                "negative control: the gradient by {group}, made wrong by {} %, is called {verdict}",
                100.0 * WRONG_BY
            ),
            None => write!(
                out,
                "negative control: none, because no group is smooth and steep enough for differences"
            ),
        }
    }
}
