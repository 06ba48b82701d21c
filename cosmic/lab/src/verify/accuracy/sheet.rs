//! The accuracy of trajectories as tables and figures.

use super::reference::{FINER, RESOLVED};
use super::{Accuracy, Method, Precision, Run};
use crate::report::chart::{Line, LogChart};
use crate::report::sheet::Section;
use crate::table::{Cell, Standing, Table, TableOf};
use cosmic::geometry::Vector;
use std::iter::once;

/// The index of the time that the plots show: the second, before chaos dominates.
const SHOWN: usize = 1;

impl Run {
    /// True if its error comes from its time step.
    pub(super) fn is_sound(&self) -> bool {
        self.finite && self.stable
    }

    /// True if the run diverged although its time step is stable, or although it uses the scene's own time step.
    pub(super) fn is_failed(&self) -> bool {
        !self.finite && (self.stable || self.is_default)
    }

    /// A number of the run. If the time step is above the stable time step, a number that is not finite counts as
    /// missing and not as a failure, because divergence is expected.
    fn number(&self, x: f64) -> Cell {
        if self.stable || self.is_default {
            x.into()
        } else {
            Cell::if_finite(x)
        }
    }

    /// Its state in a few words.
    pub fn status(&self, spacing: f64) -> &'static str {
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
    /// time: 7 binary digits for the former, and 7 for sums over the steps. Chaos rules at later
    /// times.
    fn rounds_well(&self, run: &Run) -> bool {
        let unit = match run.precision {
            Precision::Single => f64::from(f32::EPSILON),
            Precision::Double | Precision::DoubleDouble => f64::EPSILON,
        };
        let growth = self.chaos.growth(self.marks[0]);
        run.rounding[0] <= 128.0 * 128.0 * unit * growth
    }

