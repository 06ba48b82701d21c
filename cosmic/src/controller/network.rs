//! The controller: a network of one hidden layer.

use autodiff::Real;
use autodiff::fused::dense;
use serde::{Deserialize, Serialize};

use super::sensing::{observation, observation_length};
use crate::geometry::Ground;
use crate::lattice::{Lattice, State};
use crate::random::{self, Purpose};
use crate::scene::ControllerSettings;

/// A network of one hidden layer: `tanh(W2 tanh(W1 I + b1) + b2)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Controller<R> {
    /// Hidden units.
    pub hidden: usize,
    /// Length of an observation.
    pub inputs: usize,
    /// Weights of the first layer, `hidden x inputs`, row by row.
    pub w1: Vec<R>,
    /// Biases of the first layer.
    pub b1: Vec<R>,
    /// Weights of the second layer, `edges x hidden`, row by row.
    pub w2: Vec<R>,
    /// Biases of the second layer, one per edge.
    pub b2: Vec<R>,
}

impl<R: Real> Controller<R> {
    /// How many weights and biases it has.
    pub fn weights(&self) -> usize {
        self.w1.len() + self.b1.len() + self.w2.len() + self.b2.len()
    }

    /// How many activations it gives.
    pub fn edges(&self) -> usize {
        self.b2.len()
    }

    /// The activation of every edge, in `[-1, 1]`, from an [observation](super::observation()).
    pub fn activation(&self, observation: &[R]) -> Vec<R> {
        let hidden = layer(&self.w1, &self.b1, observation);
        layer(&self.w2, &self.b2, &hidden)
    }
}

impl Controller<f64> {
    /// Uniform weights drawn from a seed, up to `gain sqrt(6 / (inputs + outputs))` of each layer
    /// in magnitude, biases zero: X. Glorot and Y. Bengio, "Understanding the difficulty of
    /// training deep feedforward neural networks", AISTATS 2010, equation 16, which has no gain.
    pub fn xavier(settings: &ControllerSettings, lattice: &Lattice, seed: u64) -> Self {
        let (hidden, edges) = (settings.hidden, lattice.edges.len());
        let inputs = observation_length(settings, lattice.nodes());
        let mut stream = random::stream(seed, Purpose::Weights);
        let mut weights = |outputs: usize, inputs: usize, gain: f64| -> Vec<f64> {
            let limit = gain * (6.0 / (inputs + outputs) as f64).sqrt();
            let draw = |_| random::symmetric(&mut stream, limit);
            (0..outputs * inputs).map(draw).collect()
        };
        Self {
            hidden,
            inputs,
            w1: weights(hidden, inputs, settings.gain[0]),
            b1: vec![0.0; hidden],
            w2: weights(edges, hidden, settings.gain[1]),
            b2: vec![0.0; edges],
        }
    }
}

impl Controller<f64> {
    /// This controller for settings [without feedback](ControllerSettings::without_feedback): what it
    /// observes of the robot stays as it is in this state.
    #[must_use]
    pub fn without_feedback(
        &self,
        settings: &ControllerSettings,
        state: &State<f64>,
        presence: &[f64],
        ground: &Ground,
    ) -> Self {
        let observed = |settings| observation(settings, 0.0, state, presence, ground);
        let [seen, unseen] = [observed(settings), observed(&settings.without_feedback())];
        let held: Vec<f64> = seen.iter().zip(unseen).map(|(a, b)| a - b).collect();
        let mut controller = self.clone();
        let rows = self.w1.chunks_exact(self.inputs);
        for (bias, row) in controller.b1.iter_mut().zip(rows) {
            *bias += f64::dot(row, &held);
        }
        controller
    }
}

impl<R: Copy> Controller<R> {
    /// Every weight replaced by a function of it.
    pub fn map<S>(&self, f: impl Fn(R) -> S) -> Controller<S> {
        let map = |weights: &[R]| weights.iter().map(|&w| f(w)).collect();
        Controller {
            hidden: self.hidden,
            inputs: self.inputs,
            w1: map(&self.w1),
            b1: map(&self.b1),
            w2: map(&self.w2),
            b2: map(&self.b2),
        }
    }
}

/// `tanh(W input + b)`, `W` row by row.
fn layer<R: Real>(weights: &[R], biases: &[R], input: &[R]) -> Vec<R> {
    let sums = dense(weights, input, biases).into_iter();
    sums.map(R::tanh).collect()
}

#[cfg(test)]
mod tests {
    use super::Controller;
    use crate::controller::observation;
    use crate::geometry::Ground;
    use crate::lattice::Lattice;
    use crate::scene::Scene;

    /// Wherever the robot is, it is driven as it would be at the start.
    #[test]
    fn without_feedback_only_the_clock_moves_on() {
        let mut scene = Scene::paper();
        (
            scene.controller.goal_relative,
            scene.controller.offset_scale,
        ) = (true, 3.0);
        let (settings, ground) = (&scene.controller, &Ground::from(&scene.physics));
        let lattice = Lattice::new(&scene.lattice, &scene.physics);
        let start = lattice.state_at_rest();
        let mut away = start.clone();
        away.x.iter_mut().for_each(|x| x[0] = 3.0 - 2.0 * x[0]);
        let controller = Controller::xavier(settings, &lattice, 0);
        let held = controller.without_feedback(settings, &start, &[], ground);
        let unseen = settings.without_feedback();
        let driven = |c: &Controller<f64>, settings, state| {
            c.activation(&observation(settings, 0.7, state, &[], ground))
        };
        let (there, at_start) = (
            driven(&held, &unseen, &away),
            driven(&controller, settings, &start),
        );
        for (a, b) in there.iter().zip(&at_start) {
            // Sums of 156 terms of order one, rounded at 1e-16.
            assert!((a - b).abs() < 1e-13, "{a} {b}");
        }
        let seeing = driven(&controller, settings, &away);
        assert!(
            seeing
                .iter()
                .zip(&at_start)
                .any(|(a, b)| (a - b).abs() > 0.1)
        );
    }

    #[test]
    fn the_paper_s_shapes_and_weights_that_fill_the_glorot_range() {
        let mut scene = Scene::paper();
        scene.controller.gain = [2.0, 1.0];
        let lattice = Lattice::new(&scene.lattice, &scene.physics);
        let c = Controller::xavier(&scene.controller, &lattice, 0);
        assert_eq!((c.inputs, c.hidden, c.edges()), (156, 32, 110));
        let lengths = [&c.w1, &c.b1, &c.w2, &c.b2].map(Vec::len);
        assert_eq!(lengths, [32 * 156, 32, 110 * 32, 110]);
        let largest = |w: &[f64]| w.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let (first, second) = (2.0 * (6.0f64 / 188.0).sqrt(), (6.0f64 / 142.0).sqrt());
        // The largest of thousands of draws is within a per cent of the limit.
        assert!(largest(&c.w1) <= first && largest(&c.w1) > 0.99 * first);
        assert!(largest(&c.w2) <= second && largest(&c.w2) > 0.99 * second);
        assert!(c.b1.iter().chain(&c.b2).all(|&b| b == 0.0));
    }
}
