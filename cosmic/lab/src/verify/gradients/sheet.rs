//! The accuracy of gradients as tables and figures.

use super::{DIRECTIONS, DRIVER, Gradients, Limit, MOST_MEMORY, Row, WAYS, WORTHLESS, Way};
use crate::report::chart::{Line, LogChart};
use crate::report::sheet::Section;
use crate::table::{Standing, Table};
use cosmic::case::Case;

/// Gradients of a case in every way. Ways that only rounding limits are checked.
pub fn gradients(case: &Case) -> Section {
    Gradients::of(case).section()
}

impl Row {
    /// Its state in a few words.
    fn status(&self) -> &'static str {
        match WAYS[self.way].limit {
            _ if self.left_out => "left out: too much memory",
            _ if !self.error.is_finite() => "failed: not finite",
            _ if self.is_wrong() => "failed: wrong",
            _ if self.is_checked() => "checked",
            Limit::Truncation if self.angle > 90.0 => "useless: against the gradient",
            Limit::Truncation => "truncated",
            _ if self.error > WORTHLESS => "useless: not two digits",
            _ => "ok",
        }
    }
}

impl Gradients {
    pub(super) fn section(&self) -> Section {
        let mut section = Section {
            title: "Gradients".to_owned(),
            notes: self.notes(),
            tables: vec![self.table(), self.chaos.table()],
            figures: vec![self.by_horizon(), self.by_time()],
            ..Section::default()
        };
        for row in self.rows.iter().filter(|row| row.is_checked()) {
            let failure = format!("{} over {} steps", WAYS[row.way].name, row.steps);
            section.check(!row.is_wrong(), failure);
        }
        section
    }

    fn notes(&self) -> Vec<String> {
        [
            &self.chaos.note()[..],
            &format!(
                "Gradients of minus the payload's position along the ground after so many steps, by \
                 the {} numbers of design and controller. `error` and `angle`: of the slopes along \
                 {DIRECTIONS} random directions, from those of duals in double-double. Until a \
                 payload leaves the ground the gradient is exactly zero, and so is its error.",
                self.numbers
            ),
            &format!(
                "`time`: processor time of one thread, of a whole gradient in reverse mode, of \
                 {DIRECTIONS} slopes forward and by differences. `whole`: of a whole gradient; for \
                 the latter two a multiple, not a measurement. `memory`: the most that was held in \
                 addition to what the program held before; do not trust numbers below 1 MiB."
            ),
            &format!(
                "Exact ways are checked against the truth as long as rounding leaves them two \
                 digits. `allowed`: 128 x 128 roundings, and 16 times what the slopes change if the \
                 start is moved as far as rounding moves the motion. A full tape that would take \
                 more than {} GiB is left out.",
                MOST_MEMORY >> 30
            ),
            "Truncated gradients leave the early steps out: their error is the cost of that, not \
             rounding.",
        ]
        .map(str::to_owned)
        .to_vec()
    }

    fn table(&self) -> Table {
        let title = "Error, time and memory over horizons";
        let (angle, whole) = ("between the two vectors of slopes", "of a whole gradient");
        let error = "length of the slopes' error over that of the slopes";
        let allowed = "the error that rounding explains in an exact way in f64";
        let memory = "peak memory beyond what was held before";
        let known = |row: &Row, x: f64| (!row.left_out).then_some(x);
        let is_failed = |row: &Row| row.status().starts_with("failed");
        let mebibytes = |bytes: u64| bytes as f64 / f64::from(1 << 20);
        Table::of("gradients", title, &self.rows)
            .column("way", "how the gradient is computed", |row| {
                WAYS[row.way].name
            })
            .column("steps", "the horizon", |row| row.steps)
            .column("error", error, |row| known(row, row.error))
            .column("allowed", allowed, |row| row.allowed)
            .column("angle_deg", angle, |row| known(row, row.angle))
            .column("time_s", "processor time", |row| known(row, row.time))
            .column("whole_s", whole, |row| known(row, row.whole))
            .column("memory_mib", memory, |row| row.memory.map(mebibytes))
            .column("status", "the outcome", |row| row.status())
            .mark(Standing::Default, |row| row.way == DRIVER)
            .mark(Standing::Failed, is_failed)
            .done()
    }

    fn by_horizon(&self) -> LogChart {
        LogChart {
            name: "gradient_error",
            caption: "Error against the horizon.".to_owned(),
            title: "Relative error of the slopes".to_owned(),
            along: "steps of the horizon".to_owned(),
            lines: self.lines(|row| [row.steps as f64, row.error]),
            marked: None,
        }
    }

    fn by_time(&self) -> LogChart {
        let longest = self.rows.iter().rfind(|row| row.way == DRIVER);
        let point = |row: &Row| [row.whole, row.error];
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

    /// A line for every way.
    fn lines(&self, point: impl Fn(&Row) -> [f64; 2]) -> Vec<Line> {
        let line = |(k, way): (usize, &Way)| {
            let dashes = match way.limit {
                Limit::Truncation => "1 5",
                Limit::Single => "6 4",
                _ => "",
            };
            let rows = self.rows.iter().filter(|row| row.way == k);
            Line::new(way.name.to_owned(), k, dashes, rows.map(&point))
        };
        WAYS.iter().enumerate().map(line).collect()
    }
}
