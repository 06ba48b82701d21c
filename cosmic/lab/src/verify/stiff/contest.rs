//! Explicit and implicit steps against each other, for one robot.

use cosmic::case::Case;
use cosmic::geometry::Vector;
use cosmic::lattice::State;
use cosmic::scene::{Integrator, stable_step};
use cosmic::simulator::Store;

use crate::report::chart::{Line, LogChart};
use crate::verify::accuracy::{Method, Reference, resolved};
use crate::verify::clock::median_time;
use crate::verify::probe::{Probe, frequencies, relative_error};
use crate::verify::subject::{Slopes, Subject};

/// The number of the scene's steps over which errors are measured.
const STEPS: usize = 32;
/// The numbers of steps after which positions are compared. Only the last one counts here.
const MARKS: [usize; 4] = [STEPS / 8, STEPS / 4, STEPS / 2, STEPS];
/// How many times shorter the steps of the reference are than the longest stable one.
pub(super) const FINER: usize = 16;
/// Explicit steps stay below this share of the limit of stability, which is that of the robot at its start.
const MARGIN: f64 = 0.9;
/// The uncertainty of the reference that notes mention, as a percentage of the spacing.
const DOUBTFUL: f64 = 1.0;
/// The median time is taken over at most this many runs.
const REPEATS: usize = 5;
/// The number of times that the longest step of a method is halved.
const HALVINGS: i32 = 3;

/// The duration of the motion, s.
pub(super) fn time(case: &Case) -> f64 {
    STEPS as f64 * case.physics.dt
}

/// The steps of one robot against a reference.
pub(super) struct Contest<'a> {
    pub(super) world: &'static str,
    /// The stiffness of the skeleton, N/m.
    pub(super) stiffness: f64,
    /// The name of the stiffness in names of files.
    label: &'static str,
    case: &'a Case,
    /// The longest stable explicit step, as a share of the scene's step. It is a power of two.
    explicit: f64,
    reference: Reference,
    /// The slopes of the displacement along random directions, by the steps of the reference.
    slopes: Slopes,
    /// The relative uncertainty of these slopes.
    uncertain_slopes: f64,
    /// The energy at the end of the reference, J; `None` if a law has no energy.
    energy: Option<f64>,
    /// The relative uncertainty of this energy.
    uncertain_energy: f64,
    pub(super) entries: Vec<Entry>,
}

/// One method with one time step.
pub(super) struct Entry {
    pub(super) method: Method,
    /// The time step of the controller, as a share of the scene's.
    fraction: f64,
    /// The processor times of a rollout and of a gradient, s.
    pub(super) time: f64,
    pub(super) gradient_time: f64,
    /// The largest error of a node's position, as a share of the spacing. As all errors, `None` if the reference is not
    /// accurate enough.
    pub(super) position: Option<f64>,
    /// The relative error of the energy, `None` also if a law has no energy.
    pub(super) energy: Option<f64>,
    /// The relative error of the slopes.
    pub(super) gradient: Option<f64>,
}

impl<'a> Contest<'a> {
    /// Prepares a contest: finds the longest stable explicit step, and computes the reference.
    pub(super) fn new(world: &'static str, label: &'static str, case: &'a Case) -> Self {
        let explicit = longest_stable(case);
        let finer = (FINER as f64 / explicit) as usize;
        let reference = Reference::of(case, MARKS, finer);
        let [slopes, coarser] = [1.0, 2.0].map(|coarser| {
            let (case, at) =
                method(Integrator::Leapfrog, 1).applied(case, MARKS, coarser / finer as f64);
            let subject = Subject::new(&case);
            subject.along(&subject.driver(at[3]))
        });
        let [energy, twice] =
            [&reference.states, &reference.coarser].map(|states| energy(case, &states[3]));
        let [_, skeleton, _] = case.materials.stiffness;
        Self {
            world,
            stiffness: skeleton,
            label,
            case,
            explicit,
            uncertain_slopes: relative_error(&coarser, &slopes),
            uncertain_energy: relative(twice, energy).unwrap_or(0.0),
            reference,
            slopes,
            energy,
            entries: Vec::new(),
        }
    }

    /// The uncertainty of the reference's positions at the end, in spacings.
    fn uncertainty(&self) -> f64 {
        self.reference.uncertainty[3] / self.case.lattice.spacing
    }

    /// Runs every method with every time step, and measures its time.
    pub(super) fn run(&mut self) {
        self.entries = (methods(self.explicit).into_iter())
            .map(|(method, fraction)| self.entry(method, fraction))
            .collect();
    }

    fn entry(&self, method: Method, fraction: f64) -> Entry {
        let (case, at) = method.applied(self.case, MARKS, fraction);
        let (probe, subject) = (Probe::new(&case), Subject::new(&case));
        let (mut states, mut gradient) = (Vec::new(), Vec::new());
        let time = median_time(REPEATS, || states = probe.run::<f64>(&at));
        let gradient_time = median_time(REPEATS, || gradient = subject.driver(at[3]));
        let position = self.reference.errors(&states)[3];
        let of_energy = relative(energy(&case, &states[3]), self.energy);
        let of_gradient = relative_error(&subject.along(&gradient), &self.slopes);
        Entry {
            method,
            fraction,
            time,
            gradient_time,
            position: position.map(|error| error / case.lattice.spacing),
            energy: of_energy.and_then(|error| resolved(error, self.uncertain_energy)),
            gradient: resolved(of_gradient, self.uncertain_slopes),
        }
    }

