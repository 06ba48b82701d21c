//! Learning in windows: gradients over about a second of a walk, from states in which the robot really is.
//!
//! A gradient over a whole walk says little. Gaits are chaotic, so that what its last steps say has to be
//! [bounded](crate::scene::GradientSettings::cotangent_bound), and the controller is updated once in a walk. Here several robots
//! walk side by side, and the controller is updated after each window. The next window begins where this one ends. After
//! a whole walk the robots begin again at rest, each with a new random variation.

use std::sync::Arc;

use autodiff::{Parameters, Real, Var};
use serde::{Deserialize, Serialize};

use super::slope::Slope;
use super::slopes::Variables;
use crate::inputs::Inputs;
use crate::judge::Evaluator;
use crate::lattice::State;
use crate::objective::{AnyLoss, LossOf, of_window};
use crate::optimiser::AdamState;
use crate::policy::Controller;
use crate::scene::GradientPrecision;
use crate::world::{Span, Trajectory, Variation};

/// The robots that walk while a controller learns. What varies from robot to robot depends only on the seed and on the number
/// of the walk.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Walkers {
    /// The number of walks that have begun.
    pub walks: u64,
    /// The number of steps since the last walk began.
    pub steps: usize,
    /// The states of the robots. Empty before the first window.
    pub states: Vec<State<f64>>,
}

/// A controller that learns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Learner {
    /// The controller.
    pub controller: Controller<f64>,
    /// The state of Adam, which updates it.
    pub adam: AdamState,
    /// The robots with which it learns.
    pub walkers: Walkers,
}

/// A window of a walk.
pub struct Window {
    /// The loss over a window.
    pub loss: Arc<dyn AnyLoss>,
    /// The steps of the window, the states that the loss reads, and the bound on cotangents.
    pub span: Span,
}

impl Window {
    /// The window of a scene; `None` if its controllers learn over the horizon. That is also so for given goals, whose loss is a
    /// share of the way to a goal.
    pub fn of_scene(evaluator: &Evaluator) -> Option<Self> {
        let scene = &evaluator.scene;
        let window = scene.schedule.window?;
        if !scene.learns_in_windows() {
            return None;
        }
        let steps = (window / scene.physics.dt).round().max(1.0) as usize;
        let steps = steps.min(scene.physics.steps);
        let loss = of_window(scene, steps);
        let span = Span {
            cotangent_bound: evaluator.cotangent_bound(),
            metered: loss.reads_efforts(),
            ..evaluator.rollouts.observing(loss.observed(steps))
        };
        Some(Self { loss, span })
    }

    /// The gradient of the loss over the window with respect to the variables, a mean over robots that vary, in the precision
    /// of the scene; and the states of the robots at its end. `first` is the number of steps on the clock at its start.
    pub fn slope(
        &self,
        evaluator: &Evaluator,
        variables: Variables,
        inputs: &Inputs<f64>,
        variations: &[Variation],
        first: usize,
    ) -> (Slope, Vec<State<f64>>) {
        let span = Span {
            first,
            ..self.span.clone()
        };
        let of = (evaluator, variables, variations, &span);
        match evaluator.scene.gradient.precision {
            GradientPrecision::F64 => self.slope_in(&inputs.lift::<f64>(), of),
            GradientPrecision::F32 => self.slope_in(&inputs.lift::<f32>(), of),
        }
    }

    /// The gradient in the number type `R`.
    fn slope_in<R: Real + Into<f64>>(
        &self,
        inputs: &Inputs<R>,
        (evaluator, variables, variations, span): (&Evaluator, Variables, &[Variation], &Span),
    ) -> (Slope, Vec<State<f64>>)
    where
        dyn AnyLoss: LossOf<Var<R>>,
    {
        let (world, mut ends) = (&evaluator.world, Vec::new());
        let (value, gradient) = inputs.differentiate(variables.blocks(), |inputs| {
            let controller = Arc::new(inputs.controller.clone());
            let design = variables.design(world, &inputs.z);
            let vary = |variation| world.varied(&design, &controller, variation);
            let robots: Vec<_> = variations.iter().map(vary).collect();
            let seen = world.run(&robots, span);
            let end = |seen: &Trajectory<Var<R>>| {
                seen.at(seen.last_step()).map(|x: Var<R>| x.value().into())
            };
            ends = seen.iter().map(end).collect();
            // The cotangents of each robot are bounded alone, so the losses are added here, and their sum is divided below.
            let losses: Vec<_> = seen.iter().map(|seen| self.loss.loss_of(seen)).collect();
            Var::sum_of(&losses)
        });
        let (sum, robots): (f64, _) = (value.into(), variations.len() as f64);
        let slope = Slope::of(sum / robots, &gradient, robots * evaluator.unit());
        (slope, ends)
    }
}
