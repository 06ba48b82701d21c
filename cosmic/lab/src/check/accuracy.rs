//! Measures the errors and the run times of trajectories, for several integrators and time steps.

use autodiff::Real;
use rayon::prelude::*;

use super::clock::median_time;
use super::probe::{Probe, distance, largest_stable_step};
use crate::report::sheet::{Chart, Line, Section, marked};
use crate::table::{Cell, Column, Emphasis, Table};
use cosmic::case::Case;
use cosmic::judge::verdict::{Item, Level};
use cosmic::lattice::State;
use cosmic::numbers::{fixed, rounded};
use cosmic::scene::{Integrator, Named};

/// Positions are compared at two times, called the marks. This is the number of the scene's steps before the last mark;
/// if the rollout is shorter, the last mark is at its end.
const LAST: usize = 512;
/// The first mark is after this share of the time, before contacts magnify every error.
const FIRST: usize = 16;
/// The time steps to compare, as multiples of the scene's time step.
pub(super) const FRACTIONS: [f64; 4] = [1.0, 0.5, 0.25, 0.125];
/// The number of steps of the reference in one time step of the scene.
pub const FINER: usize = 2048;
/// Stiff robots get a reference with more steps, so that each is at most this share of the longest stable step.
const FINE: f64 = 1.0 / 16.0;
/// The number of steps of the reference in one time step of the scene is at most this. More steps take minutes.
const FINEST: usize = 1 << 15;
/// Explicit steps take so many substeps that each is below this share of the longest stable step.
const MARGIN: f64 = 0.9;
/// A distance from the reference counts as an error only if it is at least this many times the uncertainty of the
/// reference. Then it differs from the true error by at most a third.
const RESOLVED: f64 = 3.0;
/// Errors converge if they fall at least with this power of the time step. Every method here has an order of 1 or more; a
/// contact between two steps spoils a part of it.
const LEAST_ORDER: f64 = 0.5;
/// The median time is taken over at most this many runs.
const REPEATS: usize = 9;

/// The integrator of a step and its number of substeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Method {
    /// The integrator.
    pub integrator: Integrator,
    /// The number of mechanical steps in a time step.
    pub substeps: usize,
}

const EXPLICIT: [Integrator; 2] = [Integrator::SymplecticEuler, Integrator::Leapfrog];

impl Method {
    /// The name of the integrator, followed by the number of substeps if there are several.
    pub fn name(&self) -> String {
        let name = self.integrator.name().replace('_', " ");
        match self.substeps {
            1 => name,
            substeps => format!("{name} x{substeps}"),
        }
    }

    /// A method without substeps.
    pub(super) fn single(integrator: Integrator) -> Self {
        Self {
            integrator,
            substeps: 1,
        }
    }

    /// The method with which the case itself is simulated.
    pub fn of(case: &Case) -> Self {
        Self {
            integrator: case.scene.physics.integrator,
            substeps: case.scene.physics.substeps,
        }
    }

    /// The other methods with explicit steps and as many substeps.
    pub(super) fn others(self) -> Vec<Self> {
        let others = EXPLICIT.map(|integrator| Self { integrator, ..self });
        others.into_iter().filter(|other| *other != self).collect()
    }

    /// The methods to compare: explicit ones with as many substeps as the robot needs at the scene's time step, implicit
    /// steps, and the method of the case itself.
    fn all(case: &Case) -> Vec<Self> {
        let own = Self::of(case);
        let mut substeps = match own.integrator {
            Integrator::Implicit => 1,
            _ => own.substeps,
        };
        let limit = MARGIN * longest_explicit(case);
        while limit > 0.0 && case.scene.physics.dt / substeps as f64 > limit && substeps < FINER {
            substeps *= 2;
        }
        let implicit = Self::single(Integrator::Implicit);
        let explicit = EXPLICIT.map(|integrator| Self {
            integrator,
            substeps,
        });
        let mut methods = [&explicit[..], &[implicit]].concat();
        if !methods.contains(&own) {
            methods.push(own);
        }
        methods
    }

    /// The case with this method, a time step that is `fraction` times the old one, and as many steps as take the time of
    /// `steps` old ones.
    pub fn applied(&self, case: &Case, fraction: f64, steps: usize) -> Case {
        let mut case = case.clone();
        let physics = &mut case.scene.physics;
        (physics.integrator, physics.substeps) = (self.integrator, self.substeps);
        physics.dt *= fraction;
        // Fractions are powers of two, so the quotient is exact.
        physics.steps = (steps as f64 / fraction) as usize;
        case
    }

