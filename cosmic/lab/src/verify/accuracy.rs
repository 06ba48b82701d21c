//! Measures the errors and the run times of trajectories, for every integrator, time step and number type.

use autodiff::{DoubleDouble, Real};
use rayon::prelude::*;

use super::chaos::Chaos;
use super::clock::median_time;
use super::probe::{Probe, distance, stable_step_at};
use crate::report::chart::{Line, LogChart};
use crate::report::sheet::Section;
use crate::table::{Cell, Standing, Table};
use cosmic::case::Case;
use cosmic::geometry::Vector;
use cosmic::lattice::State;
use cosmic::scene::{Integrator, Named, PhysicsSettings};
use std::ops::Range;

/// Positions are compared at four times, called the marks. This is the number of the scene's steps before the last
/// mark; if the rollout is shorter, the last mark is at its end.
const LAST: usize = 512;
/// The index of the mark whose errors the figures show. It is the second mark, because chaos dominates the errors
/// later.
const SHOWN: usize = 1;
/// The time steps to compare, as multiples of the scene's time step. Binary floats represent all of these factors
/// exactly.
const FRACTIONS: [f64; 5] = [2.0, 1.0, 0.5, 0.25, 0.125];
/// The number of steps of the reference in one time step of the scene. The reference's step is 64 times shorter than
/// the shortest step of any row, unless the scene itself has more than four substeps.
pub const FINER: usize = 2048;
/// A distance from the reference counts as an error only if it is at least this many times the uncertainty of the
/// reference. Then it differs from the true error by at most a third.
const RESOLVED: f64 = 3.0;
/// The median time is taken over this many runs.
const REPEATS: usize = 9;

/// A number type in which trajectories are computed.
struct Precision {
    name: &'static str,
    /// The dash pattern of this number type's lines in figures.
    dashes: &'static str,
    /// The machine epsilon of the type: the distance from 1 to the next larger number.
    unit: f64,
    run: fn(&Probe, &[usize]) -> Vec<State<f64>>,
}

const fn precision<R: Real + Into<f64>>(
    name: &'static str,
    dashes: &'static str,
    unit: f64,
) -> Precision {
    Precision {
        name,
        dashes,
        unit,
        run: |probe, observed| probe.run::<R>(observed),
    }
}

/// The number types to compare. The last one is very precise: its distance from another type's result counts as the
/// rounding error of that type.
static PRECISIONS: [Precision; 3] = [
    precision::<f32>("f32", "6 4", f32::EPSILON as f64),
    precision::<f64>("f64", "", f64::EPSILON),
    precision::<DoubleDouble>("double-double", "1 5", f64::EPSILON),
];
/// The index of f64 among the number types.
pub const DOUBLE: usize = 1;

/// An integrator with its numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Method {
    /// The integrator.
    pub integrator: Integrator,
    /// The number of mechanical steps in a time step.
    pub substeps: usize,
}

impl Method {
    pub(super) fn name(&self) -> String {
        let name = self.integrator.name().replace('_', " ");
        match self.substeps {
            1 => name,
            substeps => format!("{name} x{substeps}"),
        }
    }

    /// The method with which the case itself is simulated.
    pub fn of(case: &Case) -> Self {
        Self {
            integrator: case.physics.integrator,
            substeps: case.physics.substeps,
        }
    }

    /// All methods to compare: explicit ones, and the method of the case itself.
    pub(super) fn all(case: &Case) -> Vec<Self> {
        let mut methods = vec![];
        for substeps in [1, 4] {
            let explicit = [Integrator::SymplecticEuler, Integrator::Leapfrog];
            methods.extend(explicit.map(|integrator| Self {
                integrator,
                substeps,
            }));
        }
        if !methods.contains(&Self::of(case)) {
            methods.push(Self::of(case));
        }
        methods
    }

    /// Changes the physics to this method.
    pub(super) fn set(&self, physics: &mut PhysicsSettings) {
        (physics.integrator, physics.substeps) = (self.integrator, self.substeps);
    }

    /// Changes the case to this method and to a time step that is `fraction` times the old one. `marks` are numbers of
    /// steps of the old case; also returns the numbers of steps of the new case at the same times.
    pub fn applied(&self, case: &Case, marks: [usize; 4], fraction: f64) -> (Case, [usize; 4]) {
        let mut case = case.clone();
        let physics = &mut case.physics;
        self.set(physics);
        physics.dt *= fraction;
        // The quotient is whole, because fractions are powers of two and marks are even.
        let at = marks.map(|mark| (mark as f64 / fraction) as usize);
        physics.steps = at[3];
        (case, at)
    }
}

