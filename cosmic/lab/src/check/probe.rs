//! Simulates a case repeatedly, in f32 or f64. Also contains small functions on vectors.

use autodiff::{Parameters, Real};

use cosmic::case::Case;
use cosmic::design::{Design, Mixture};
use cosmic::geometry::Vector;
use cosmic::inputs::Inputs;
use cosmic::lattice::State;
use cosmic::random::{Purpose, stream};
use cosmic::world::stability::Vibration;
use cosmic::world::{Span, StepLimit, Variation, World, perturbed};

/// The distance, as a share of the lattice's scale, by which every coordinate of a start is moved to make a perturbed
/// start.
const MOVED: f64 = 1e-9;

/// The robot of a case in its world, ready to be simulated in any number type.
#[derive(Clone)]
pub(super) struct Probe<'a> {
    pub(super) case: &'a Case,
    pub(super) world: World,
    pub(super) inputs: Inputs<f64>,
    /// The design, computed in f64 and then converted, so that every number type runs the same robot.
    design: Design<Mixture<f64>>,
}

impl<'a> Probe<'a> {
    /// Prepares a case.
    pub(super) fn new(case: &'a Case) -> Self {
        Self {
            case,
            world: case.world(),
            inputs: case.inputs(),
            design: case.own_design(),
        }
    }

    /// Rolls out the case from each of several starts. Returns, for each start, the states after the numbers of steps in
    /// `observed`, rounded to f64.
    pub(super) fn run<R: Real + Into<f64>>(
        &self,
        starts: &[State<f64>],
        observed: &[usize],
    ) -> Vec<Vec<State<f64>>> {
        let world = &self.world;
        let nominal = world.nominal(&self.case.start);
        let from = |start: &State<f64>| Variation {
            start: start.clone(),
            ..nominal.clone()
        };
        let variations: Vec<Variation> = starts.iter().map(from).collect();
        let robots: Vec<_> = variations.iter().map(|v| (&self.design, v)).collect();
        let robots = world.robots::<R>(&robots, &self.case.controller);
        let span = Span::from_start(observed.to_vec());
        let seen = world.run(&robots, &span);
        let states =
            |states: Vec<State<R>>| states.iter().map(|state| state.map(R::into)).collect();
        seen.into_iter().map(|seen| states(seen.states)).collect()
    }

    /// Rolls out the case from its own start; see [`run`](Self::run).
    pub(super) fn run_own<R: Real + Into<f64>>(&self, observed: &[usize]) -> Vec<State<f64>> {
        let starts = std::slice::from_ref(&self.case.start);
        self.run::<R>(starts, observed).remove(0)
    }
}

/// Returns copies of a case's start, in which every coordinate is moved forwards or back at random. Cases of equal size
/// get equal moves.
pub(super) fn moved_starts(case: &Case, count: usize) -> Vec<State<f64>> {
    let mut stream = stream(0, Purpose::Verification);
    let moved_by = MOVED * case.lattice.scale;
    let mut start = || perturbed(&case.start, moved_by, &mut stream);
    (0..count).map(|_| start()).collect()
}

/// The limits of the time step of a case's robot with its nodes at `positions`: by the largest frequency, and by the bound
/// from single edges.
pub(super) fn step_limits(case: &Case, positions: &[Vector<f64>]) -> [StepLimit; 2] {
    let (body, physics) = (case.body(), &case.scene.physics);
    let vibration = Vibration::new(&case.lattice, &body, physics, positions);
    [
        StepLimit::exact(&vibration, physics),
        StepLimit::safe(&vibration, 1.0, physics),
    ]
}

/// The smallest time step, s, with which a vibration of a case's robot about its start grows.
pub(super) fn largest_stable_step(case: &Case) -> f64 {
    step_limits(case, &case.start.x)[0].step()
}

/// The largest distance of any node between its positions in two states, in metres; NaN if any distance is NaN.
pub(super) fn distance(a: &State<f64>, b: &State<f64>) -> f64 {
    let pairs = a.x.iter().zip(&b.x);
    most(pairs.map(|(a, b)| a.distance(*b)))
}

/// The largest of the numbers, or 0 if all are negative; NaN if any number is NaN. In contrast, `f64::max` ignores NaN.
pub(super) fn most(numbers: impl Iterator<Item = f64>) -> f64 {
    numbers.fold(0.0, |most, x| if x > most || x.is_nan() { x } else { most })
}