    /// Simulates a case by this method. Returns the states at the marks, which are numbers of steps of the old case.
    pub fn run<R: Real + Into<f64>>(
        &self,
        case: &Case,
        fraction: f64,
        marks: [usize; 2],
    ) -> Vec<State<f64>> {
        let case = self.applied(case, fraction, marks[1]);
        Probe::new(&case).run_own::<R>(&marks.map(|mark| (mark as f64 / fraction) as usize))
    }
}

/// The longest stable step of symplectic Euler, s.
fn longest_explicit(case: &Case) -> f64 {
    largest_stable_step(&Method::single(Integrator::SymplecticEuler).applied(case, 1.0, 1))
}

/// The reference: a run by leapfrog with steps so short that its positions count as exact.
pub struct Reference {
    /// The uncertainty of the reference at each mark, in metres. It is the largest distance of a node from its position
    /// in two other runs: one by symplectic Euler with equal steps, and one by leapfrog with steps twice as long.
    /// Infinite if one of the three runs diverged.
    pub uncertainty: [f64; 2],
    /// The states at the marks.
    pub states: Vec<State<f64>>,
}

impl Reference {
    fn of(case: &Case, marks: [usize; 2]) -> Self {
        let needed = case.scene.physics.dt / (FINE * longest_explicit(case));
        let finer = (needed.ceil() as usize).next_power_of_two();
        let finer = finer.clamp(FINER, FINEST) as f64;
        let ways = [
            (Integrator::Leapfrog, 1.0),
            (Integrator::SymplecticEuler, 1.0),
            (Integrator::Leapfrog, 2.0),
        ];
        let run = |&(integrator, coarser)| {
            Method::single(integrator).run::<f64>(case, coarser / finer, marks)
        };
        let found: Vec<Vec<State<f64>>> = ways.par_iter().map(run).collect();
        let diverged = found.iter().flatten().any(State::is_absurd);
        let [states, other, coarser] = <[_; 3]>::try_from(found).expect("three ways");
        let [a, b] = [&other, &coarser].map(|found| errors(found, &states));
        Self {
            uncertainty: std::array::from_fn(|k| match diverged {
                true => f64::INFINITY,
                false => a[k].max(b[k]),
            }),
            states,
        }
    }

    /// Returns the errors at each mark, in metres: the largest distance of a node from the reference. `None` if the
    /// distance may be an error of the reference itself.
    pub fn errors(&self, states: &[State<f64>]) -> [Option<f64>; 2] {
        let errors = errors(states, &self.states);
        std::array::from_fn(|k| {
            let least = RESOLVED * self.uncertainty[k];
            // NaN, from a diverged run, counts as an infinite error.
            let is_resolved = errors[k] >= least || errors[k].is_nan();
            (least.is_finite() && is_resolved).then_some(errors[k])
        })
    }
}

/// The largest distance of a node between two lists of states, at each mark, in metres.
pub fn errors(states: &[State<f64>], truth: &[State<f64>]) -> [f64; 2] {
    std::array::from_fn(|k| distance(&states[k], &truth[k]))
}

/// The result of running the case with one method, time step and number type.
#[derive(Clone, Debug)]
pub struct Run {
    /// The integrator and its substeps.
    pub method: Method,
    /// The time step divided by the scene's time step.
    pub fraction: f64,
    /// True for f32, false for f64.
    pub is_single: bool,
    /// True for the scene's own method, time step and number type.
    pub is_default: bool,
    /// The errors at the marks, m. `None` where the reference is not accurate enough to tell.
    pub error: [Option<f64>; 2],
    /// The observed orders at the marks: with which power of the time step the errors fall from the run with twice the
    /// time step to this one. `None` for the longest time step, and where an error is not known.
    pub order: [Option<f64>; 2],
    /// The median processor time of a whole run, in seconds.
    pub time: f64,
    /// True if the time step is below the stability limit of the robot at its start.
    pub stable: bool,
    /// True if the states at the marks are finite and plausible, so that the run did not diverge.
    pub finite: bool,
}

impl Run {
    fn new(
        case: &Case,
        reference: &Reference,
        marks: [usize; 2],
        (method, fraction, is_single): (Method, f64, bool),
    ) -> Self {
        let here = method.applied(case, fraction, marks[1]);
        let run = || match is_single {
            true => method.run::<f32>(case, fraction, marks),
            false => method.run::<f64>(case, fraction, marks),
        };
        let states = run();
        Self {
            method,
            fraction,
            is_single,
            is_default: (method, fraction, is_single) == (Method::of(case), 1.0, false),
            error: reference.errors(&states),
            order: [None; 2],
            time: median_time(REPEATS, run),
            stable: here.scene.physics.dt < largest_stable_step(&here),
            finite: !states.iter().any(State::is_absurd),
        }
    }

