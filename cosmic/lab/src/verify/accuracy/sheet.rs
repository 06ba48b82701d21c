//! The accuracy of trajectories as tables and figures.

use super::{Accuracy, DOUBLE, FINER, Method, PRECISIONS, RESOLVED, Run};
use crate::report::chart::{Line, LogChart};
use crate::report::sheet::Section;
use crate::table::{Cell, Standing, Table, TableOf};
use cosmic::case::Case;
use std::ops::Range;

/// The index of the time that the figures show: the second, before chaos dominates.
const SHOWN: usize = 1;

/// Trajectories of a case in every way to run it. Rows with a stable step in f32 and f64 are checked, and
/// that neither the default nor the reference diverged.
pub fn accuracy(case: &Case) -> Section {
    Accuracy::of(case).section()
}

impl Run {
    /// True if its error comes from its time step.
    pub(super) fn is_sound(&self) -> bool {
        self.finite && self.stable
    }

    /// True if the run diverged although its time step is stable, or although it uses the scene's own
    /// time step.
    pub(super) fn is_failed(&self) -> bool {
        !self.finite && (self.stable || self.is_default)
    }

    /// A number of the run. If the time step is above the stable one, a number that is not finite is
    /// missing and no failure, because divergence is expected.
    fn number(&self, x: f64) -> Cell {
        if self.stable || self.is_default {
            x.into()
        } else {
            Cell::if_finite(x)
        }
    }

    /// Its state in a few words.
    fn status(&self, spacing: f64) -> &'static str {
        match (self.finite, self.stable) {
            _ if self.is_failed() => "diverged",
            (false, _) => "diverged as expected: step beyond the stable one",
            (true, false) => "step beyond the stable one",
            (true, true) if self.error[3].is_some_and(|e| e > 0.1 * spacing) => "parted",
            (true, true) => "ok",
        }
    }
}

impl Accuracy {
    /// True if the sums of a step and the growth of perturbations explain the rounding at the first
    /// time: 7 binary digits for the former, and 7 for sums over the steps. Chaos dominates later.
    fn rounds_well(&self, run: &Run) -> bool {
        let growth = self.chaos.growth(self.marks[0]);
        run.rounding[0] <= 128.0 * 128.0 * PRECISIONS[run.precision].unit * growth
    }

    pub(super) fn section(&self) -> Section {
        let mut section = Section {
            title: "Accuracy of trajectories".to_owned(),
            notes: self.notes(),
            tables: vec![self.table(), self.parts_table(), self.chaos.table()],
            figures: vec![self.work_precision(), self.over_time()],
            ..Section::default()
        };
        let counts = |run: &&Run| run.stable && run.precision <= DOUBLE;
        for run in self.runs.iter().filter(counts) {
            let (method, precision) = (run.method.name(), PRECISIONS[run.precision].name);
            let failure = format!("rounding of {method}, dt {}, {precision}", run.dt);
            section.check(self.rounds_well(run), failure);
        }
        section.check(self.default_run().finite, "the scene's own run diverged");
        let failure = "the reference of the errors diverged";
        section.check(self.reference.is_sound(), failure);
        section
    }

    fn notes(&self) -> Vec<String> {
        let [a, b, c, d] = self.times;
        let apart = self.reference.uncertainty.map(|u| format!("{u:.1e}"));
        [
            &(self.chaos.note() + &self.parting())[..],
            &format!(
                "`error`: the largest distance of a node, m, at {a}, {b}, {c} and {d} s from \
                 leapfrog with time steps {FINER} times shorter than the scene's. That reference is \
                 off by {} m: its distance from symplectic Euler with the same steps, or from \
                 leapfrog with steps twice as long, whichever is larger. An error below {RESOLVED} \
                 times that may be off by more than a third, and its cell is empty.",
                apart.join(", ")
            ),
            "`order`: the power of the time step with which `error` falls from the row with the \
             step twice as long, the median over the times. The controller's output is held over a \
             step, which is of first order with any integrator, and so are contacts.",
            "`rounding`: the distance from a double-double run with the same steps. `energy_ripple` \
             and `energy_drift`: shares of the energy of the lattice stretched by 2 % and let go \
             without damping, gravity, ground or controller.",
            "Times are medians of processor times of one thread, measured while nothing else of \
             this program runs.",
        ]
        .map(str::to_owned)
        .to_vec()
    }

    /// The time at which the default's error has grown to the distance of two nodes; empty if nothing
    /// grows or no error was resolved.
    fn parting(&self) -> String {
        let doubling = self.chaos.doubling;
        let error = self.default_run().error[0].unwrap_or(f64::NAN);
        // From the first time on the error grows like a perturbation.
        let parted = self.marks[0] as f64 + (self.spacing / error).log2() * doubling;
        if !(doubling.is_finite() && parted.is_finite()) {
            return String::new();
        }
        format!(
            " At that rate the default's error, {error:.1e} m at {} s, grows to the distance of two \
             nodes after {parted:.0} steps ({:.2} s). Later errors compare two different motions.",
            self.times[0],
            parted * self.chaos.dt
        )
    }

