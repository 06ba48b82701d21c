//! Full rollouts of robots: their displacement, and their merit, which is the number by which robots are ranked.

use autodiff::{Parameters, Real};
use rayon::prelude::*;

use super::evaluator::Evaluator;
use super::quantiles::Quantiles;
use super::reliability::Merit;
use crate::design::{Design, Material, Mixture};
use crate::geometry::Vector;
use crate::lattice::State;
use crate::objective::LossOf;
use crate::policy::Controller;
use crate::scene::{GoalKind, GradientPrecision, SelectionKind};
use crate::walk;
use crate::world::{Span, Trajectory, Variation, together};

/// The result of a full rollout. All its numbers are NaN if the rollout diverged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reached {
    /// Displacement of the payload, or of the body that the scene names, in metres: along the ground, across (0 for a
    /// planar robot), and normal to the ground.
    pub moved: Vector<f64>,
    /// The number that robots are ranked by: the displacement along the ground in metres; for tasks other than
    /// distance, minus the loss. A robot that was ranked in several rollouts has a quantile of their merits.
    pub merit: f64,
}

impl Reached {
    /// Displacement along the ground, in metres.
    pub fn along(&self) -> f64 {
        self.moved.forward()
    }
}

impl Evaluator {
    /// Simulates robots in full rollouts from the unperturbed start, in the precision of gradients, and returns their
    /// results. In a scene with the [selection](SelectionKind) `robust`, other rollouts vary the robots a little. The merit
    /// of a robot is the 10 % quantile over all of its rollouts, or the merit of the unperturbed one if that is lower. The
    /// seed determines the variations.
    pub(crate) fn ranked(
        &self,
        designs: &[Design<Mixture<f64>>],
        controller: &Controller<f64>,
        seed: u64,
    ) -> Vec<Reached> {
        if self.scene.selection.kind != SelectionKind::Robust {
            return self.reached(designs, controller);
        }
        let variations = self.ranking_variations(seed);
        let precision = self.scene.gradient.precision;
        let rank = |reached: &[Reached]| {
            let merits: Vec<f64> = reached.iter().map(|r| r.merit).collect();
            let merit = Quantiles::of(&merits).p10.min(merits[0]);
            Reached {
                merit: if merit.is_finite() { merit } else { f64::NAN },
                ..reached[0]
            }
        };
        let alone = |design: &Design<Mixture<f64>>| {
            rank(&self.reach_many(&robots_of(design, &variations), controller, precision))
        };
        designs.par_iter().map(alone).collect()
    }

    /// [Ranks](Self::ranked) a layout and its alternatives (`others`). Returns the best layout and the result of its
    /// rollout. Of equally good layouts, it returns the first. A layout without alternatives needs no rollout.
    pub(crate) fn best_layout(
        &self,
        layout: Vec<Material>,
        others: impl IntoIterator<Item = Vec<Material>>,
        controller: &Controller<f64>,
        seed: u64,
    ) -> (Vec<Material>, Option<Reached>) {
        let mut layouts: Vec<_> = std::iter::once(layout).chain(others).collect();
        if layouts.len() == 1 {
            return (layouts.remove(0), None);
        }
        let designs: Vec<_> = layouts.iter().cloned().map(Design::Layout).collect();
        let reached = self.ranked(&designs, controller, seed);
        let best = first_best(reached.iter().map(|r| [r.merit]));
        (layouts.swap_remove(best), Some(reached[best]))
    }

    /// The results of robots with one controller in full rollouts from the unperturbed start, in the order of the designs.
    /// The rollouts run in parallel, in the precision of gradients. For perturbed starts, call
    /// [`reach_many`](Self::reach_many) with f64, because rounding to f32 would remove a perturbation of a nanometre.
    pub(crate) fn reached(
        &self,
        designs: &[Design<Mixture<f64>>],
        controller: &Controller<f64>,
    ) -> Vec<Reached> {
        let (precision, nominal) = (self.scene.gradient.precision, self.nominal());
        let side_by_side = |designs: &[_]| {
            let robots: Vec<Entry> = designs.iter().map(|design| (design, &nominal)).collect();
            self.reach_many(&robots, controller, precision)
        };
        let groups = designs.par_chunks(together(designs.len()));
        groups.flat_map_iter(side_by_side).collect()
    }

    /// Simulates a robot with a variation in a full rollout, and returns the result.
    pub fn reach(
        &self,
        design: &Design<Mixture<f64>>,
        controller: &Controller<f64>,
        variation: &Variation,
    ) -> Reached {
        self.reach_many(&[(design, variation)], controller, GradientPrecision::F64)[0]
    }

    /// The kind of merit by which robots of this scene are ranked.
    pub(crate) fn merit(&self) -> Merit {
        let scale = self.world.lattice().scale;
        match (self.loss.is_far(), self.scene.controller.goals) {
            (true, _) => Merit::Distance { scale },
            (false, GoalKind::Fixed) => Merit::MinusLoss,
            (false, GoalKind::Given) => Merit::MinusShare,
        }
    }