/// The reference: a run by leapfrog with steps so short that its positions count as exact.
pub struct Reference {
    /// The uncertainty of the reference at each mark, in metres. It is the largest distance of a node from its position
    /// in two other runs: one by symplectic Euler with equal steps, and one by leapfrog with steps twice as long.
    /// Infinite if one of the three runs diverged.
    pub uncertainty: [f64; 4],
    /// The states at the marks.
    pub states: Vec<State<f64>>,
    /// The states at the marks by leapfrog with steps twice as long.
    pub coarser: Vec<State<f64>>,
}

impl Reference {
    /// Runs a case with steps that are `finer` times shorter, to the marks.
    pub(super) fn of(case: &Case, marks: [usize; 4], finer: usize) -> Self {
        let ways = [
            (Integrator::Leapfrog, 1.0),
            (Integrator::SymplecticEuler, 1.0),
            (Integrator::Leapfrog, 2.0),
        ];
        let run = |&(integrator, coarser)| {
            let method = Method {
                integrator,
                substeps: 1,
            };
            let (case, at) = method.applied(case, marks, coarser / finer as f64);
            Probe::new(&case).run::<f64>(&at)
        };
        let found: Vec<Vec<State<f64>>> = ways.par_iter().map(run).collect();
        let diverged = found.iter().flatten().any(State::is_absurd);
        let [first, other, coarser] = <[_; 3]>::try_from(found).expect("three ways");
        let [a, b] = [&other, &coarser].map(|states| errors(states, &first));
        Self {
            uncertainty: std::array::from_fn(|k| match diverged {
                true => f64::INFINITY,
                false => a[k].max(b[k]),
            }),
            states: first,
            coarser,
        }
    }

    /// Returns the errors at each mark, in metres: the largest distance of a node from the reference. `None` if the
    /// distance may be an error of the reference itself.
    pub fn errors(&self, states: &[State<f64>]) -> [Option<f64>; 4] {
        let errors = errors(states, &self.states);
        std::array::from_fn(|k| resolved(errors[k], self.uncertainty[k]))
    }
}

/// An error, if it is large compared with the uncertainty of the reference. `None` if it may be an error of the reference
/// itself.
pub(super) fn resolved(error: f64, uncertainty: f64) -> Option<f64> {
    let least = RESOLVED * uncertainty;
    // NaN, from a diverged run, counts as an infinite error.
    let is_resolved = error >= least || error.is_nan();
    (least.is_finite() && is_resolved).then_some(error)
}

/// The errors at each mark, in metres: the largest distance of a node from its true position.
pub fn errors(states: &[State<f64>], truth: &[State<f64>]) -> [f64; 4] {
    std::array::from_fn(|k| distance(&states[k], &truth[k]))
}

/// The result of running the case with one method, time step and number type. An error is the largest distance of a
/// node from the reference, in metres, at one of the compared times.
#[derive(Clone, Debug)]
pub struct Run {
    /// The integrator and its substeps.
    pub method: Method,
    /// The time step divided by the scene's time step.
    pub fraction: f64,
    /// The index of the number type: 0 for f32, [`DOUBLE`] for f64, 2 for double-double.
    pub precision: usize,
    /// True for the scene's own method, time step and number type.
    pub is_default: bool,
    /// The errors: the distances from the reference. `None` where the reference is not accurate enough to tell.
    pub error: [Option<f64>; 4],
    /// The rounding error: the distances from a double-double run with the same method and time step.
    pub rounding: [f64; 4],
    /// The median processor time of a whole run, in seconds.
    pub time: f64,
    /// True if the time step is below the stability limit of the robot at its start.
    pub stable: bool,
    /// True if all observed states are finite and plausible, so that the run did not diverge.
    pub finite: bool,
}

impl Run {
    /// True if the error of the run comes from the length of its time step, and not from instability.
    pub fn is_sound(&self) -> bool {
        self.finite && self.stable
    }

    /// True if the run diverged although its time step is stable, or although it is the scene's own run.
    fn is_failed(&self) -> bool {
        !self.finite && (self.stable || self.is_default)
    }

    /// Makes a table cell of one of the run's numbers. If the time step is unstable, divergence is expected: a number
    /// that is not finite is then shown as missing and not as failed.
    fn number(&self, x: f64) -> Cell {
        match self.stable || self.is_default {
            true => x.into(),
            false => Cell::if_finite(x),
        }
    }

    /// Describes the outcome of the run in a few words.
    fn status(&self, spacing: f64) -> &'static str {
        match (self.finite, self.stable) {
            _ if self.is_failed() => "diverged",
            (false, _) => "diverged as expected: unstable time step",
            (true, false) => "unstable time step",
            (true, true) if self.error[3].is_some_and(|e| e > 0.1 * spacing) => "parted",
            (true, true) => "ok",
        }
    }

    /// The error that figures show. If the reference is not accurate enough to tell the error, NaN, which figures leave
    /// out.
    fn shown(&self) -> f64 {
        self.error[SHOWN].unwrap_or(f64::NAN)
    }
}