    /// True if the run diverged although its time step is stable, or although it is the scene's own run.
    pub fn is_failed(&self) -> bool {
        !self.finite && (self.stable || self.is_default)
    }

    fn precision(&self) -> &'static str {
        if self.is_single { "f32" } else { "f64" }
    }

    /// True if the errors fall too slowly from the run with twice the time step.
    fn is_slow(&self) -> bool {
        let mut orders = self.order.iter().flatten();
        orders.any(|order| *order < LEAST_ORDER)
    }

    /// The error at a mark, if it tells something about the length of the time step.
    fn known_error(&self, mark: usize) -> Option<f64> {
        let error = self.error[mark].filter(|error| error.is_finite());
        error.filter(|_| self.stable && self.finite)
    }
}

/// The power of the time step with which errors fall at a mark, from the run `coarse` to the run `fine`.
fn order(coarse: &Run, fine: &Run, mark: usize) -> Option<f64> {
    let [before, after] = [coarse, fine].map(|run| run.known_error(mark));
    Some((before? / after?).log2() / (coarse.fraction / fine.fraction).log2())
}

/// The results of all runs of a case.
pub struct Accuracy<'a> {
    case: &'a Case,
    /// The marks, as numbers of the scene's steps. Positions are compared at these times.
    pub marks: [usize; 2],
    /// The run that errors are measured from.
    pub reference: Reference,
    /// All runs, in the order of methods, then time steps. Those in f32 come last.
    pub runs: Vec<Run>,
}

impl<'a> Accuracy<'a> {
    /// Runs a case with several methods and time steps. Run times are measured while nothing else runs.
    pub fn of(case: &'a Case) -> Self {
        let last = LAST.min(case.scene.physics.steps).max(FIRST) / FIRST * FIRST;
        let marks = [last / FIRST, last];
        let reference = Reference::of(case, marks);
        let own = Method::of(case);
        let double = Method::all(case).into_iter().map(|method| (method, false));
        let ways = double.chain([(own, true)]);
        let ways = ways.flat_map(|(method, is_single)| {
            FRACTIONS.map(|fraction| (method, fraction, is_single))
        });
        let runs = ways.map(|way| Run::new(case, &reference, marks, way));
        let mut runs: Vec<Run> = runs.collect();
        for runs in runs.chunks_exact_mut(FRACTIONS.len()) {
            for k in 1..runs.len() {
                runs[k].order = [0, 1].map(|mark| order(&runs[k - 1], &runs[k], mark));
            }
        }
        Self {
            runs,
            case,
            marks,
            reference,
        }
    }

    /// The runs of each method and number type, by falling time step.
    fn methods(&self) -> impl Iterator<Item = &[Run]> {
        self.runs.chunks_exact(FRACTIONS.len())
    }

