//! The trial of a robot with a time step.

use crate::verify::probe::{frequencies, most};
use cosmic::case::Case;
use cosmic::geometry::Vector;
use cosmic::lattice::{EdgeVector, State};
use cosmic::random::{Purpose, stream, symmetric};
use cosmic::simulator::stability::stable_step;
use cosmic::simulator::{Divergence, Grade, Span, Store};

/// The perturbation of a free robot's nodes at the start, as a fraction of its shortest edge. It is small
/// relative to the edges, so that springs answer linearly, and large relative to the softening of their
/// length (D4) and all roundings.
const MOVED: f64 = 1e-6;
/// Growth of a free robot's energy that no stable step shows. A step conserves an energy that differs
/// from the true one. At the fraction `s` of the limit the true energy swings by `1 / (1 - s^2)`, ten times
/// at 0.95; the first lengthening of the springs allows for as much again.
const ENERGY: f64 = 1e3;
/// The speed of a stable robot over that of anything that drives it, at most.
const SPEED: f64 = 10.0;

/// The surroundings of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum World {
    /// No ground, gravity or actuation: the energy of its vibrations is watched, or their speed if they
    /// have no energy.
    Free,
    /// The world of its case: its speed is watched, relative to the speed of what drives it.
    Driven,
}

/// A robot with a time step.
#[derive(Clone, Debug)]
pub(super) struct Trial {
    /// The kind of extreme.
    pub(super) group: &'static str,
    /// The robot in words.
    pub(super) what: String,
    pub(super) case: Case,
    world: World,
    /// The robot's largest frequency at rest, 1/s.
    frequency: f64,
    /// The smallest unstable time step, s; infinite if nothing vibrates.
    pub(super) limit: f64,
}

/// The outcome of a trial.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Outcome {
    /// Nothing grew.
    Bounded,
    /// Its energy, or its speed, grew beyond what a stable step allows.
    Grew,
    /// The guard found an absurd state.
    Diverged(Box<Divergence>),
}

/// A trial's result.
#[derive(Clone, Debug)]
pub(super) struct Found {
    /// The trial.
    pub(super) trial: Trial,
    /// The smallest unstable time step by the bound over the edges, s; infinite if nothing vibrates.
    pub(super) bound: f64,
    /// The result of the check of the time step beforehand.
    pub(super) grade: Grade,
    /// The outcome.
    pub(super) outcome: Outcome,
    /// The largest energy of a free robot, or the largest speed, in units of the largest that a stable step
    /// allows.
    pub(super) growth: f64,
    /// True if a number was not finite although no divergence was found.
    pub(super) unannounced: bool,
}

impl Found {
    /// True if the time step is below the limit.
    pub(super) fn expected_stable(&self) -> bool {
        self.trial.case.physics.dt < self.trial.limit
    }

    /// True if the outcome is as expected: a stable robot stays bounded, and an unstable one grows and
    /// was called unstable beforehand.
    pub(super) fn is_ok(&self) -> bool {
        let unstable = !self.expected_stable();
        let grew = self.outcome != Outcome::Bounded;
        let warned = self.grade == Grade::Unstable;
        (grew, warned) == (unstable, unstable) && !self.unannounced
    }
}

impl Trial {
    /// A robot with the time step of its case. A free robot is silenced.
    pub(super) fn new(group: &'static str, what: &str, mut case: Case, world: World) -> Self {
        if world == World::Free {
            // Actuators without stroke, which would stretch springs that stiffen.
            case.materials.max_strain = [0.0; 3];
            case.controller = case.controller.map(|_| 0.0);
        }
        let [frequency, _, damping] = frequencies(&case, &case.lattice.positions);
        Self {
            group,
            what: what.to_owned(),
            limit: stable_step(&case.physics, frequency, damping),
            case,
            world,
            frequency,
        }
    }

    /// The same robot with a fraction of its limit as its time step.
    pub(super) fn at(&self, fraction: f64) -> Self {
        let mut trial = self.clone();
        trial.what = format!("{}, dt {fraction} of the limit", self.what);
        trial.case.physics.dt = fraction * self.limit;
        trial
    }

