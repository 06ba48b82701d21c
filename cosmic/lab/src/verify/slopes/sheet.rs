//! The accuracy of gradients as tables and figures.

use super::{DIRECTIONS, Gradients, MOST_MEMORY, Slopes, Way, best};
use crate::report::chart::{Line, LogChart};
use crate::report::sheet::Section;
use crate::table::{Standing, Table};
use cosmic::geometry::Vector;

impl Gradients {
    /// The section of the sheet. Rows are checked, and horizons at which there is a full tape.
    pub fn section(&self) -> Section {
        let mut section = Section {
            title: "Gradients".to_owned(),
            notes: self.notes(),
            tables: vec![
                self.table(),
                self.sweep_table(),
                self.horizon_table(),
                self.chaos.table(),
            ],
            figures: vec![self.by_horizon(), self.by_time(), self.by_width()],
            ..Section::default()
        };
        for row in self.slopes.iter().filter(|row| self.is_checked(row)) {
            let failure = format!("{} over {} steps", row.way.name(), row.steps);
            section.check(!self.is_wrong(row), failure);
        }
        for (&steps, &difference) in self.horizons.iter().zip(&self.driver_against_tape) {
            let failure = format!("driver against full tape over {steps} steps");
            section.check(self.may_differ(steps, difference), failure);
        }
        section
    }

    fn notes(&self) -> Vec<String> {
        [
            &self.chaos.note()[..],
            &format!(
                "Of minus the payload's position along the ground after so many steps, by the {} \
                 numbers of design and controller. `error` and `angle`: of the slopes along \
                 {DIRECTIONS} random directions, from those of duals in double-double. As long as a \
                 payload has not left the ground the gradient is zero exactly, and so is its error.",
                self.numbers
            ),
            &format!(
                "`time`: processor time of one thread, of a whole gradient in reverse, of \
                 {DIRECTIONS} slopes forward and by differences. `whole`: of a whole gradient; for \
                 the latter two a multiple, not a measurement. `memory`: the most that was held \
                 beyond what the program held before; below 1 MiB not to be trusted."
            ),
            &format!(
                "Exact ways are checked against the truth as long as rounding leaves them two \
                 digits: it may cost 128 x 128 roundings, and 16 times what the slopes change \
                 where the start is moved as far as rounding moves the motion. Driver and full \
                 tape may differ by twice that, in parts of the largest entry. A full tape that \
                 would take more than {} GiB is left out.",
                MOST_MEMORY >> 30
            ),
            "Truncated gradients leave the early steps out: their error is what that costs, not \
             rounding.",
        ]
        .map(str::to_owned)
        .to_vec()
    }

    fn table(&self) -> Table {
        let title = "Error, time and memory over horizons";
        let (angle, whole) = ("between the two vectors of slopes", "of a whole gradient");
        let status = "what is to be said of the row";
        let error = "length of the slopes' error over that of the slopes";
        let memory = "peak memory beyond what was held before";
        let known = |row: &Slopes, x: f64| (!row.left_out).then_some(x);
        let is_failed = |row: &Slopes| self.status(row).starts_with("failed");
        let mebibytes = |bytes: u64| bytes as f64 / f64::from(1 << 20);
        Table::of("gradients", title, &self.slopes)
            .column("way", "how the gradient is computed", |row| row.way.name())
            .column("steps", "the horizon", |row| row.steps)
            .column("error", error, |row| known(row, row.error))
            .column("angle_deg", angle, |row| known(row, row.angle))
            .column("time_s", "processor time", |row| known(row, row.time))
            .column("whole_s", whole, |row| known(row, row.whole))
            .column("memory_mib", memory, |row| row.memory.map(mebibytes))
            .column("status", status, |row| self.status(row))
            .mark(Standing::Default, |row| row.way == Way::Driver)
            .mark(Standing::Failed, is_failed)
            .done()
    }

