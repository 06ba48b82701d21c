//! Robots that are driven from outside: activations are given in place of a controller.

use super::rollout::{Simulator, Span};
use super::trajectory::Trajectory;
use crate::controller::{Controller, observation_length};
use crate::lattice::{Body, Lattice, State};
use crate::scene::{ControllerSettings, PhysicsSettings};

/// A bias whose hyperbolic tangent is 1 in double precision.
const SATURATED: f64 = 40.0;

/// A lattice in its surroundings for robots whose activations the caller holds, as a policy that learns
/// does.
///
/// The controller within gives every actuator the activation 1, and the strain of each body is scaled by
/// the activation that is held: robots of different activations run side by side in SIMD lanes.
#[derive(Clone, Debug)]
pub struct Driven {
    simulator: Simulator,
    controller: Controller<f64>,
}

impl Driven {
    /// Plans rollouts that end `physics.steps` steps after the start at most.
    pub fn new(
        lattice: &Lattice,
        physics: &PhysicsSettings,
        controller: &ControllerSettings,
    ) -> Self {
        let settings = ControllerSettings {
            hidden: 1,
            ..controller.clone()
        };
        let (inputs, edges) = (
            observation_length(&settings, lattice.nodes()),
            lattice.edges.len(),
        );
        Self {
            simulator: Simulator::new(lattice, physics, &settings).without_feedback(),
            controller: Controller {
                hidden: 1,
                inputs,
                w1: vec![0.0; inputs],
                b1: vec![0.0],
                w2: vec![0.0; edges],
                b2: vec![SATURATED; edges],
            },
        }
    }

    /// Steps robots of one body from a start each, with an activation of every edge, from -1 to 1, that is
    /// held throughout.
    ///
    /// # Panics
    /// As [`Simulator::rollout_many`], and if a list of activations is shorter than the edges.
    pub fn held(
        &self,
        body: &Body<f64>,
        activations: &[&[f64]],
        starts: &[State<f64>],
        span: &Span,
    ) -> Vec<Trajectory<f64>> {
        let bodies = activations.iter().map(|held| {
            let edges = 0..body.strain.len();
            Body {
                strain: edges.map(|edge| body.strain[edge] * held[edge]).collect(),
                ..body.clone()
            }
        });
        let bodies: Vec<Body<f64>> = bodies.collect();
        (self.simulator).rollout_many(&bodies, &self.controller, starts, span)
    }
}

#[cfg(test)]
mod tests {
    use super::Driven;
    use crate::case::Case;
    use crate::scene::Scene;
    use crate::simulator::Span;

    /// A controller whose biases alone matter holds its activations too.
    #[test]
    fn held_activations_drive_as_a_controller_that_gives_them() {
        let scene = Scene::parse(
            "small",
            "base = \"stability\"\n[lattice]\ncolumns = 3\nrows = 2",
        )
        .unwrap();
        let mut case = Case::of_scene(&scene, 1).unwrap();
        case.controller.w2.fill(0.0);
        let bias = |edge: usize| (edge as f64).sin();
        case.controller.b2 = (0..case.lattice.edges.len()).map(bias).collect();
        let held: Vec<f64> = case.controller.b2.iter().map(|b| b.tanh()).collect();
        let span = Span::from_start(vec![1, 200]);
        let by_controller =
            case.task()
                .rollout(&case.own_mixture(), &case.controller, &case.start, &span);
        let driven = Driven::new(&case.lattice, &case.physics, &case.observation);
        let none = vec![0.0; held.len()];
        let starts = [case.start.clone(), case.start.clone()];
        let [seen, still] = driven
            .held(&case.body(), &[&held, &none], &starts, &span)
            .try_into()
            .unwrap();
        let far = |seen: &crate::simulator::Trajectory<f64>| {
            let pairs = (by_controller.states[1].x.as_flattened().iter())
                .zip(seen.states[1].x.as_flattened());
            pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        // Activations are rounded at 1e-16; 200 steps with contacts enlarge that to less than this.
        assert!(far(&seen) < 1e-10, "{}", far(&seen));
        assert!(far(&still) > 1e-3);
    }
}
