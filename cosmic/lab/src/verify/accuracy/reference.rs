//! The references of the errors, and their uncertainty.

use rayon::prelude::*;

use super::{Discretisation, Method, errors};
use cosmic::case::Case;
use cosmic::lattice::State;
use cosmic::scene::Integrator;
use cosmic::simulator::Trajectory;

/// The scene's time step over the mechanical step of a reference: the latter is 64 times shorter than
/// the shortest of any row, unless the scene itself has more than four substeps.
pub(super) const FINER: usize = 2048;
/// A distance from a reference counts as an error of the row from this many uncertainties of the
/// reference on. At three it is right to a third, the ratio of two of them to
/// (1 + 1/3) / (1 - 1/3) = 2, and an order from them to one.
pub(super) const RESOLVED: f64 = 3.0;

/// A run so fine that it stands for the truth.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Time step of its controller, s.
    pub dt: f64,
    /// Length of its mechanical steps, s.
    pub substep: f64,
    /// The uncertainty of distances from it, m, after each of [`super::Accuracy::times`]: the largest
    /// distance of a node from a run by the other integrator with equal steps, or from a run with
    /// mechanical steps twice as long, whichever is larger. Infinite if one of the three went astray.
    pub uncertainty: [f64; 4],
    seen: Trajectory<f64>,
}

impl Reference {
    /// Without `held`: the motion whose controller steps as often as the mechanics. With it: the
    /// motion whose controller holds its output for this share of the scene's time step, which is
    /// another motion for every share.
    pub(super) fn of(case: &Case, marks: [usize; 4], held: Option<f64>) -> Self {
        let share = held.unwrap_or(1.0);
        let ways = [
            (Integrator::Leapfrog, 1),
            (Integrator::SymplecticEuler, 1),
            (Integrator::Leapfrog, 2),
        ];
        let found = ways.par_iter().map(|&(integrator, coarser)| {
            let method = Method {
                integrator,
                substeps: 1,
            };
            let group = Discretisation { method, share };
            // Shares are powers of two: exact.
            let shorter = (FINER as f64 * share) as usize / coarser;
            let (finer, substeps) = match held {
                Some(_) => (1, shorter),
                None => (shorter, 1),
            };
            let fine = group.case(case, finer, substeps);
            (group.seen::<f64>(&fine, group.marks(marks, finer)), fine)
        });
        let mut found: Vec<(Trajectory<f64>, Case)> = found.collect();
        let mut states = found.iter().flat_map(|(seen, _)| &seen.states);
        let astray = states.any(State::is_absurd);
        let (seen, case) = found.remove(0);
        let [other, coarser] = [0, 1].map(|k| errors(&found[k].0, &seen));
        let least = if astray { f64::INFINITY } else { 0.0 };
        let uncertainty = |k: usize| least.max(other[k]).max(coarser[k]);
        Self {
            dt: case.physics.dt,
            substep: case.physics.dt / case.physics.substeps as f64,
            uncertainty: std::array::from_fn(uncertainty),
            seen,
        }
    }

    /// Distances from it, m; `None` where they may be errors of the reference itself.
    pub(super) fn errors(&self, seen: &Trajectory<f64>) -> [Option<f64>; 4] {
        let errors = errors(seen, &self.seen);
        std::array::from_fn(|k| {
            let least = RESOLVED * self.uncertainty[k];
            // NaN is an error beyond all bounds.
            let own = errors[k] >= least || errors[k].is_nan();
            (least.is_finite() && own).then_some(errors[k])
        })
    }

    /// True if runs that are nearly as fine agree with it.
    pub(super) fn is_sound(&self) -> bool {
        self.uncertainty.iter().all(|u| u.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::Reference;
    use cosmic::lattice::State;
    use cosmic::simulator::Trajectory;

    /// One node so far along at each of the times.
    fn along(x: [f64; 4]) -> Trajectory<f64> {
        let state = |x: f64| State {
            x: vec![[x, 0.0].into()],
            v: vec![[0.0; 2].into()],
        };
        Trajectory {
            steps: vec![1, 2, 3, 4],
            states: x.map(state).to_vec(),
        }
    }

    #[test]
    fn an_error_is_one_from_three_times_the_uncertainty_on() {
        let with = |uncertainty: [f64; 4]| Reference {
            dt: 1.0,
            substep: 1.0,
            uncertainty,
            seen: along([0.0; 4]),
        };
        let reference = with([1.0, 1.0, 1.0, 0.0]);
        let errors = reference.errors(&along([2.5, 3.0, f64::NAN, 0.0]));
        assert_eq!(errors[..2], [None, Some(3.0)]);
        // A row that went astray did so by any measure.
        assert!(errors[2].is_some_and(f64::is_nan) && errors[3] == Some(0.0));
        assert!(reference.is_sound());
        // Against a reference that did, nothing is known of any row.
        let astray = with([f64::INFINITY; 4]);
        assert_eq!(astray.errors(&along([9.0, 9.0, f64::NAN, 0.0])), [None; 4]);
        assert!(!astray.is_sound());
    }
}
