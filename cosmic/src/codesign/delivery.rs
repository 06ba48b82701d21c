//! The result: which iterate is delivered, and how far it gets.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{CoDesign, Progress};
use crate::controller::Controller;
use crate::design::{self, Material};
use crate::lattice::State;
use crate::projection;
use crate::random::{Purpose, stream, symmetric};
use crate::scene::SelectionKind;

/// Displacements along the ground over perturbed starts, in metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// 10 % quantile.
    pub p10: f64,
    /// Median: the figure to quote.
    pub p50: f64,
    /// 90 % quantile.
    pub p90: f64,
}

impl Spread {
    /// The quantiles of a sample, linear between its members. One that diverged counts as not
    /// having moved at all, below every other.
    pub fn of(sample: &[f64]) -> Self {
        let finite = |x: &f64| if x.is_finite() { *x } else { f64::MIN };
        let mut sorted: Vec<f64> = sample.iter().map(finite).collect();
        sorted.sort_by(f64::total_cmp);
        let quantile = |q: f64| {
            let at = q * (sorted.len() - 1) as f64;
            let (below, share) = (at.floor() as usize, at.fract());
            let above = sorted[(below + 1).min(sorted.len() - 1)];
            sorted[below] + share * (above - sorted[below])
        };
        Self {
            p10: quantile(0.1),
            p50: quantile(0.5),
            p90: quantile(0.9),
        }
    }
}

/// What an optimisation delivers.
#[derive(Clone, Debug, PartialEq)]
pub struct Delivery {
    /// Design vectors; one-hot after the snap.
    pub z: Vec<[f64; 3]>,
    /// The material of every edge.
    pub materials: Vec<Material>,
    /// The controller.
    pub controller: Controller<f64>,
    /// The iteration after which the controller stood.
    pub iteration: usize,
    /// Displacement of the payload in one unperturbed rollout, x and y of the world, m.
    pub displacement: [f64; 2],
    /// The same along the ground, m.
    pub along: f64,
    /// Displacements along the ground from perturbed starts, other ones than those that chose.
    pub spread: Spread,
    /// Those of the last iterate, from the same starts.
    pub last: Spread,
    /// Share of solid edges and share of actuators.
    pub volumes: [f64; 2],
}

impl CoDesign {
    /// Picks the controller to deliver and measures it in full rollouts.
    ///
    /// Before the snap there is no layout yet: each edge is then given its dominant material, to
    /// show what a snap would leave.
    pub fn deliver(&self, progress: &Progress) -> Delivery {
        let materials: Vec<Material> = match &progress.materials {
            Some(materials) => materials.clone(),
            None => progress.z.iter().map(design::dominant).collect(),
        };
        let mixture = projection::one_hot(&materials);
        let last = (progress.iteration, &progress.controller);
        let mut entrants = vec![last];
        if self.scene.selection.kind == SelectionKind::Median {
            entrants.extend(
                progress
                    .candidates
                    .iter()
                    .map(|c| (c.iteration, &c.controller)),
            );
        }
        let starts = self.perturbed_starts(progress.seed, Purpose::Selection);
        let controllers: Vec<_> = entrants.iter().map(|(_, controller)| *controller).collect();
        let medians = self
            .spreads(&mixture, &controllers, &starts)
            .into_iter()
            .map(|s| s.p50);
        // The earliest of equals, and that is the last iterate.
        let best = medians
            .enumerate()
            .fold((0, f64::NEG_INFINITY), |best, (k, median)| {
                if median > best.1 { (k, median) } else { best }
            });
        let (iteration, controller) = entrants[best.0];

        let starts = self.perturbed_starts(progress.seed, Purpose::Judgement);
        let spreads = self.spreads(&mixture, &[controller, &progress.controller], &starts);
        let moved = self.reach(&mixture, controller, &self.start);
        let share = |is: fn(&Material) -> bool| {
            materials.iter().filter(|m| is(m)).count() as f64 / materials.len() as f64
        };
        Delivery {
            z: progress.z.clone(),
            volumes: [share(|m| m.is_solid()), share(|m| *m == Material::Actuator)],
            controller: controller.clone(),
            iteration,
            displacement: self.loss.ground.vector_to_world(moved),
            along: moved[0],
            spread: spreads[0],
            last: spreads[1],
            materials,
        }
    }

    /// Starts with every coordinate moved by as much as the scene says, up or down.
    fn perturbed_starts(&self, seed: u64, purpose: Purpose) -> Vec<State<f64>> {
        let settings = &self.scene.selection;
        let mut stream = stream(seed, purpose);
        let mut moved = |x: f64| x + settings.perturbation.copysign(symmetric(&mut stream, 1.0));
        let mut start = || State {
            x: self.start.x.iter().map(|x| x.map(&mut moved)).collect(),
            v: self.start.v.clone(),
        };
        (0..settings.perturbed_rollouts).map(|_| start()).collect()
    }

    /// The spread of every controller over the same starts; in parallel, the order kept.
    fn spreads(
        &self,
        mixture: &[[f64; 3]],
        controllers: &[&Controller<f64>],
        starts: &[State<f64>],
    ) -> Vec<Spread> {
        let pairs: Vec<_> = controllers
            .iter()
            .flat_map(|&c| starts.iter().map(move |start| (c, start)))
            .collect();
        let reach = |(controller, start): &(&Controller<f64>, &State<f64>)| {
            self.reach(mixture, controller, start)[0]
        };
        let reached: Vec<f64> = pairs.par_iter().map(reach).collect();
        reached.chunks_exact(starts.len()).map(Spread::of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::Spread;

    #[test]
    fn quantiles_are_linear_between_members() {
        let spread = Spread::of(&[4.0, 1.0, 3.0, 2.0, 5.0]);
        assert_eq!((spread.p50, spread.p90), (3.0, 4.6));
        assert!((spread.p10 - 1.4).abs() < 1e-15);
        assert_eq!(Spread::of(&[1.0, 2.0, 4.0, 8.0]).p50, 3.0);
    }

    #[test]
    fn a_diverged_rollout_counts_lowest() {
        let spread = Spread::of(&[2.0, f64::NAN, 3.0, f64::INFINITY]);
        assert!(spread.p10 < 0.0 && spread.p90 < 3.0);
    }
}