    fn status(&self, row: &Slopes) -> &'static str {
        match row.way {
            _ if row.left_out => "left out: too much memory",
            _ if !row.error.is_finite() => "failed: not finite",
            _ if self.is_wrong(row) => "failed: wrong",
            _ if self.is_checked(row) => "checked",
            Way::Truncated(_) if row.angle > 90.0 => "useless: against the gradient",
            Way::Truncated(_) => "truncated",
            _ if row.error > super::WORTHLESS => "useless: not two digits",
            _ => "ok",
        }
    }

    /// Errors of central differences, a row per half-width, a column per horizon.
    fn sweep_table(&self) -> Table {
        let title = "Error of central differences by half-width";
        let names = self.horizons.iter().map(|steps| format!("error_{steps}"));
        let width = "half-width along a direction of length one";
        Table::of("differences", title, &self.sweep)
            .column("h", width, |row| row.0)
            .columns(names, "at this horizon", |row, k| row.1[k])
            .done()
    }

    /// The properties of the gradient, a row per horizon.
    fn horizon_table(&self) -> Table {
        let moved = "the most that the slopes change, as a share, from starts moved by 1e-9 m";
        let rounding = "how far rounding in f64 moves a node at most until then";
        let allowed = "the error that these explain in an exact way in f64";
        let tape = "largest difference of the two gradients over the largest entry";
        let steps = |k: usize| self.horizons[k];
        let against_tape = |k: usize| self.driver_against_tape.get(k).copied();
        let agrees = |k: usize| against_tape(k).is_none_or(|off| self.may_differ(steps(k), off));
        let horizons: Vec<usize> = (0..self.horizons.len()).collect();
        Table::of("horizons", "The gradient over horizons", &horizons)
            .column("steps", "the horizon", |&k| steps(k))
            .column("moved_by_1e-9", moved, |&k| self.moved[k])
            .column("rounding_m", rounding, |&k| self.rounding[k])
            .column("allowed", allowed, |&k| self.tolerance(steps(k)))
            .column("driver_against_tape", tape, |&k| against_tape(k))
            .mark(Standing::Failed, |&k| !agrees(k))
            .done()
    }

    fn by_horizon(&self) -> LogChart {
        LogChart {
            name: "gradient_error",
            caption: "Error against the horizon.".to_owned(),
            title: "Relative error of the slopes".to_owned(),
            along: "steps of the horizon".to_owned(),
            lines: self.lines(|row| [row.steps as f64, row.error].into()),
            marked: None,
        }
    }

    fn by_time(&self) -> LogChart {
        let longest = self.slopes.iter().rfind(|row| row.way == Way::Driver);
        let point = |row: &Slopes| Vector::new([row.whole, row.error]);
        LogChart {
            name: "gradient_time",
            caption: "Error against the time of a whole gradient; along each line the horizon \
                      doubles."
                .to_owned(),
            title: "Relative error of the slopes".to_owned(),
            along: "time of a whole gradient, s".to_owned(),
            lines: self.lines(point),
            marked: longest.map(|row| (point(row), format!("driver, {} steps", row.steps))),
        }
    }

    fn by_width(&self) -> LogChart {
        let line = |(k, steps): (usize, &usize)| {
            let name = format!("{steps} steps, best {:.1e}", best(&self.sweep, k).1);
            Line::new(name, k, "", self.sweep.iter().map(|(h, e)| [*h, e[k]]))
        };
        LogChart {
            name: "differences",
            caption: "Central differences: too wide, and they see another function; too narrow, \
                      and they see rounding."
                .to_owned(),
            title: "Relative error of central differences".to_owned(),
            along: "half-width h along a direction of length one".to_owned(),
            lines: self.horizons.iter().enumerate().map(line).collect(),
            marked: None,
        }
    }

    /// A line for every way.
    fn lines(&self, point: impl Fn(&Slopes) -> Vector<f64>) -> Vec<Line> {
        let line = |(k, way): (usize, &Way)| {
            let dashes = match way {
                Way::Truncated(_) => "1 5",
                _ if way.is_single() => "6 4",
                _ => "",
            };
            let rows = self.slopes.iter().filter(|row| row.way == *way);
            Line::new(way.name(), k, dashes, rows.map(&point))
        };
        Way::ALL.iter().enumerate().map(line).collect()
    }
}