    /// Simulates robots in full rollouts, side by side, and returns their results. The world may have shorter time steps than
    /// the scene, in whose steps the loss counts.
    pub(super) fn reach_many(
        &self,
        robots: &[Entry],
        controller: &Controller<f64>,
        precision: GradientPrecision,
    ) -> Vec<Reached> {
        let physics = self.world.physics();
        let finer = (self.scene.physics.dt / physics.dt).round() as usize;
        let steps = physics.steps / finer;
        let observed = match self.loss.is_far() {
            true => vec![steps],
            false => self.loss.observed(steps),
        };
        let observed = observed.iter().map(|step| step * finer).collect();
        let seen = self.watched(robots, controller, observed, precision);
        let pairs = robots.iter().zip(seen);
        let reached = pairs.map(|((_, variation), seen)| {
            let seen = seen.map(|seen| seen.in_longer_steps(finer));
            self.reached_in(&variation.start, seen.as_ref())
        });
        reached.collect()
    }

    /// The result of a rollout. If the rollout diverged (`seen` is `None`), all its numbers are NaN.
    fn reached_in(&self, start: &State<f64>, seen: Option<&Trajectory<f64>>) -> Reached {
        let moved = seen.map_or(Vector::NAN, |seen| self.between(start, seen));
        let merit = match seen {
            Some(seen) if !self.loss.is_far() => -LossOf::<f64>::loss_of(&*self.loss, seen),
            _ => moved.forward(),
        };
        Reached { moved, merit }
    }

    /// Displacement of the payload, or of the body that the scene names, from `start` to the end of a trajectory in
    /// metres: along the ground, across (0 for a planar robot), and normal to the ground. All are NaN if the last state is
    /// [absurd](State::is_absurd).
    pub(crate) fn between<R: Real>(&self, start: &State<f64>, seen: &Trajectory<R>) -> Vector<f64> {
        let last = seen.last_step();
        if seen.at(last).map(R::primal).is_absurd() {
            return Vector::NAN;
        }
        let ground = self.world.ground();
        let [from, to] = [
            start.x[seen.marker.payload],
            seen.position(last).map(R::primal),
        ];
        ground.vector_to_ground(to) - ground.vector_to_ground(from)
    }

    /// Simulates robots in `precision`, and returns the states of each robot after the numbers of steps in `observed`; `None`
    /// for a robot that diverges.
    pub(crate) fn watched(
        &self,
        robots: &[Entry],
        controller: &Controller<f64>,
        observed: Vec<usize>,
        precision: GradientPrecision,
    ) -> Vec<Option<Trajectory<f64>>> {
        let span = Span {
            metered: self.loss.reads_efforts(),
            ..self.rollouts.observing(observed)
        };
        let world = &self.world;
        let all = match precision {
            GradientPrecision::F64 => {
                walk::watched(world, &world.robots::<f64>(robots, controller), &span)
            }
            GradientPrecision::F32 => {
                let all = walk::watched(world, &world.robots::<f32>(robots, controller), &span);
                let in_f64 = |seen: Option<Trajectory<f32>>| seen.map(|seen| seen.map(f64::from));
                all.into_iter().map(in_f64).collect()
            }
        };
        // The cheap check is stricter than the exact one, which decides if the cheap one fails.
        let exact = |robot: &Entry| {
            let robot = world.robots(&[*robot], controller).remove(0);
            let diverges = walk::divergence(world, &robot, &span).is_some();
            (!diverges).then(|| world.run_one(&robot, &span))
        };
        let pairs = all.into_iter().zip(robots);
        pairs
            .map(|(seen, robot)| seen.or_else(|| exact(robot)))
            .collect()
    }
}

/// The design of a robot, and how the robot differs from it.
pub(crate) type Entry<'a> = (&'a Design<Mixture<f64>>, &'a Variation);

/// Robots of one design.
pub(crate) fn robots_of<'a>(
    design: &'a Design<Mixture<f64>>,
    variations: &'a [Variation],
) -> Vec<Entry<'a>> {
    variations
        .iter()
        .map(|variation| (design, variation))
        .collect()
}

/// The index of the largest merit; of equally large merits, the index of the first. A merit has `N` numbers, which are
/// compared from the first to the last: a later number only decides between merits with equal earlier numbers. NaN, the
/// merit of a diverged rollout, is below any number.
pub fn first_best<const N: usize>(merits: impl IntoIterator<Item = [f64; N]>) -> usize {
    let better = |best: (usize, [f64; N]), (k, merit)| {
        if merit > best.1 { (k, merit) } else { best }
    };
    let merits = merits.into_iter().enumerate();
    merits.fold((0, [f64::NEG_INFINITY; N]), better).0
}
