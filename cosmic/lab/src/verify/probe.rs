//! A case that is run repeatedly, in any precision; small functions on numbers.

use autodiff::Real;

use cosmic::case::Case;
use cosmic::domain::perturbed;
use cosmic::geometry::Vector;
use cosmic::lattice::State;
use cosmic::random::{Purpose, stream};
#[cfg(test)]
use cosmic::scene::Scene;
use cosmic::simulator::stability::Vibration;
use cosmic::simulator::{Span, Trajectory};
use cosmic::task::Task;

/// The robot of a case in its world.
pub(super) struct Probe<'a> {
    pub(super) case: &'a Case,
    pub(super) task: Task,
    /// Computed in f64 and then lifted, so that every precision runs the same robot.
    mixture: Vec<[f64; 3]>,
}

impl<'a> Probe<'a> {
    pub(super) fn new(case: &'a Case) -> Self {
        Self {
            case,
            task: case.task(),
            mixture: case.own_mixture(),
        }
    }

    /// The observed states of a rollout from the case's start in a number type, rounded to f64.
    pub(super) fn run<R: Real + Into<f64>>(&self, observed: Vec<usize>) -> Trajectory<f64> {
        let mixture: Vec<[R; 3]> = self.mixture.iter().map(|m| m.map(R::lit)).collect();
        let (controller, start) = (
            self.case.controller.map(R::lit),
            self.case.start.map(R::lit),
        );
        let span = Span::from_start(observed);
        let Trajectory { steps, states } =
            (self.task).rollout(&mixture, &controller, &start, &span);
        let states = states.iter().map(|state| state.map(R::into)).collect();
        Trajectory { steps, states }
    }

    /// The observed states of rollouts from several starts, in f64.
    pub(super) fn run_batch(
        &self,
        starts: &[State<f64>],
        observed: &[usize],
    ) -> Vec<Trajectory<f64>> {
        let span = Span::from_start(observed.to_vec());
        (self.task).rollout_many(&[&self.mixture], &self.case.controller, starts, &span)
    }

    /// Starts with every coordinate moved by `distance`, up or down. Cases of equal size get equal
    /// moves.
    pub(super) fn moved_starts(&self, count: usize, distance: f64) -> Vec<State<f64>> {
        let mut stream = stream(0, Purpose::Verification);
        let mut start = || perturbed(&self.case.start, distance, &mut stream);
        (0..count).map(|_| start()).collect()
    }
}

/// The largest frequency of a case's robot with its nodes at some positions, the bound over the edges on
/// it, and the rate at which forces dampen a vibration at most, 1/s.
pub(super) fn frequencies(case: &Case, positions: &[Vector<f64>]) -> [f64; 3] {
    let body = case.body();
    let vibration = Vibration::new(&case.lattice, &body, &case.physics, positions);
    [
        vibration.largest_frequency(),
        vibration.edge_bound(),
        vibration.damping(),
    ]
}

/// The largest distance between the nodes of two states, m; NaN if any is NaN.
pub(super) fn distance(a: &State<f64>, b: &State<f64>) -> f64 {
    let pairs = a.x.iter().zip(&b.x);
    most(pairs.map(|(a, b)| a.distance(*b)))
}

/// The largest of 0 and some numbers; NaN, which `f64::max` would drop, if any is NaN.
pub(super) fn most(numbers: impl Iterator<Item = f64>) -> f64 {
    numbers.fold(0.0, |most, x| if x > most || x.is_nan() { x } else { most })
}

/// The scalar product.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The length of a vector.
pub(super) fn norm(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

/// The median; NaN counts as the largest number.
pub(super) fn median(numbers: impl IntoIterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = numbers.into_iter().collect();
    sorted.sort_by(f64::total_cmp);
    0.5 * (sorted[(sorted.len() - 1) / 2] + sorted[sorted.len() / 2])
}

/// A case of `size` columns and rows with 2 hidden units; `change` edits its scene.
#[cfg(test)]
pub(super) fn small(size: [usize; 2], change: impl FnOnce(&mut Scene)) -> Case {
    let mut scene = Scene::paper();
    [scene.lattice.columns, scene.lattice.rows] = size;
    scene.controller.hidden = 2;
    change(&mut scene);
    Case::of_scene(&scene, 0).expect("the default start fits any lattice")
}

#[cfg(test)]
mod tests {
    use super::median;

    #[test]
    fn medians_of_even_samples_lie_in_the_middle() {
        assert_eq!(median([3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median([4.0, 1.0, f64::INFINITY, 2.0]), 3.0);
    }
}
