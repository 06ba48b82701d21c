//! Trajectories: error against run time, for every integrator, time step and number type.

mod energy;
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
use energy::Energy;
pub use sheet::accuracy;

/// Steps of the scene after which positions are compared, if it has as many.
const LAST: usize = 512;
/// The time steps, as shares of the scene's: exact in binary.
const SHARES: [f64; 5] = [2.0, 1.0, 0.5, 0.25, 0.125];
/// The scene's time step over that of the reference, which is 64 times shorter than the shortest of any
/// row, unless the scene itself has more than four substeps.
const FINER: usize = 2048;
/// A distance from the reference counts as an error if it is at least this many uncertainties of the
/// reference. At three it is right to a third, the ratio of two of them to
/// (1 + 1/3) / (1 - 1/3) = 2, and an order from them to one.
const RESOLVED: f64 = 3.0;
/// Runs whose median time is taken.
const REPEATS: usize = 9;

/// A number type in which trajectories are computed.
struct Precision {
    name: &'static str,
    /// The dashes of its lines in figures.
    dashes: &'static str,
    unit: f64,
    run: fn(&Probe, Vec<usize>) -> Trajectory<f64>,
    energy: fn(&Case, usize) -> Energy,
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
        energy: Energy::of::<R>,
    }
}

/// Every number type. The last one tells the rounding of the others.
static PRECISIONS: [Precision; 3] = [
    precision::<f32>("f32", "6 4", f32::EPSILON as f64),
    precision::<f64>("f64", "", f64::EPSILON),
    precision::<DoubleDouble>("double-double", "1 5", f64::EPSILON),
];
const DOUBLE: usize = 1;

/// An integrator with its substeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Method {
    integrator: Integrator,
    substeps: usize,
}

impl Method {
    fn name(&self) -> String {
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

    /// The methods that are compared, and the case's own.
    fn all(case: &Case) -> Vec<Self> {
        let mut methods = Vec::new();
        for substeps in [1, 4] {
            methods.extend(Integrator::ALL.iter().map(|&(_, integrator)| Self {
                integrator,
                substeps,
            }));
        }
        if !methods.contains(&Self::of(case)) {
            methods.push(Self::of(case));
        }
        methods
    }

    /// The case by this method with a share of its time step, and the steps at its marks.
    fn applied(&self, case: &Case, marks: [usize; 4], share: f64) -> (Case, Vec<usize>) {
        let mut case = case.clone();
        let physics = &mut case.physics;
        (physics.integrator, physics.substeps) = (self.integrator, self.substeps);
        physics.dt *= share;
        // Shares are powers of two and marks even: exact.
        let at = marks.map(|mark| (mark as f64 / share) as usize);
        physics.steps = at[3];
        (case, at.to_vec())
    }
}

/// A run so fine that it stands for the truth.
#[derive(Debug)]
struct Reference {
    /// The uncertainty of distances from it at the marks, m: the largest distance of a node from a run by
    /// symplectic Euler with equal steps, or from leapfrog with steps twice as long, whichever is larger.
    /// Infinite if one of the three went astray.
    uncertainty: [f64; 4],
    seen: Trajectory<f64>,
}

impl Reference {
    fn of(case: &Case, marks: [usize; 4]) -> Self {
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
            let (case, at) = method.applied(case, marks, coarser / FINER as f64);
            Probe::new(&case).run::<f64>(at)
        };
        let mut found: Vec<Trajectory<f64>> = ways.par_iter().map(run).collect();
        let mut states = found.iter().flat_map(|seen| &seen.states);
        let astray = states.any(State::is_absurd);
        let seen = found.remove(0);
        let [other, coarser] = [0, 1].map(|k| errors(&found[k], &seen));
        let uncertainty = |k: usize| match astray {
            true => f64::INFINITY,
            false => other[k].max(coarser[k]),
        };
        Self {
            uncertainty: std::array::from_fn(uncertainty),
            seen,
        }
    }

    /// Distances from it, m; `None` if they may be errors of the reference itself.
    fn errors(&self, seen: &Trajectory<f64>) -> [Option<f64>; 4] {
        let errors = errors(seen, &self.seen);
        std::array::from_fn(|k| {
            let least = RESOLVED * self.uncertainty[k];
            // NaN is an error beyond all bounds.
            let own = errors[k] >= least || errors[k].is_nan();
            (least.is_finite() && own).then_some(errors[k])
        })
    }

    /// True if runs that are nearly as fine agree with it.
    fn is_sound(&self) -> bool {
        self.uncertainty.iter().all(|u| u.is_finite())
    }
}

