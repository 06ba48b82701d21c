//! A trial runs a robot with a time step and watches whether its energy or its speed grows.

use autodiff::Parameters;

use crate::check::probe::{most, step_limits};
use cosmic::case::Case;
use cosmic::lattice::{EdgeVector, State};
use cosmic::laws::ContactLaw;
use cosmic::random::{Purpose, stream, symmetric};
use cosmic::scene::Integrator;
use cosmic::walk::{self, Divergence, IdleEnergy};
use cosmic::world::{Grade, Span};

/// At the start, the nodes of a free robot are moved by this fraction of its shortest edge. The move is so small that
/// springs respond linearly, but large compared with rounding errors and with the softening of lengths (D4).
const MOVED: f64 = 1e-6;
/// If a free robot's energy grows by more than this factor, the time step is unstable. A stable step does not conserve
/// the true energy but one close to it: with a step of `s` times the limit, the true energy swings by a factor of `1 /
/// (1 - s^2)`, which is ten at 0.95. The first lengthening of the springs may add another factor of ten.
const ENERGY: f64 = 1e3;
/// A bound on the speed of a stable robot, as a multiple of the speeds that gravity, actuators and the start cause.
const SPEED: f64 = 10.0;

/// The surroundings of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Setting {
    /// A world without ground, gravity and actuation. The energy of the robot's vibrations is watched. If a force has
    /// no energy, their speed is watched instead.
    Free,
    /// The world of the case. The robot's speed is watched, relative to the speeds that gravity, actuators and the
    /// start cause.
    Driven,
}

/// A robot, its world and a time step to try.
#[derive(Clone, Debug)]
pub struct Trial {
    /// The kind of extreme robot to which the trial belongs, such as `stiffness` or `mass`.
    pub group: &'static str,
    /// A description of the robot and the time step.
    pub what: String,
    /// The robot.
    pub case: Case,
    world: Setting,
    /// The angular frequency at rest that limits the time step, in 1/s.
    frequency: f64,
    /// The limit of stability: the smallest unstable time step, in seconds; infinite if nothing vibrates.
    pub limit: f64,
}

/// The outcome of a trial.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// Neither the energy nor the speed grew.
    Bounded,
    /// The energy or the speed grew more than a stable time step allows.
    Grew,
    /// The guard of the rollout found a state that is not plausible.
    Diverged(Box<Divergence>),
}

/// The result of a trial.
#[derive(Clone, Debug)]
pub struct Found {
    /// The trial.
    pub trial: Trial,
    /// The grade of the time step according to the check before the run.
    pub grade: Grade,
    /// The outcome of the run.
    pub outcome: Outcome,
    /// The growth: the largest energy of a free robot, or the largest speed of any other robot, divided by the largest
    /// value that a stable time step allows.
    pub growth: f64,
    /// True if a number was not finite although no divergence was reported.
    pub unannounced: bool,
}

impl Found {
    /// True if the trial is expected to be stable: its time step is below the limit.
    pub fn expected_stable(&self) -> bool {
        self.trial.case.scene.physics.dt < self.trial.limit
    }

    /// True if the trial went as expected: a stable robot stayed bounded and was not called unstable; an unstable robot
    /// grew and was called unstable beforehand.
    pub fn is_ok(&self) -> bool {
        let unstable = !self.expected_stable();
        let grew = self.outcome != Outcome::Bounded;
        let warned = self.grade == Grade::Unstable;
        (grew, warned) == (unstable, unstable) && !self.unannounced
    }
}

impl Trial {
    /// Makes a trial of a case with the case's time step. The actuators of a free robot are switched off.
    pub(super) fn new(group: &'static str, what: &str, mut case: Case, world: Setting) -> Self {
        if world == Setting::Free {
            // Actuators get no stroke, because a stroke would stretch springs that stiffen.
            case.scene.materials.max_strain = [0.0; 3];
            case.controller = case.controller.map(|_| 0.0);
        }
        let [limit, _] = step_limits(&case, &case.lattice.positions);
        Self {
            group,
            what: what.to_owned(),
            limit: limit.step(),
            case,
            world,
            frequency: limit.frequency,
        }
    }