/// The results of all runs of a case.
pub struct Accuracy<'a> {
    case: &'a Case,
    /// The marks, as numbers of the scene's steps. Positions are compared at these times.
    pub marks: [usize; 4],
    /// The run that errors are measured from.
    pub reference: Reference,
    /// All runs, in the order of methods, then time steps, then number types.
    pub runs: Vec<Run>,
    chaos: Chaos,
}

/// Runs a case with every method, time step and number type, and reports the errors. Checks the rounding errors of f32
/// and f64 wherever the time step is stable. Also checks that neither the scene's own run nor the reference diverged.
pub fn accuracy(case: &Case) -> Section {
    Accuracy::of(case).section()
}

impl<'a> Accuracy<'a> {
    /// Runs a case with every method, time step and number type. Errors are computed in parallel; run times are
    /// measured while nothing else runs.
    pub fn of(case: &'a Case) -> Self {
        let last = LAST.min(case.physics.steps).max(32) / 32 * 32;
        let marks = [last / 16, last / 4, last / 2, last];
        let reference = Reference::of(case, marks, FINER);
        let ways: Vec<(Method, f64)> = Method::all(case)
            .into_iter()
            .flat_map(|method| FRACTIONS.map(|fraction| (method, fraction)))
            .collect();
        let mut runs: Vec<Run> = ways
            .par_iter()
            .flat_map_iter(|&way| runs(case, marks, way, &reference))
            .collect();
        for run in &mut runs {
            let (case, at) = run.method.applied(case, marks, run.fraction);
            let probe = Probe::new(&case);
            run.time = median_time(REPEATS, || (PRECISIONS[run.precision].run)(&probe, &at));
        }
        Self {
            case,
            marks,
            reference,
            runs,
            chaos: Chaos::of(case),
        }
    }

    /// The times of the marks, in seconds.
    fn times(&self) -> [f64; 4] {
        self.marks.map(|mark| mark as f64 * self.case.physics.dt)
    }

    /// The run with the scene's own settings.
    pub fn default_run(&self) -> &Run {
        let found = self.runs.iter().find(|run| run.is_default);
        found.expect("the scene's own method and time step are run")
    }

    /// True if the rounding error at the first mark can be explained. Two causes are expected: 7 binary digits are lost
    /// in the sums of a step and 7 in the sums over the steps, and perturbations grow until the mark. Later marks are
    /// not checked, because chaos dominates there.
    fn rounds_well(&self, run: &Run) -> bool {
        let growth = self.chaos.growth(self.marks[0]);
        run.rounding[0] <= 128.0 * 128.0 * PRECISIONS[run.precision].unit * growth
    }

    /// The tables and figures of the runs, with the checks that failed.
    pub fn section(&self) -> Section {
        let mut section = Section {
            title: "Accuracy of trajectories".to_owned(),
            notes: self.notes(),
            tables: vec![self.table(), self.chaos.table()],
            figures: vec![
                self.figure("work_precision", |run| run.time, 0..PRECISIONS.len()),
                self.figure("order", |run| self.dt(run), DOUBLE..DOUBLE + 1),
            ],
            ..Section::default()
        };
        let is_checked = |run: &&Run| run.stable && run.precision <= DOUBLE;
        for run in self.runs.iter().filter(is_checked) {
            let (method, precision) = (run.method.name(), PRECISIONS[run.precision].name);
            let failure = format!(
                "rounding error of {method}, dt {}, {precision}",
                self.dt(run)
            );
            section.check(self.rounds_well(run), failure);
        }
        section.check(
            self.default_run().finite,
            "the run with the scene's own settings diverged",
        );
        let is_finite = self.reference.uncertainty.iter().all(|u| u.is_finite());
        section.check(is_finite, "the reference run diverged");
        section
    }

    fn notes(&self) -> Vec<String> {
        let [a, b, c, d] = self.times();
        let uncertainty = self.reference.uncertainty.map(|u| format!("{u:.1e}"));
        vec![
            self.chaos.note(),
            format!(
                "`error`: the largest distance of a node, m, at {a}, {b}, {c} and {d} s from leapfrog \
                 with time steps {FINER} times shorter than the scene's. The uncertainty of this \
                 reference is {} m: its distance from symplectic Euler with the same steps, or from \
                 leapfrog with steps twice as long, whichever is larger. The cell of an error below \
                 {RESOLVED} uncertainties is empty.",
                uncertainty.join(", ")
            ),
            "`rounding`: the largest distance of a node from a double-double run with the same steps.".to_owned(),
            "Times are medians of processor times of one thread, measured while nothing else of \
             this program runs."
                .to_owned(),
        ]
    }