/// One way to run the case. Errors are largest distances of a node, m, at the marks.
#[derive(Clone, Debug)]
struct Run {
    method: Method,
    /// The time step, s.
    dt: f64,
    /// An index of [`PRECISIONS`].
    precision: usize,
    /// True for the scene's own method, time step and number type.
    is_default: bool,
    /// From the reference; `None` if not resolved.
    error: [Option<f64>; 4],
    /// From a double-double run with the same settings.
    rounding: [f64; 4],
    /// The order with which `error` falls from twice the time step.
    order: Option<f64>,
    /// Median processor time of the whole run, s.
    time: f64,
    energy: Energy,
    /// True if the time step is below the stable one of the design at its start.
    stable: bool,
    /// True if all observed positions were finite and sane.
    finite: bool,
}

/// The errors of a case in every way to run it.
struct Accuracy {
    /// The times at which positions are compared, s.
    times: [f64; 4],
    /// The steps of the scene at these times.
    marks: [usize; 4],
    reference: Reference,
    /// By method, time step and number type.
    runs: Vec<Run>,
    chaos: Chaos,
    /// Distance of neighbouring nodes, m.
    spacing: f64,
}

impl Accuracy {
    /// Runs a case in every way. Errors are computed in parallel, run times measured alone.
    fn of(case: &Case) -> Self {
        let last = LAST.min(case.physics.steps).max(32) / 32 * 32;
        let marks = [last / 16, last / 4, last / 2, last];
        let reference = Reference::of(case, marks);
        let ways = Method::all(case).into_iter();
        let ways: Vec<_> = ways
            .flat_map(|way| SHARES.map(|share| (way, share)))
            .collect();
        let found = ways
            .par_iter()
            .map(|&(method, share)| runs(case, marks, (method, share), &reference));
        let mut runs = found.collect::<Vec<_>>().concat();
        set_orders(&mut runs);
        for ((method, share), rows) in ways.iter().zip(runs.chunks_exact_mut(PRECISIONS.len())) {
            let (case, at) = method.applied(case, marks, *share);
            let probe = Probe::new(&case);
            for (row, precision) in rows.iter_mut().zip(&PRECISIONS) {
                row.time = median_time(REPEATS, || (precision.run)(&probe, at.clone()));
            }
        }
        Self {
            times: marks.map(|mark| mark as f64 * case.physics.dt),
            marks,
            reference,
            runs,
            chaos: Chaos::of(case),
            spacing: case.lattice.spacing,
        }
    }

    /// The row with the scene's own settings.
    fn default_run(&self) -> &Run {
        let found = self.runs.iter().find(|run| run.is_default);
        found.expect("the scene's own method and time step are run")
    }
}

/// A method with a time step in every number type, not yet timed.
fn runs(
    case: &Case,
    marks: [usize; 4],
    (method, share): (Method, f64),
    reference: &Reference,
) -> Vec<Run> {
    let (here, at) = method.applied(case, marks, share);
    let [frequency, _, damping] = frequencies(&here, &here.start.x);
    let stable = here.physics.dt < stable_step(&here.physics, frequency, damping);
    let probe = Probe::new(&here);
    let seen = PRECISIONS.each_ref().map(|p| (p.run)(&probe, at.clone()));
    let run = |(precision, of): (usize, &Trajectory<f64>)| Run {
        method,
        dt: here.physics.dt,
        precision,
        is_default: (method, share, precision) == (Method::of(case), 1.0, DOUBLE),
        error: reference.errors(of),
        rounding: errors(of, &seen[seen.len() - 1]),
        order: None,
        time: f64::NAN,
        energy: (PRECISIONS[precision].energy)(&here, at[3]),
        stable,
        finite: !of.states.iter().any(State::is_absurd),
    };
    seen.iter().enumerate().map(run).collect()
}

fn errors(seen: &Trajectory<f64>, truth: &Trajectory<f64>) -> [f64; 4] {
    std::array::from_fn(|k| distance(&seen.states[k], &truth.states[k]))
}

/// Sets the orders, from rows of equal method and number type with twice the time step. The error of a row
/// that went astray tells nothing about its time step.
fn set_orders(runs: &mut [Run]) {
    let known = runs.to_vec();
    for run in runs {
        let longer = known.iter().find(|other| {
            (other.method, other.precision, other.dt) == (run.method, run.precision, 2.0 * run.dt)
        });
        let longer = longer.filter(|longer| longer.is_sound() && run.is_sound());
        run.order = longer.and_then(|longer| order(&longer.error, &run.error));
    }
}

/// The power with which an error falls when the time step is halved, the median over the times at which
/// both are known.
fn order(long: &[Option<f64>; 4], short: &[Option<f64>; 4]) -> Option<f64> {
    let pairs = long.iter().zip(short);
    let both = pairs.filter_map(|(long, short)| Some(((*long)? / (*short)?).log2()));
    // An error of zero has no power.
    let orders: Vec<f64> = both.filter(|order| order.is_finite()).collect();
    (!orders.is_empty()).then(|| median(orders))
}

#[cfg(test)]
mod tests;
