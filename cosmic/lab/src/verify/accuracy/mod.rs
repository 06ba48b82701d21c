//! Trajectories: error against run time, for every integrator, time step and precision.

mod energy;
mod reference;
mod sheet;

use autodiff::{DoubleDouble, Real};
use rayon::prelude::*;

use super::chaos::Chaos;
use super::clock::median_time;
use super::probe::{Probe, distance, frequencies, median};
use cosmic::case::Case;
use cosmic::lattice::State;
use cosmic::scene::{Integrator, Named};
use cosmic::simulator::Trajectory;
use cosmic::simulator::stability::stable_step;
pub use energy::Energy;
pub use reference::Reference;

/// Steps of the scene after which positions are compared, where it has as many.
const LAST: usize = 512;
/// The time steps, as shares of the scene's: exact in binary.
const SHARES: [f64; 5] = [2.0, 1.0, 0.5, 0.25, 0.125];
/// Runs whose median time is taken.
const REPEATS: usize = 9;

/// The number type of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// f32.
    Single,
    /// f64.
    Double,
    /// [`DoubleDouble`].
    DoubleDouble,
}

impl Precision {
    const ALL: [Self; 3] = [Self::Single, Self::Double, Self::DoubleDouble];

    /// The name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Single => "f32",
            Self::Double => "f64",
            Self::DoubleDouble => "double-double",
        }
    }
}

/// An integrator with its substeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Method {
    /// How a mechanical step is integrated.
    pub integrator: Integrator,
    /// Mechanical steps for each of the controller.
    pub substeps: usize,
}

impl Method {
    /// The name in tables.
    pub fn name(&self) -> String {
        let name = self.integrator.name().replace('_', " ");
        match self.substeps {
            1 => name,
            substeps => format!("{name} x{substeps}"),
        }
    }

    /// The case's own.
    fn of(case: &Case) -> Self {
        Self {
            integrator: case.physics.integrator,
            substeps: case.physics.substeps,
        }
    }
}

/// One way to run the case.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Integrator and substeps.
    pub method: Method,
    /// Time step, s.
    pub dt: f64,
    /// Number type.
    pub precision: Precision,
    /// True for the scene's own method, time step and precision.
    pub is_default: bool,
    /// The largest distance of a node, m, after each of [`Accuracy::times`], from
    /// [`Accuracy::reference`], which is the same for all. `None` where it is below three times the
    /// uncertainty of that.
    pub error: [Option<f64>; 4],
    /// The errors against the reference of [`Accuracy::held`] whose controller steps at the same times.
    pub held: [Option<f64>; 4],
    /// The errors against a double-double run with the same settings.
    pub rounding: [f64; 4],
    /// The order with which `error` falls from twice the time step: the median over the times at which
    /// both are known. `None` if there are none, and for the longest time step.
    pub order: Option<f64>,
    /// Median processor time of the whole run, s.
    pub time: f64,
    /// The energy without damping, ground and controller.
    pub energy: Energy,
    /// True if the time step is below the stable one of the design at its start.
    pub stable: bool,
    /// True if all observed positions were finite and sane.
    pub finite: bool,
}

/// The errors of a case in every way to run it.
#[derive(Clone, Debug, PartialEq)]
pub struct Accuracy {
    /// The times at which positions are compared, s.
    pub times: [f64; 4],
    /// The steps of the scene at these times.
    pub marks: [usize; 4],
    /// The reference of the errors of all rows.
    pub reference: Reference,
    /// The references of the integrators' own errors, for every time step from the longest on. A
    /// controller that holds its output for longer makes another motion, so that no single reference
    /// serves all rows.
    pub held: Vec<Reference>,
    /// The rows, by method, time step and precision.
    pub runs: Vec<Run>,
    /// How fast motions diverge.
    pub chaos: Chaos,
    /// Distance of neighbouring nodes, m.
    pub spacing: f64,
}

impl Accuracy {
    /// Runs a case in every way. Errors are computed in parallel, run times measured alone.
    pub fn of(case: &Case) -> Self {
        let last = LAST.min(case.physics.steps).max(32) / 32 * 32;
        let marks = [last / 16, last / 4, last / 2, last];
        let reference = |held: Option<f64>| Reference::of(case, marks, held);
        let shares = SHARES.par_iter().copied().map(Some);
        let held = || shares.map(reference).collect::<Vec<_>>();
        let (reference, held) = rayon::join(|| reference(None), held);
        let groups = |method| SHARES.map(|share| Discretisation { method, share });
        let methods = methods(Method::of(case)).into_iter();
        let groups: Vec<Discretisation> = methods.flat_map(groups).collect();
        let found = groups
            .par_iter()
            .enumerate()
            .map(|(k, group)| group.runs(case, marks, [&reference, &held[k % SHARES.len()]]));
        let mut runs = found.collect::<Vec<_>>().concat();
        set_orders(&mut runs);
        let rows = runs.chunks_exact_mut(Precision::ALL.len());
        for (group, rows) in groups.iter().zip(rows) {
            group.measure(case, marks, rows);
        }
        Self {
            times: marks.map(|mark| mark as f64 * case.physics.dt),
            marks,
            reference,
            held,
            runs,
            chaos: Chaos::of(case),
            spacing: case.lattice.spacing,
        }
    }