    fn table(&self) -> Table {
        let method = "integrator, and substeps if there are more than one";
        let error = "largest distance of a node from the reference, m; empty if the reference is not accurate enough";
        let rounding = "largest distance of a node from its position in a double-double run with the same steps, m";
        let at = |kind: &str| self.times().map(|time| format!("{kind}_{time}"));
        let precision = |run: &Run| PRECISIONS[run.precision].name;
        let time = "median processor time of the whole run, s";
        let spacing = self.case.lattice.spacing;
        Table::of("accuracy", "Error against run time", &self.runs)
            .mark(Standing::Default, |run| run.is_default)
            .mark(Standing::Failed, Run::is_failed)
            .column("method", method, |run| run.method.name())
            .column("dt_s", "time step of the controller, s", |run| self.dt(run))
            .column("precision", "number type", precision)
            .column("time_s", time, |run| run.number(run.time))
            .columns(at("error"), error, |run, k| {
                run.error[k].map_or(Cell::Missing, |x| run.number(x))
            })
            .columns(at("rounding"), rounding, |run, k| {
                run.number(run.rounding[k])
            })
            .column("status", "the outcome", |run| run.status(spacing))
            .done()
    }

    /// The time step of a run, in seconds.
    fn dt(&self, run: &Run) -> f64 {
        self.case.physics.dt * run.fraction
    }

    /// A figure with the errors of the runs over another quantity, which `along` computes for a run. There is a line
    /// for each method and each of the number types in `precisions`.
    fn figure(
        &self,
        name: &'static str,
        along: impl Fn(&Run) -> f64,
        precisions: Range<usize>,
    ) -> LogChart {
        let times = self.times();
        let (caption, axis) = match precisions.len() {
            1 => (
                "Error in f64 against the time step.",
                "time step, s".to_owned(),
            ),
            _ => (
                "Error against run time; along each line the time step is halved four times. Solid \
                 lines f64, dashed f32, dotted double-double. Errors that are not resolved are left \
                 out.",
                format!("run time of {} s of motion, s", times[3]),
            ),
        };
        let point = |run: &Run| Vector::new([along(run), run.shown()]);
        let default = Some(self.default_run()).filter(|run| run.is_sound() && run.shown() > 0.0);
        LogChart {
            name: name.to_owned(),
            caption: caption.to_owned(),
            title: format!("Largest error of a node at {} s, m", times[SHOWN]),
            along: axis,
            lines: self.lines(precisions, &point),
            marked: default.map(|run| (point(run), "default".to_owned())),
        }
    }

    /// The lines of a figure, one for every method and each of the number types in `precisions`. `point` returns the
    /// point of a run.
    pub fn lines(
        &self,
        precisions: Range<usize>,
        point: &dyn Fn(&Run) -> Vector<f64>,
    ) -> Vec<Line> {
        let methods = Method::all(self.case);
        let mut lines = vec![];
        for precision in precisions {
            let Precision { name, dashes, .. } = PRECISIONS[precision];
            for (k, method) in methods.iter().enumerate() {
                // Diverged runs are left out. Their errors are so large that, on the same axis, all other lines would
                // coincide.
                let belongs = |run: &&Run| {
                    run.is_sound() && (run.method, run.precision) == (*method, precision)
                };
                let points = self.runs.iter().filter(belongs).map(point);
                let name = format!("{}, {name}", method.name());
                lines.push(Line::new(name, k, dashes, points));
            }
        }
        lines
    }
}

/// Runs the case with one method and time step in every number type. The run times are measured later.
fn runs(
    case: &Case,
    marks: [usize; 4],
    (method, fraction): (Method, f64),
    reference: &Reference,
) -> Vec<Run> {
    let (here, at) = method.applied(case, marks, fraction);
    let stable = here.physics.dt < stable_step_at(&here, &here.start.x);
    let probe = Probe::new(&here);
    let found = PRECISIONS.each_ref().map(|p| (p.run)(&probe, &at));
    let run = |(precision, states): (usize, &Vec<State<f64>>)| Run {
        method,
        fraction,
        precision,
        is_default: (method, fraction, precision) == (Method::of(case), 1.0, DOUBLE),
        error: reference.errors(states),
        rounding: errors(states, &found[found.len() - 1]),
        time: f64::NAN,
        stable,
        finite: !states.iter().any(State::is_absurd),
    };
    found.iter().enumerate().map(run).collect()
}
