//! The trial of a robot with a time step.

use crate::verify::probe::most;
use cosmic::case::Case;
use cosmic::geometry::Vector;
use cosmic::lattice::Body;
use cosmic::lattice::{EdgeVector, State};
use cosmic::random::{Purpose, stream, symmetric};
use cosmic::simulator::stability::stable_step;
use cosmic::simulator::{Divergence, Grade, Guarded, Span, Store};

/// The perturbation of a free robot's nodes at the start, as a share of its shortest edge. It is small
/// beside the edges, so that springs answer linearly, and large beside the softening of their length
/// (D4) and all roundings.
const MOVED: f64 = 1e-6;
/// Growth of a free robot's energy that no stable step shows. A step conserves an energy that differs
/// from the true one. At the share `s` of the limit the true energy swings by `1 / (1 - s^2)`, ten times
/// at 0.95; the first lengthening of the springs allows for as much again.
const ENERGY: f64 = 1e3;
/// The speed of a stable robot over that of anything that drives it, at most.
const SPEED: f64 = 10.0;

/// The surroundings of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum World {
    /// No ground, gravity or actuation: the energy of its vibrations is watched, or their speed where they
    /// have none.
    Free,
    /// The world of its case: its speed is watched, against that of what drives it.
    Driven,
}

/// A robot with a time step.
#[derive(Clone, Debug)]
pub struct Trial {
    /// The kind of extreme.
    pub group: &'static str,
    /// The robot in words.
    pub what: String,
    /// The robot.
    pub case: Case,
    /// Its surroundings.
    pub world: World,
    /// The robot's largest frequency at rest, 1/s.
    pub frequency: f64,
    /// The rate, 1/s, at which its forces dampen a vibration at most.
    pub damping: f64,
}

/// The outcome of a trial.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// Nothing grew.
    Bounded,
    /// Its energy, or its speed, grew beyond what a stable step allows.
    Grew,
    /// The guard found an absurd state.
    Diverged(Box<Divergence>),
}

/// The expectation of a trial, and its outcome.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// As in the trial.
    pub group: &'static str,
    /// As in the trial.
    pub what: String,
    /// Nodes of the lattice.
    pub nodes: usize,
    /// The time step, s.
    pub dt: f64,
    /// The smallest unstable time step by the bound, s; infinite if nothing vibrates.
    pub bound: f64,
    /// The smallest unstable time step by the largest frequency, s.
    pub limit: f64,
    /// The result of the check of the time step beforehand.
    pub grade: Grade,
    /// The outcome.
    pub outcome: Outcome,
    /// Of a free robot the largest energy, otherwise the largest speed, in units of the largest that a
    /// stable step allows.
    pub growth: f64,
    /// True if a number was not finite although no divergence was found.
    pub unannounced: bool,
}

impl Found {
    /// True if the time step is below the limit.
    pub fn expected_stable(&self) -> bool {
        self.dt < self.limit
    }

    /// True if the program announced an instability, by the check of the time step or by the guard.
    pub fn is_announced(&self) -> bool {
        self.grade == Grade::Unstable || matches!(self.outcome, Outcome::Diverged(_))
    }

    /// True if the outcome is as expected.
    pub fn is_ok(&self) -> bool {
        let stable = self.expected_stable();
        let grew = self.outcome != Outcome::Bounded;
        let warned = self.grade == Grade::Unstable;
        (grew, warned) == (!stable, !stable) && !self.unannounced
    }
}