    fn table(&self) -> Table {
        let time = "median processor time of the whole run, s";
        let error = "m, from the reference; empty where not resolved";
        let order = "power of the time step with which the error falls";
        self.rows("accuracy", "Error against run time")
            .column("time_s", time, |run| run.number(run.time))
            .columns(self.timed("error"), error, |run, k| {
                run.error[k].map_or(Cell::Missing, |x| run.number(x))
            })
            .column("order", order, |run| run.order)
            .column("status", "the outcome", |run| run.status(self.spacing))
            .done()
    }

    fn parts_table(&self) -> Table {
        let rounding = "m, from double-double with the same steps";
        let ripple = "largest departure from the energy, a share";
        let drift = "last quarter less first, a share";
        self.rows(
            "accuracy_parts",
            "Rounding, and the energy of free vibrations",
        )
        .columns(self.timed("rounding"), rounding, |run, k| {
            run.number(run.rounding[k])
        })
        .column("energy_ripple", ripple, |run| run.number(run.energy.ripple))
        .column("energy_drift", drift, |run| run.number(run.energy.drift))
        .done()
    }

    /// The names of columns with one number for each of the times.
    fn timed(&self, kind: &str) -> [String; 4] {
        self.times.map(|time| format!("{kind}_{time}"))
    }

    /// A table of the runs with the columns that identify a run.
    fn rows(&self, name: &str, title: &str) -> TableOf<'_, Run> {
        let method = "integrator, and substeps where there are more than one";
        let dt = "time step of the controller, s";
        let precision = |run: &Run| PRECISIONS[run.precision].name;
        Table::of(name, title, &self.runs)
            .mark(Standing::Default, |run| run.is_default)
            .mark(Standing::Failed, Run::is_failed)
            .column("method", method, |run| run.method.name())
            .column("dt_s", dt, |run| run.dt)
            .column("precision", "number type", precision)
    }

    fn work_precision(&self) -> LogChart {
        let time = self.times[SHOWN];
        let point = |run: &Run| [run.time, shown(run.error)];
        LogChart {
            name: "work_precision",
            caption: format!(
                "Error at {time} s against run time; along each line the time step is halved four \
                 times. Whole lines f64, dashed f32, dotted double-double. Errors that are not \
                 resolved are left out."
            ),
            title: format!("Largest error of a node at {time} s, m"),
            along: format!("run time of {} s of motion, s", self.times[3]),
            lines: self.lines(0..PRECISIONS.len(), point),
            marked: self.marked(point),
        }
    }

    fn over_time(&self) -> LogChart {
        let point = |run: &Run| [run.dt, shown(run.error)];
        LogChart {
            name: "order",
            caption: "Error in f64 against the time step.".to_owned(),
            title: format!("Largest error of a node at {} s, m", self.times[SHOWN]),
            along: "time step, s".to_owned(),
            lines: self.lines(DOUBLE..DOUBLE + 1, point),
            marked: self.marked(point),
        }
    }

    /// The default's point, if it has one.
    fn marked(&self, point: impl Fn(&Run) -> [f64; 2]) -> Option<([f64; 2], String)> {
        let default = Some(self.default_run()).filter(|run| run.is_sound());
        let point = default.map(point).filter(|[_, error]| error.is_finite());
        point.map(|point| (point, "default".to_owned()))
    }

    /// A line for every method in some number types.
    pub(super) fn lines(
        &self,
        precisions: Range<usize>,
        point: impl Fn(&Run) -> [f64; 2],
    ) -> Vec<Line> {
        let mut methods: Vec<Method> = self.runs.iter().map(|run| run.method).collect();
        methods.dedup();
        let mut lines = Vec::new();
        for precision in precisions {
            for (k, method) in methods.iter().enumerate() {
                let belongs = |run: &&Run| (run.method, run.precision) == (*method, precision);
                // The errors of runs that went astray would press all others into one line.
                let sound = self.runs.iter().filter(|run| run.is_sound());
                let points = sound.filter(belongs).map(&point);
                let name = format!("{}, {}", method.name(), PRECISIONS[precision].name);
                lines.push(Line::new(name, k, PRECISIONS[precision].dashes, points));
            }
        }
        lines
    }
}

/// The error that a figure shows; NaN, which is left out, if it is not resolved.
fn shown(errors: [Option<f64>; 4]) -> f64 {
    errors[SHOWN].unwrap_or(f64::NAN)
}
