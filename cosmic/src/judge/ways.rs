//! What a robot with given goals leaves of its way to a goal in each direction.

use std::f64::consts::TAU;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::evaluator::Evaluator;
use super::quantiles::Quantiles;
use crate::design::{Design, Mixture};
use crate::geometry::{Dimension, Vector};
use crate::numbers::finite;
use crate::policy::{Controller, Goals};
use crate::scene::GoalsSettings;
use crate::world::{Variation, from_payload};

crate::keys! {
    /// How near the robot gets to a goal in one direction, half as far away as the farthest goals of its scene, in the time
    /// of one goal.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    struct Way {
        /// The direction: 0 is ahead, 90 to the left.
        degrees: f64, "number", unit "degrees";
        /// The distance of the goal at the start.
        way: f64, "number", unit "m";
        /// The distance that is left, divided by `way`: the median over eight of the starts of `displacement_p50`; `null` if
        /// too many rollouts diverge.
        left: Option<f64>, "number or `null`";
    }
}

impl Way {
    /// The name of the direction.
    pub fn name(&self) -> &'static str {
        const NAMES: [&str; 8] = [
            "ahead",
            "ahead left",
            "left",
            "behind left",
            "behind",
            "behind right",
            "right",
            "ahead right",
        ];
        NAMES[(self.degrees / 45.0).round() as usize % NAMES.len()]
    }
}

impl Evaluator {
    /// What the robot leaves of its ways: in two directions in the plane, in eight in space.
    pub(super) fn ways(
        &self,
        design: &Design<Mixture<f64>>,
        controller: &Controller<f64>,
        variations: &[Variation],
    ) -> Vec<Way> {
        let (world, dimension) = (&self.world, self.world.lattice().dimension);
        let directions = match dimension {
            Dimension::Plane => 2,
            Dimension::Space => 8,
        };
        let steps = world.physics().steps;
        let span = GoalsSettings::changes(steps).next().unwrap_or(steps);
        let span = self.rollouts.observing(vec![span]);
        let [low, high] = self.scene.goals.along;
        let way = 0.5 * low.abs().max(high.abs());
        if way == 0.0 {
            return Vec::new();
        }
        let robot = world.robot(world.body(design), controller.clone(), &self.start);
        let left = |turn: f64| {
            let place = Vector::new([way * (TAU * turn).cos(), way * (TAU * turn).sin(), 0.0]);
            let robots = variations.iter().map(|Variation { start, .. }| {
                let goals = Goals::at(from_payload(world, start, place));
                robot.clone().with_goals(goals).from(start)
            });
            let robots: Vec<_> = robots.collect();
            let walks = world.run(&robots, &span).into_iter().zip(&robots);
            let covered = walks.map(|(walk, robot)| {
                let moved = self.between(&robot.start, &walk);
                1.0 - dimension.norm_along(moved - place) / way
            });
            // The quantiles count rollouts that diverged as the worst.
            let covered: Vec<f64> = covered.collect();
            finite(1.0 - Quantiles::of(&covered).p50)
        };
        let directions: Vec<usize> = (0..directions).collect();
        let ways = directions.par_iter().map(|k| {
            let turn = *k as f64 / directions.len() as f64;
            Way {
                degrees: 360.0 * turn,
                way,
                left: left(turn),
            }
        });
        ways.collect()
    }
}
