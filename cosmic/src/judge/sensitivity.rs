//! The change of a robot's distance if a number of its physics is a tenth smaller or larger.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::evaluator::Evaluator;
use super::quantiles::Quantiles;
use crate::design::{Design, Mixture};
use crate::numbers::finite;
use crate::policy::Controller;
use crate::world::Variation;

crate::keys! {
    /// How much farther the robot walks if one number of its physics is a tenth smaller or larger: differences of median
    /// displacements over eight of the starts of `displacement_p50`. A gradient would not tell: a gait is often best at the
    /// physics that it was optimised for, so that it gets worse on both sides.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    struct Sensitivity {
        /// The key of the number in the scene, or `bars.stiffness` for the stiffness of all bars, `bars.strain` for the
        /// strain of all actuators, or `nodes.mass` for the mass of all nodes.
        name: String, "text";
        /// The difference for nine tenths of the number; `null` if too many rollouts diverge.
        smaller: Option<f64>, "number or `null`", unit "m";
        /// The difference for eleven tenths of the number; `null` if too many rollouts diverge.
        larger: Option<f64>, "number or `null`", unit "m";
        /// The larger standard error of the two differences. A difference may be chance if it is less than twice this number;
        /// `null` if a rollout diverges.
        error: Option<f64>, "number or `null`", unit "m";
    }
}

/// The factors of the numbers.
const FACTORS: [f64; 2] = [0.9, 1.1];
/// The numbers of a body that are varied.
const OF_BODY: [&str; 3] = ["bars.stiffness", "bars.strain", "nodes.mass"];

/// A median displacement with its standard error, m.
#[derive(Clone, Copy)]
struct Median {
    value: f64,
    error: f64,
}

impl Evaluator {
    /// The sensitivities of a robot to the numbers of its surroundings that are not 0, and to those of its body.
    pub(super) fn sensitivities(
        &self,
        design: &Design<Mixture<f64>>,
        controller: &Controller<f64>,
        variations: &[Variation],
    ) -> Vec<Sensitivity> {
        let surroundings = self.world.surroundings::<f64>();
        let numbers = surroundings.iter().filter(|(_, value)| *value != 0.0);
        let names = numbers.map(|(name, _)| name).chain(OF_BODY);
        let varied = names.flat_map(|name| FACTORS.map(|factor| (name, factor)));
        let varied: Vec<(&str, f64)> = std::iter::once(("", 1.0)).chain(varied).collect();
        let medians: Vec<Median> = (varied.par_iter())
            .map(|&(name, factor)| self.median_with(design, controller, variations, name, factor))
            .collect();
        let (own, medians) = (medians[0], &medians[1..]);
        let names = varied[1..].chunks_exact(FACTORS.len());
        let pairs = names.zip(medians.as_chunks().0);
        let sensitivity = |(names, pair): (&[(&str, f64)], &[Median; 2])| {
            let [smaller, larger] = pair.map(|median| finite(median.value - own.value));
            let errors = pair.map(|median| finite(median.error.hypot(own.error)));
            Sensitivity {
                name: names[0].0.to_owned(),
                smaller,
                larger,
                error: errors[0].zip(errors[1]).map(|(a, b)| a.max(b)),
            }
        };
        pairs.map(sensitivity).collect()
    }

    /// The median displacement of a robot if the number `name` of its physics is multiplied by `factor`.
    fn median_with(
        &self,
        design: &Design<Mixture<f64>>,
        controller: &Controller<f64>,
        variations: &[Variation],
        name: &str,
        factor: f64,
    ) -> Median {
        let world = &self.world;
        let (mut surroundings, mut body) = (world.surroundings(), world.body(design));
        if !body.scale(name, &[factor], &world.lattice().rest_length) {
            surroundings = surroundings.scaled(name, factor);
        }
        let robot = world.robot(body, controller.clone(), &self.start);
        let robot = robot.in_surroundings(surroundings);
        let starts = variations.iter().map(|variation| &variation.start);
        let robots: Vec<_> = starts.map(|start| robot.from(start)).collect();
        let span = (self.rollouts).observing(vec![self.scene.physics.steps]);
        let walks = world.run(&robots, &span).into_iter().zip(&robots);
        let moved: Vec<f64> = walks
            .map(|(walk, robot)| self.between(&robot.start, &walk).forward())
            .collect();
        Median {
            value: Quantiles::of(&moved).p50,
            error: Quantiles::median_error(&moved),
        }
    }
}
