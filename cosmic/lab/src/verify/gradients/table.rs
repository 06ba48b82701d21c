//! The check of a gradient as text.

use std::fmt;

use autodiff::check::{Direction, WRONG_BY};

use super::{GradientCheck, Group, LIFT, NegativeControl, WORN};

/// A table with a row per group: its direction with the worst verdict and error.
impl fmt::Display for GradientCheck {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            out,
            "{:<6}{:>8}{:>13}{:>18}{:>18}{:>18}{:>10}{:>10}  verdict",
            "group", "numbers", "|gradient|", "reverse", "forward", "differences", "step", "error"
        )?;
        for group in &self.groups {
            write_row(out, group)?;
        }
        let names = |is: fn(&Group) -> bool| -> Vec<&str> {
            let groups = self.groups.iter().filter(|group| is(group));
            groups.map(|group| &group.name[..]).collect()
        };
        let (lifted, zero) = (names(|group| group.lifted), names(Group::is_zero));
        if !lifted.is_empty() {
            writeln!(
                out,
                "{}: nodes rest on the ground, a kink; the slopes are those of a robot {LIFT} m above",
                lifted.join(", ")
            )?;
        }
        if !zero.is_empty() {
            writeln!(
                out,
                "{}: the gradient is zero, and so are the differences; this shows only that the loss \
                 does not depend on them here",
                zero.join(", ")
            )?;
        }
        if self.rounding > WORN {
            writeln!(
                out,
                "the motion magnifies rounding to some {:.0e} of the slopes: take fewer steps",
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
                "negative control: none, no group is smooth and steep enough for differences"
            ),
        }
    }
}

fn write_row(out: &mut fmt::Formatter<'_>, group: &Group) -> fmt::Result {
    let Group { name, norm, .. } = group;
    write!(out, "{name:<6}{:>8}{norm:>13.4e}", group.numbers)?;
    let rank = |row: &&Direction| (row.verdict, row.error);
    // An error that is NaN is not less than any other.
    let worse = |a, b| if rank(&b) < rank(&a) { a } else { b };
    if let Some(row) = group.report.directions.iter().reduce(worse) {
        let forward = row.forward.unwrap_or(f64::NAN);
        write!(
            out,
            "{:>18.9e}{forward:>18.9e}{:>18.9e}{:>10.1e}{:>10.1e}",
            row.gradient, row.central, row.step, row.error
        )?;
    }
    if group.is_zero() {
        writeln!(out, "  both zero")
    } else {
        writeln!(out, "  {}", group.verdict)
    }
}
