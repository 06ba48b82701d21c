//! Simulates a case repeatedly, with or without derivatives, in any number type. Also contains small functions on
//! vectors.

use autodiff::{Real, Var};

use cosmic::case::Case;
use cosmic::design::{Design, Mixture};
use cosmic::domain::perturbed;
use cosmic::geometry::Vector;
use cosmic::inputs::{Block, Inputs};
use cosmic::lattice::State;
use cosmic::random::{Purpose, stream};
use cosmic::scene::{PhysicsSettings, stable_step};
use cosmic::simulator::Span;
use cosmic::simulator::stability::Vibration;
use cosmic::task::Task;

/// The distance, as a share of the lattice's scale, by which every coordinate of a start is moved to make a perturbed
/// start.
const MOVED: f64 = 1e-9;

/// The robot of a case in its world, ready to be simulated in any number type.
#[derive(Clone)]
pub struct Probe<'a> {
    pub(super) case: &'a Case,
    pub(super) task: Task,
    pub(super) inputs: Inputs<f64>,
    /// The design, computed in f64 and then converted, so that every number type runs the same robot.
    design: Design<Mixture<f64>>,
}

impl<'a> Probe<'a> {
    /// Prepares a case.
    pub fn new(case: &'a Case) -> Self {
        Self {
            case,
            task: case.task(),
            inputs: case.inputs(),
            design: case.own_design(),
        }
    }

    /// Rolls out the case from its start. Returns its states after the numbers of steps in `observed`, rounded to f64.
    pub fn run<R: Real + Into<f64>>(&self, observed: &[usize]) -> Vec<State<f64>> {
        let (design, inputs) = (self.design.lift(), self.inputs.lift::<R>());
        let span = Span::from_start(observed.to_vec());
        let seen = (self.task).rollout(&design, &inputs.controller, &inputs.start, &span);
        seen.states.iter().map(|state| state.map(R::into)).collect()
    }

    /// Rolls out the case in f64 from each of several starts. Returns, for each start, the states after the numbers of
    /// steps in `observed`.
    pub(super) fn run_batch(
        &self,
        starts: &[State<f64>],
        observed: &[usize],
    ) -> Vec<Vec<State<f64>>> {
        let (designs, span) = ([&self.design], Span::from_start(observed.to_vec()));
        let seen = (self.task).rollout_many(&designs, &self.case.controller, starts, &span);
        seen.into_iter().map(|seen| seen.states).collect()
    }

    /// The distance by which [`moved_starts`](Self::moved_starts) moves every coordinate, in metres.
    pub(super) fn moved_by(&self) -> f64 {
        MOVED * self.case.lattice.scale
    }

    /// Returns copies of the case's start, in which every coordinate is moved forwards or back at random.
    /// Cases of equal size get equal moves.
    pub(super) fn moved_starts(&self, count: usize) -> Vec<State<f64>> {
        let mut stream = stream(0, Purpose::Verification);
        let mut start = || perturbed(&self.case.start, self.moved_by(), &mut stream);
        (0..count).map(|_| start()).collect()
    }

    /// Computes a loss and its gradient with respect to some blocks of the inputs, by reverse mode.
    pub(super) fn reverse<R: Real>(
        &self,
        blocks: &[Block],
        loss: impl FnOnce(&Inputs<Var<R>>) -> Var<R>,
    ) -> (R, Vec<R>) {
        self.inputs.lift().differentiate(blocks, loss)
    }
}

/// The smallest time step, s, with which a vibration of a case's robot grows, with its nodes at `positions`.
pub fn stable_step_at(case: &Case, positions: &[Vector<f64>]) -> f64 {
    let [frequency, _, damping] = frequencies(case, positions);
    let limit = stable_step(&case.physics, frequency, damping);
    limit.min(step_off_bars(case, &case.physics, positions))
}

/// The smallest time step, s, with which forces that an implicit step of `physics` does not solve for make a vibration grow.
/// Infinite for explicit steps.
pub fn step_off_bars(case: &Case, physics: &PhysicsSettings, positions: &[Vector<f64>]) -> f64 {
    let body = case.body();
    Vibration::new(&case.lattice, &body, &case.physics, positions).step_off_bars(physics)
}

/// Returns three numbers in 1/s for a case's robot with its nodes at `positions`: its largest frequency, an upper bound
/// on this frequency that follows from the single edges, and the largest rate at which forces damp a vibration.
pub fn frequencies(case: &Case, positions: &[Vector<f64>]) -> [f64; 3] {
    let body = case.body();
    let vibration = Vibration::new(&case.lattice, &body, &case.physics, positions);
    [
        vibration.largest_frequency(),
        vibration.edge_bound(),
        vibration.damping(),
    ]
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

/// The scalar product of two vectors.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The Euclidean norm of a vector.
pub(super) fn norm(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

/// The norm of the difference of two vectors, divided by the norm of the second vector unless that is zero.
pub fn relative_error(got: &[f64], right: &[f64]) -> f64 {
    let off: Vec<f64> = got.iter().zip(right).map(|(a, b)| a - b).collect();
    let size = norm(right);
    norm(&off) / if size > 0.0 { size } else { 1.0 }
}