    /// Makes a trial of the same robot whose time step is `fraction` times its limit.
    pub(super) fn at(&self, fraction: f64) -> Self {
        let mut trial = self.clone();
        trial.what = format!("{}, dt {fraction} of the limit", self.what);
        trial.case.scene.physics.dt = fraction * self.limit;
        trial
    }

    /// Runs the trial and returns its result.
    pub fn run(&self) -> Found {
        let case = self.prepared();
        let (world, design) = (case.world(), case.own_design());
        // The time step is checked for the lattice at rest, even if its nodes start elsewhere.
        let any_design = world.stable_step_of_any_design(1.0);
        let check = world.step_check(&design, &case.lattice.positions, 1.0, any_design);
        let span = Span::from_start((0..=case.scene.physics.steps).collect());
        let guarded = walk::guarded(&world, &case.robot(), &span);
        let states = &guarded.trajectory.states;
        // Rounding strains the bars of an implicit step with a very long time step, so their energy has no meaning.
        let has_energy = self.world == Setting::Free && !self.is_implicit();
        let growth = has_energy.then(|| energy_growth(&case, states)).flatten();
        let growth = growth.unwrap_or_else(|| self.speed_growth(&case, states));
        let finite = states.iter().all(is_finite);
        Found {
            trial: self.clone(),
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

    pub(super) fn is_implicit(&self) -> bool {
        self.case.scene.physics.integrator == Integrator::Implicit
    }

    /// Returns the case to run. A free robot has no ground and no gravity, and its nodes are moved a little.
    fn prepared(&self) -> Case {
        let mut case = self.case.clone();
        // Without a bound, the speed may grow until the guard stops the rollout.
        case.scene.physics.speed_bound = None;
        if self.world == Setting::Driven {
            return case;
        }
        (case.scene.physics.gravity, case.scene.physics.contact) = (0.0, ContactLaw::none());
        let shortest = case.lattice.rest_length.iter().copied();
        let limit = MOVED * shortest.fold(f64::INFINITY, f64::min);
        let mut stream = stream(0, Purpose::Verification);
        for x in &mut case.start.x {
            *x = case
                .start
                .dimension
                .map(*x, |x| x + symmetric(&mut stream, limit));
        }
        case
    }

    /// Returns the highest speed of any node, divided by a bound on the speed. The bound is [`SPEED`] times the sum of
    /// two speeds: the speed that gravity adds during the whole trial, and the speed of the fastest vibration. The
    /// amplitude of that vibration is taken to be an actuator's stroke plus the largest change of an edge's length from
    /// its rest length at the start.
    fn speed_growth(&self, case: &Case, states: &[State<f64>]) -> f64 {
        let physics = &case.scene.physics;
        let fall = physics.gravity.abs() * physics.dt * physics.steps as f64;
        let strain = case
            .scene
            .materials
            .max_strain
            .into_iter()
            .fold(0.0, f64::max);
        let edges = case.lattice.edges.iter().zip(&case.lattice.rest_length);
        let off_rest = edges.map(|(&edge, rest)| {
            (EdgeVector::of(&case.start, edge).length(case.lattice.softening()) - rest).abs()
        });
        let stroke = strain * longest_edge(case) + off_rest.fold(0.0, f64::max);
        let speeds = states.iter().flat_map(State::speeds);
        match most(speeds) {
            // Nothing moves.
            0.0 => 0.0,
            speed => speed / (SPEED * (fall + stroke * self.frequency)),
        }
    }
}

/// The rest length of the longest edge, in metres.
fn longest_edge(case: &Case) -> f64 {
    case.lattice.rest_length.iter().copied().fold(0.0, f64::max)
}

fn is_finite(state: &State<f64>) -> bool {
    let mut vectors = [&state.x, &state.v].into_iter().flatten();
    vectors.all(|vector| vector.is_finite())
}

/// Returns the largest energy of any state, divided by the energy of the start and by [`ENERGY`]. Returns `None` if a
/// force has no energy, such as the force of a damper.
fn energy_growth(case: &Case, states: &[State<f64>]) -> Option<f64> {
    let body = case.body();
    let store = IdleEnergy::new(&case.lattice, &case.scene.physics, &body);
    let at_start = store.energy(&case.start)?;
    let energies: Option<Vec<f64>> = states.iter().map(|state| store.energy(state)).collect();
    Some(most(energies?.into_iter()) / (ENERGY * at_start))
}