    /// The row with the scene's own settings.
    ///
    /// # Panics
    /// Never: the row is among them.
    pub fn default_run(&self) -> &Run {
        let found = self.runs.iter().find(|run| run.is_default);
        found.expect("the scene's own method and time step are run")
    }
}

/// The methods that are compared, and the scene's own.
fn methods(own: Method) -> Vec<Method> {
    let offered = [1, 4].into_iter().flat_map(|substeps| {
        [Integrator::SymplecticEuler, Integrator::Leapfrog].map(|integrator| Method {
            integrator,
            substeps,
        })
    });
    let mut methods: Vec<Method> = offered.collect();
    if !methods.contains(&own) {
        methods.push(own);
    }
    methods
}

/// A method with a time step, in every precision.
#[derive(Clone, Copy)]
struct Discretisation {
    method: Method,
    /// The time step as a share of the scene's.
    share: f64,
}

impl Discretisation {
    /// The case with this method, `finer` times the steps and `held` times the substeps.
    fn case(&self, case: &Case, finer: usize, held: usize) -> Case {
        let mut case = case.clone();
        let physics = &mut case.physics;
        physics.integrator = self.method.integrator;
        physics.substeps = self.method.substeps * held;
        physics.dt *= self.share / finer as f64;
        case
    }

    /// The marks in steps of this time step, `finer` times as many.
    fn marks(&self, marks: [usize; 4], finer: usize) -> Vec<usize> {
        // Shares are powers of two and marks even: exact.
        let steps = |mark: usize| (mark as f64 / self.share) as usize * finer;
        marks.map(steps).to_vec()
    }

    fn seen<R: Real + Into<f64>>(&self, case: &Case, marks: Vec<usize>) -> Trajectory<f64> {
        let mut case = case.clone();
        case.physics.steps = marks[marks.len() - 1];
        Probe::new(&case).run::<R>(marks)
    }

    fn runs(&self, case: &Case, marks: [usize; 4], references: [&Reference; 2]) -> Vec<Run> {
        let here = self.case(case, 1, 1);
        let at = self.marks(marks, 1);
        let [reference, held] = references;
        let [frequency, _, damping] = frequencies(&here, &here.start.x);
        let stable = here.physics.dt < stable_step(&here.physics, frequency, damping);
        let motions = [
            self.motion::<f32>(&here, &at),
            self.motion::<f64>(&here, &at),
            self.motion::<DoubleDouble>(&here, &at),
        ];
        let run = |(precision, (seen, energy)): (Precision, &(Trajectory<f64>, Energy))| Run {
            method: self.method,
            dt: here.physics.dt,
            precision,
            is_default: (self.method, self.share, precision)
                == (Method::of(case), 1.0, Precision::Double),
            error: reference.errors(seen),
            held: held.errors(seen),
            rounding: errors(seen, &motions[2].0),
            order: None,
            time: f64::NAN,
            energy: *energy,
            stable,
            finite: !seen.states.iter().any(State::is_absurd),
        };
        Precision::ALL.into_iter().zip(&motions).map(run).collect()
    }

    fn motion<R: Real + Into<f64>>(&self, case: &Case, at: &[usize]) -> (Trajectory<f64>, Energy) {
        let energy = Energy::of::<R>(case, at[at.len() - 1]);
        (self.seen::<R>(case, at.to_vec()), energy)
    }

    /// Times the rows, which are in the order of [`Precision::ALL`].
    fn measure(&self, case: &Case, marks: [usize; 4], rows: &mut [Run]) {
        let (mut case, at) = (self.case(case, 1, 1), self.marks(marks, 1));
        case.physics.steps = at[3];
        let probe = Probe::new(&case);
        let times = [time::<f32>, time::<f64>, time::<DoubleDouble>];
        for (row, time) in rows.iter_mut().zip(times) {
            row.time = time(&probe, &at);
        }
    }
}

fn time<R: Real + Into<f64>>(probe: &Probe, at: &[usize]) -> f64 {
    median_time(REPEATS, || probe.run::<R>(at.to_vec()))
}

fn errors(seen: &Trajectory<f64>, truth: &Trajectory<f64>) -> [f64; 4] {
    std::array::from_fn(|k| distance(&seen.states[k], &truth.states[k]))
}

/// Sets the orders, from rows of equal method and precision with twice the time step. The error of a row
/// that went astray says nothing of its time step.
fn set_orders(runs: &mut [Run]) {
    let known = runs.to_vec();
    for run in runs {
        let longer = known.iter().find(|other| {
            other.method == run.method
                && other.precision == run.precision
                && other.dt == 2.0 * run.dt
        });
        let longer = longer.filter(|longer| longer.is_sound() && run.is_sound());
        run.order = longer.and_then(|longer| order(&longer.error, &run.error));
    }
}

/// The power with which an error falls when the time step is halved, the median over the times.
fn order(long: &[Option<f64>; 4], short: &[Option<f64>; 4]) -> Option<f64> {
    let pairs = long.iter().zip(short);
    let both = pairs.filter_map(|(long, short)| Some(((*long)? / (*short)?).log2()));
    // An error of zero has no power.
    let orders: Vec<f64> = both.filter(|order| order.is_finite()).collect();
    (!orders.is_empty()).then(|| median(orders))
}

#[cfg(test)]
mod tests;