    /// The section of the sheet. Rows with a stable step in f32 and f64 are checked, and that neither
    /// the default nor the reference diverged.
    pub fn section(&self) -> Section {
        let mut section = Section {
            title: "Accuracy of trajectories".to_owned(),
            notes: self.notes(),
            tables: vec![
                self.table(),
                self.parts_table(),
                self.references_table(),
                self.chaos.table(),
            ],
            figures: vec![self.work_precision(), self.over_time()],
            ..Section::default()
        };
        let counts = |run: &&Run| run.stable && run.precision != Precision::DoubleDouble;
        for run in self.runs.iter().filter(counts) {
            let (method, precision) = (run.method.name(), run.precision.name());
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
                "Errors are the largest distance of a node, m, at {a}, {b}, {c} and {d} s. \
                 `error`: from one run for all rows, leapfrog with time steps of {:.1e} s, the \
                 controller's too, {FINER} times shorter than the scene's. `held`: from a run with \
                 mechanical steps as short whose controller steps as here, so that every time step \
                 has its own. `rounding`: from double-double with the same steps.",
                self.reference.dt
            ),
            &format!(
                "The reference of `error` is {} m off at these times: its distance from symplectic \
                 Euler with the same steps, or from leapfrog with steps twice as long where that is \
                 larger. An error below {RESOLVED} times that is not resolved, and its cell is \
                 empty: it may be off by more than a third.",
                apart.join(", ")
            ),
            "`order`: the power of the time step with which `error` falls from the row with the \
             step twice as long, the median over the times at which both are resolved. The \
             controller's output is held over a step, which is of first order whatever the \
             integrator; a contact is of first order too.",
            "`energy_ripple` and `energy_drift` are shares of the energy of the lattice stretched \
             by 2 % and let go without damping, gravity, ground or controller.",
            "Times are processor times of one thread, medians, measured alone, with nothing else \
             of this program running.",
        ]
        .map(str::to_owned)
        .to_vec()
    }

    /// The time at which the default's error has grown to the distance of two nodes; empty if nothing
    /// grows or no error was resolved.
    fn parting(&self) -> String {
        let doubling = self.chaos.doubling;
        let Some(error) = self.default_run().error[0] else {
            return String::new();
        };
        // From the first time on the error grows like a perturbation.
        let parted = self.marks[0] as f64 + (self.spacing / error).log2() * doubling;
        if !(doubling.is_finite() && parted.is_finite()) {
            return String::new();
        }
        format!(
            " At that rate the default's error, {error:.1e} m at {} s, is the distance of two nodes \
             after {parted:.0} steps ({:.2} s): later errors against a finer run are those of \
             another motion.",
            self.times[0],
            parted * self.chaos.dt
        )
    }

    fn table(&self) -> Table {
        let time = "median processor time of the whole run, s";
        let error = "m, from the reference; empty where not resolved";
        let order = "power of the time step with which the error falls";
        let ripple = "largest departure from the energy, a share";
        let drift = "last quarter less first, a share";
        let status = "what is to be said of the row";
        self.rows("accuracy", "Error against run time")
            .column("time_s", time, |run| run.number(run.time))
            .columns(self.timed("error"), error, |run, k| {
                run.error[k].map_or(Cell::Missing, |x| run.number(x))
            })
            .column("order", order, |run| run.order)
            .column("energy_ripple", ripple, |run| run.number(run.energy.ripple))
            .column("energy_drift", drift, |run| run.number(run.energy.drift))
            .column("status", status, |run| run.status(self.spacing))
            .done()
    }

    fn parts_table(&self) -> Table {
        let held =
            "m, from the reference with these steps of the controller; empty where not resolved";
        let rounding = "m, from double-double with the same steps";
        let title = "The integrator's own error, and rounding";
        self.rows("accuracy_parts", title)
            .columns(self.timed("held"), held, |run, k| {
                run.held[k].map_or(Cell::Missing, |x| run.number(x))
            })
            .columns(self.timed("rounding"), rounding, |run, k| {
                run.number(run.rounding[k])
            })
            .done()
    }

    fn references_table(&self) -> Table {
        let held = self.held.iter().map(|reference| ("held", reference));
        let all: Vec<_> = once(("error", &self.reference)).chain(held).collect();
        let title = "The references, and how far they may be off";
        let names = self.timed("uncertainty");
        let says = "m, how far it is from nearly as fine runs, the larger of two distances";
        Table::of("accuracy_references", title, &all)
            .column("of", "the errors that are distances from it", |(of, _)| *of)
            .column("dt_s", "time step of the controller, s", |(_, r)| r.dt)
            .column("substep_s", "mechanical step, s", |(_, r)| r.substep)
            .columns(names, says, |(_, r), k| r.uncertainty[k])
            .mark(Standing::Failed, |(_, r)| !r.is_sound())
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
        Table::of(name, title, &self.runs)
            .mark(Standing::Default, |run| run.is_default)
            .mark(Standing::Failed, Run::is_failed)
            .column("method", method, |run| run.method.name())
            .column("dt_s", dt, |run| run.dt)
            .column("precision", "number type", |run| run.precision.name())
    }

    /// Error against run time, a line for every method and precision.
    fn work_precision(&self) -> LogChart {
        let time = self.times[SHOWN];
        LogChart {
            name: "work_precision",
            caption: format!(
                "Error at {time} s against run time; along each line the time step is halved four \
                 times. Whole lines f64, dashed f32, dotted double-double. Errors that are not \
                 resolved are left out."
            ),
            title: format!("Largest error of a node at {time} s, m"),
            along: format!("run time of {} s of motion, s", self.times[3]),
            lines: self.lines(&Precision::ALL, |run| {
                Vector::new([run.time, shown(run.error)])
            }),
            marked: self.marked(|run| run.time),
        }
    }

    /// Rounding and time-step errors against the time step.
    fn over_time(&self) -> LogChart {
        let time = self.times[SHOWN];
        let lines = self.lines(&Precision::ALL[1..2], |run| {
            Vector::new([run.dt, shown(run.error)])
        });
        let held = self.lines(&Precision::ALL[1..2], |run| {
            Vector::new([run.dt, shown(run.held)])
        });
        let held = held.into_iter().map(|line| Line {
            name: format!("{}, held", line.name),
            dashes: "6 4",
            ..line
        });
        LogChart {
            name: "order",
            caption: "Error against the time step. Dashed: with the controller's output held \
                      alike, which leaves the integrator's own error."
                .to_owned(),
            title: format!("Largest error of a node at {time} s in f64, m"),
            along: "time step, s".to_owned(),
            lines: lines.into_iter().chain(held).collect(),
            marked: self.marked(|run| run.dt),
        }
    }

    /// The default's point, if it has one.
    fn marked(&self, along: impl Fn(&Run) -> f64) -> Option<(Vector<f64>, String)> {
        let default = self.default_run();
        let error = default.error[SHOWN].filter(|_| default.is_sound());
        error.map(|error| (Vector::new([along(default), error]), "default".to_owned()))
    }

    /// A line for every method in some precisions.
    pub(super) fn lines(
        &self,
        precisions: &[Precision],
        point: impl Fn(&Run) -> Vector<f64>,
    ) -> Vec<Line> {
        let mut methods: Vec<Method> = self.runs.iter().map(|run| run.method).collect();
        methods.dedup();
        let mut lines = Vec::new();
        for &precision in precisions {
            for (k, method) in methods.iter().enumerate() {
                let belongs = |run: &&Run| run.method == *method && run.precision == precision;
                // The errors of runs that went astray would press all others into one line.
                let sound = self.runs.iter().filter(|run| run.is_sound());
                let dashes = match precision {
                    Precision::Single => "6 4",
                    Precision::Double => "",
                    Precision::DoubleDouble => "1 5",
                };
                let name = format!("{}, {}", method.name(), precision.name());
                let points = sound.filter(belongs).map(&point);
                lines.push(Line::new(name, k, dashes, points));
            }
        }
        lines
    }
}

/// The error that a plot shows; NaN, which is left out, if it is not resolved.
fn shown(errors: [Option<f64>; 4]) -> f64 {
    errors[SHOWN].unwrap_or(f64::NAN)
}