impl Trial {
    /// Runs it.
    pub fn run(&self) -> Found {
        let case = self.prepared();
        let (task, mixture) = (case.task(), case.own_mixture());
        let body = task.body(&mixture);
        // For the lattice at rest, wherever its nodes start.
        let check = task.step_check(&mixture, &case.lattice.positions, 1.0);
        let span = Span::from_start((0..=case.physics.steps).collect());
        let guarded = task.guarded(&mixture, &case.controller, &case.start, &span);
        let growth = match self.world {
            World::Free => energy_growth(&case, &body, &guarded),
            World::Driven => None,
        };
        let growth = growth.unwrap_or_else(|| speed_growth(&case, self.frequency, &guarded));
        let finite = guarded.trajectory.states.iter().all(is_finite);
        let unannounced = !finite && guarded.divergence.is_none();
        let outcome = match guarded.divergence {
            Some(divergence) => Outcome::Diverged(Box::new(divergence)),
            // NaN counts as growth.
            None if growth < 1.0 => Outcome::Bounded,
            None => Outcome::Grew,
        };
        Found {
            group: self.group,
            what: self.what.clone(),
            nodes: case.lattice.nodes(),
            dt: case.physics.dt,
            bound: check.bound.dt.unwrap_or(f64::INFINITY),
            limit: stable_step(&case.physics, self.frequency, self.damping),
            grade: check.grade(),
            outcome,
            growth,
            unannounced,
        }
    }

    /// The case as it runs: a free robot is silenced, lifted off the ground and given a push.
    fn prepared(&self) -> Case {
        let mut case = self.case.clone();
        // A trial may grow without a bound on speed; only the guard stops it.
        case.physics.speed_bound = None;
        if self.world == World::Driven {
            return case;
        }
        let mut case = silent(&case);
        case.physics.gravity = 0.0;
        // Far below, but near enough for sums with a height to keep their digits.
        case.physics.ground_height = -1e3 * reach(&case);
        let shortest = case.lattice.rest_length.iter().copied();
        let limit = MOVED * shortest.fold(f64::INFINITY, f64::min);
        let mut stream = stream(0, Purpose::Verification);
        for x in case.start.x.iter_mut().flat_map(Vector::iter_mut) {
            *x += symmetric(&mut stream, limit);
        }
        case
    }
}

/// The case with actuators that have no stroke, which would stretch springs that stiffen.
pub(super) fn silent(case: &Case) -> Case {
    let mut case = case.clone();
    case.materials.max_strain = [0.0; 3];
    case.controller = case.controller.map(|_| 0.0);
    case
}

/// The longest rest length, m.
fn reach(case: &Case) -> f64 {
    case.lattice.rest_length.iter().copied().fold(0.0, f64::max)
}

fn is_finite(state: &State<f64>) -> bool {
    let mut numbers = [&state.x, &state.v].into_iter().flatten().flatten();
    numbers.all(|c| c.is_finite())
}

/// The most energy of any state over that of the first, in units of [`ENERGY`]; `None` where a force has no
/// energy, as that of a damper.
fn energy_growth(case: &Case, body: &Body<f64>, guarded: &Guarded) -> Option<f64> {
    let store = Store::new(&case.lattice, &case.physics, body);
    let states = guarded.trajectory.states.iter();
    let energies: Option<Vec<f64>> = states.map(|state| store.energy(state)).collect();
    Some(most(energies?.into_iter()) / (ENERGY * store.energy(&case.start)?))
}

/// The highest speed of any node over its bound: [`SPEED`] times the sum of the speed that gravity adds in
/// the whole time and the speed of the fastest vibration, whose amplitude is an actuator's stroke plus the
/// edges' largest distance from rest at the start.
fn speed_growth(case: &Case, frequency: f64, guarded: &Guarded) -> f64 {
    let physics = &case.physics;
    let fall = physics.gravity.abs() * physics.dt * physics.steps as f64;
    let strain = case.materials.max_strain.into_iter().fold(0.0, f64::max);
    let edges = case.lattice.edges.iter().zip(&case.lattice.rest_length);
    let off_rest =
        edges.map(|(&edge, rest)| (EdgeVector::of(&case.start, edge).length() - rest).abs());
    let stroke = strain * reach(case) + off_rest.fold(0.0, f64::max);
    let states = guarded.trajectory.states.iter();
    let speeds = states.flat_map(State::speeds);
    match most(speeds) {
        // Nothing moves.
        0.0 => 0.0,
        speed => speed / (SPEED * (fall + stroke * frequency)),
    }
}