    /// The outcome of a run in a few words. The first run of a method is judged by the step to the second.
    fn status(&self, run: &Run) -> &'static str {
        let double = (run.method, run.fraction, false);
        match (run.finite, run.stable) {
            _ if run.is_failed() => "diverged",
            (_, false) => "unstable time step",
            _ if !self.is_slow((run.method, run.fraction, run.is_single)) => "ok",
            _ if run.is_single && !self.is_slow(double) => "errors do not fall: rounding",
            _ => "errors do not fall",
        }
    }

    /// True if the errors of this method, time step and number type (true for f32) fall too slowly from the time step before
    /// it, or from the first to the second.
    fn is_slow(&self, (method, fraction, is_single): (Method, f64, bool)) -> bool {
        let is_same = |run: &Run| (run.method, run.is_single) == (method, is_single);
        let of_method = self.methods().find(|runs| is_same(&runs[0]));
        let until = |run: &&Run| run.fraction >= fraction.min(FRACTIONS[1]);
        let run = of_method.and_then(|runs| runs.iter().rfind(until));
        run.is_some_and(Run::is_slow)
    }

    /// Says of each method in double precision how fast its errors fall with the time step.
    fn answers(&self) -> Vec<Item> {
        let double = self.methods().filter(|runs| !runs[0].is_single);
        double.map(|runs| self.answer(runs)).collect()
    }

    fn answer(&self, runs: &[Run]) -> Item {
        let name = runs[0].method.name();
        let of_mark = |mark: usize| {
            let known: Vec<&Run> = (runs.iter())
                .filter(|run| run.known_error(mark).is_some())
                .collect();
            let [first, .., last] = &known[..] else {
                return None;
            };
            Some((order(first, last, mark)?, self.times()[mark]))
        };
        let orders: Vec<(f64, f64)> = [0, 1].into_iter().filter_map(of_mark).collect();
        let shown =
            |(order, time): &(f64, f64)| format!("order {} at {time:.3} s", fixed(*order, 1));
        let shown = orders.iter().map(shown).collect::<Vec<_>>().join(", ");
        let slow = orders.iter().find(|(order, _)| *order < LEAST_ORDER);
        let (says, level) = match slow {
            _ if orders.is_empty() => (
                "the errors are too small or too large to tell how fast they fall".to_owned(),
                Level::Doubtful,
            ),
            None if runs.iter().any(Run::is_slow) => (
                format!("the errors fall, but not from every time step to the next: {shown}"),
                Level::Doubtful,
            ),
            None => (format!("the errors converge: {shown}"), Level::Good),
            Some(_) => (
                format!("the errors do not converge at these time steps: {shown}"),
                Level::Doubtful,
            ),
        };
        Item::figure(format!("{name}: {says}"), level)
    }

    /// The tables and charts of the runs, with the checks that failed.
    pub fn section(&self) -> Section {
        let table = self.table();
        let mut section = Section {
            title: "Accuracy".to_owned(),
            text: format!("{}{}\n", marked(&table), self.note()),
            answers: self.answers(),
            notes: vec![self.note()],
            tables: vec![table],
            charts: vec![
                self.chart("run time, s", |run| run.time),
                self.chart("time step, s", |run| self.dt(run)),
            ],
            ..Section::default()
        };
        for run in &self.runs {
            let (method, precision) = (run.method.name(), run.precision());
            let failure = format!(
                "{method}, dt {}, {precision}: diverged",
                rounded(self.dt(run), 5)
            );
            section.check(!run.is_failed(), failure);
        }
        let is_finite = self.reference.uncertainty.iter().all(|u| u.is_finite());
        section.check(is_finite, "the reference diverged");
        section
    }

    fn note(&self) -> String {
        let [a, b] = self.reference.uncertainty;
        format!(
            "`error`: largest distance of a node, m, from leapfrog with steps at least {FINER} times shorter, which is \
             uncertain by {a:.1e} and {b:.1e} m; smaller errors are left out. `order`: the power of the time step with \
             which the errors fall from twice the time step. `time`: processor time of one thread."
        )
    }

    /// The times of the marks, in seconds.
    fn times(&self) -> [f64; 2] {
        self.marks
            .map(|mark| mark as f64 * self.case.scene.physics.dt)
    }

    fn table(&self) -> Table {
        let error = "largest distance of a node from the reference, m; empty if the reference is not accurate enough";
        let [of_times, orders] =
            ["error", "order"].map(|what| self.times().map(|time| format!("{what}_{time:.3}")));
        let order = "with which power of the time step the error falls from the row above; empty if it is not known";
        let of_order = |k: usize| Column::new(&orders[k], order).decimals(1, "");
        let shown = |run: &Run, x: f64| match run.is_failed() {
            true => Cell::from(x),
            false => Cell::if_finite(x),
        };
        Table::of("accuracy", "Error against run time", &self.runs)
            .mark(Emphasis::Default, |run| run.is_default)
            .mark(Emphasis::Failed, Run::is_failed)
            .column("method", "integrator and substeps", |run| run.method.name())
            .column("dt_s", "time step of the controller, s", |run| self.dt(run))
            .column("precision", "number type", Run::precision)
            .column("time_s", "median processor time of the run, s", |run| {
                run.time
            })
            .columns(of_times, error, |run, k| {
                run.error[k].map_or(Cell::Missing, |error| shown(run, error))
            })
            .add(of_order(0), |run| Cell::from(run.order[0]))
            .add(of_order(1), |run| Cell::from(run.order[1]))
            .column("status", "the outcome", |run| self.status(run))
            .done()
    }

    /// The time step of a run, in seconds.
    fn dt(&self, run: &Run) -> f64 {
        self.case.scene.physics.dt * run.fraction
    }

    /// A chart of the errors at the first mark over another quantity, with a line for each method and number type. Runs
    /// with an unstable time step are left out, because their errors say nothing about the length of the step.
    fn chart(&self, along: &str, of: impl Fn(&Run) -> f64) -> Chart {
        let lines = self.methods();
        let line = |runs: &[Run]| {
            let shown = runs.iter().filter(|run| run.stable && run.finite);
            let points = shown.filter_map(|run| Some([of(run), run.error[0]?]));
            let name = format!("{}, {}", runs[0].method.name(), runs[0].precision());
            Line::new(&name, points)
        };
        Chart {
            title: format!("Largest error of a node at {:.3} s, m", self.times()[0]),
            along: along.to_owned(),
            is_log: [true, true],
            lines: lines.map(line).collect(),
        }
    }
}