    /// The time step of the controller in an entry, s.
    pub(super) fn dt(&self, entry: &Entry) -> f64 {
        self.case.physics.dt * entry.fraction
    }

    /// Says how uncertain the reference is, if that matters.
    pub(super) fn doubt(&self) -> Option<String> {
        let (percent, stiffness, world) = (100.0 * self.uncertainty(), self.stiffness, self.world);
        (percent > DOUBTFUL).then(|| {
            format!(
                "With {stiffness} N/m ({world}), the reference itself is uncertain by {percent:.0} % of a spacing."
            )
        })
    }

    /// True if the reference did not diverge.
    pub(super) fn is_known(&self) -> bool {
        self.uncertainty().is_finite()
    }

    /// True if no run diverged. All of them have a stable step.
    pub(super) fn is_finite(&self) -> bool {
        let is_finite = |error: Option<f64>| error.is_none_or(f64::is_finite);
        let mut entries = self.entries.iter();
        entries.all(|entry| is_finite(entry.position) && is_finite(entry.gradient))
    }

    /// The errors of all methods over their run times.
    pub(super) fn figure(&self) -> LogChart {
        type Point = fn(&Entry) -> (f64, Option<f64>);
        const KINDS: [(&str, &str, Point); 3] = [
            ("position", "", |entry| (entry.time, entry.position)),
            ("energy", "6 4", |entry| (entry.time, entry.energy)),
            ("gradient", "1 5", |entry| {
                (entry.gradient_time, entry.gradient)
            }),
        ];
        let mut lines = Vec::new();
        for (kind, dashes, point) in KINDS {
            for (k, (name, belongs)) in GROUPS.into_iter().enumerate() {
                let entries = self.entries.iter().filter(|entry| belongs(&entry.method));
                let points = entries.map(|entry| {
                    let (time, error) = point(entry);
                    Vector::new([time, error.unwrap_or(f64::NAN)])
                });
                lines.push(Line::new(format!("{name}: {kind}"), k, dashes, points));
            }
        }
        LogChart {
            name: format!("stiff_{}_{}", self.world, self.label),
            caption: format!(
                "A skeleton of {} N/m, {}. Solid lines: positions in spacings; dashed: energy; dotted: gradient, over the \
                 time of a gradient. Along each line the time step is halved.",
                self.label, self.world
            ),
            title: format!("Relative error after {} s", time(self.case)),
            along: "run time, s".to_owned(),
            lines,
            marked: None,
        }
    }
}

/// A line of a figure: a name, and whether a method belongs to it.
type Group = (&'static str, fn(&Method) -> bool);

/// The lines of a figure.
const GROUPS: [Group; 4] = [
    ("explicit", |of| {
        of.integrator == Integrator::SymplecticEuler && of.substeps == 1
    }),
    ("leapfrog", |of| of.integrator == Integrator::Leapfrog),
    ("substeps", |of| {
        of.integrator == Integrator::SymplecticEuler && of.substeps > 1
    }),
    ("implicit", |of| of.integrator == Integrator::Implicit),
];

fn method(integrator: Integrator, substeps: usize) -> Method {
    Method {
        integrator,
        substeps,
    }
}

/// The longest stable step of symplectic Euler at the start, as a share of the scene's step and as a power of two, but at
/// most 2.
fn longest_stable(case: &Case) -> f64 {
    let [frequency, _, damping] = frequencies(case, &case.start.x);
    let (case, _) = method(Integrator::SymplecticEuler, 1).applied(case, MARKS, 1.0);
    let limit = MARGIN * stable_step(&case.physics, frequency, damping);
    let mut fraction = 2.0;
    while fraction * case.physics.dt > limit {
        fraction *= 0.5;
    }
    fraction
}

/// All methods, and the time steps of their controllers as shares of the scene's. `explicit` is the longest stable explicit
/// step.
fn methods(explicit: f64) -> Vec<(Method, f64)> {
    let halved = |longest: f64, halvings: i32| {
        (0..=halvings).map(move |halving| longest * 0.5_f64.powi(halving))
    };
    let mut methods = Vec::new();
    for integrator in [Integrator::SymplecticEuler, Integrator::Leapfrog] {
        let halved = halved(explicit, HALVINGS);
        methods.extend(halved.map(|fraction| (method(integrator, 1), fraction)));
    }
    for fraction in halved(2.0, HALVINGS).filter(|fraction| *fraction > explicit) {
        let substeps = (fraction / explicit) as usize;
        methods.push((method(Integrator::SymplecticEuler, substeps), fraction));
    }
    let implicit = method(Integrator::Implicit, 1);
    methods.extend(halved(2.0, 2 * HALVINGS).map(|fraction| (implicit, fraction)));
    methods
}

/// The energy of a state, J, as if the actuators were idle. `None` if a law has no energy.
fn energy(case: &Case, state: &State<f64>) -> Option<f64> {
    let body = case.body();
    Store::new(&case.lattice, &case.physics, &body).energy(state)
}

fn relative(number: Option<f64>, truth: Option<f64>) -> Option<f64> {
    let (number, truth) = (number?, truth?);
    Some(relative_error(&[number], &[truth]))
}