    /// Runs it.
    pub(super) fn run(&self) -> Found {
        let case = self.prepared();
        let (task, design) = (case.task(), case.own_design());
        // For the lattice at rest, wherever its nodes start.
        let check = task.step_check(&design, &case.lattice.positions, 1.0);
        let span = Span::from_start((0..=case.physics.steps).collect());
        let guarded = task.guarded(&design, &case.controller, &case.start, &span);
        let states = &guarded.trajectory.states;
        let free = self.world == World::Free;
        let growth = free.then(|| energy_growth(&case, states)).flatten();
        let growth = growth.unwrap_or_else(|| self.speed_growth(&case, states));
        let finite = states.iter().all(is_finite);
        Found {
            trial: self.clone(),
            bound: check.bound.dt.unwrap_or(f64::INFINITY),
            grade: check.grade(),
            unannounced: !finite && guarded.divergence.is_none(),
            outcome: match guarded.divergence {
                Some(divergence) => Outcome::Diverged(Box::new(divergence)),
                // NaN counts as growth.
                None if growth < 1.0 => Outcome::Bounded,
                None => Outcome::Grew,
            },
            growth,
        }
    }

    /// The case as it runs: a free robot is lifted off the ground and given a push.
    fn prepared(&self) -> Case {
        let mut case = self.case.clone();
        // A trial may grow without a bound on speed; only the guard stops it.
        case.physics.speed_bound = None;
        if self.world == World::Driven {
            return case;
        }
        case.physics.gravity = 0.0;
        // Far below, but near enough for sums with a height to keep their digits.
        case.physics.ground_height = -1e3 * longest_edge(&case);
        let shortest = case.lattice.rest_length.iter().copied();
        let limit = MOVED * shortest.fold(f64::INFINITY, f64::min);
        let mut stream = stream(0, Purpose::Verification);
        for x in case.start.x.iter_mut().flat_map(Vector::iter_mut) {
            *x += symmetric(&mut stream, limit);
        }
        case
    }

    /// The highest speed of any node over its bound: [`SPEED`] times the sum of the speed that gravity adds
    /// in the whole time and the speed of the fastest vibration, whose amplitude is an actuator's stroke
    /// plus the edges' largest distance from rest at the start.
    fn speed_growth(&self, case: &Case, states: &[State<f64>]) -> f64 {
        let physics = &case.physics;
        let fall = physics.gravity.abs() * physics.dt * physics.steps as f64;
        let strain = case.materials.max_strain.into_iter().fold(0.0, f64::max);
        let edges = case.lattice.edges.iter().zip(&case.lattice.rest_length);
        let off_rest =
            edges.map(|(&edge, rest)| (EdgeVector::of(&case.start, edge).length() - rest).abs());
        let stroke = strain * longest_edge(case) + off_rest.fold(0.0, f64::max);
        let speeds = states.iter().flat_map(State::speeds);
        match most(speeds) {
            // Nothing moves.
            0.0 => 0.0,
            speed => speed / (SPEED * (fall + stroke * self.frequency)),
        }
    }
}

/// The longest rest length, m.
fn longest_edge(case: &Case) -> f64 {
    case.lattice.rest_length.iter().copied().fold(0.0, f64::max)
}

fn is_finite(state: &State<f64>) -> bool {
    let mut numbers = [&state.x, &state.v].into_iter().flatten().flatten();
    numbers.all(|c| c.is_finite())
}

/// The most energy of any state over that of the start, in units of [`ENERGY`]; `None` if a force has no
/// energy, such as the force of a damper.
fn energy_growth(case: &Case, states: &[State<f64>]) -> Option<f64> {
    let body = case.body();
    let store = Store::new(&case.lattice, &case.physics, &body);
    let at_start = store.energy(&case.start)?;
    let energies: Option<Vec<f64>> = states.iter().map(|state| store.energy(state)).collect();
    Some(most(energies?.into_iter()) / (ENERGY * at_start))
}
