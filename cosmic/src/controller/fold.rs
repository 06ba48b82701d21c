//! The controller as the rollout runs it: on the raw state, everything linear folded in.

use autodiff::Real;

use super::Controller;
use super::sensing::{observation_length, phases};
use crate::geometry::{Ground, Vector};
use crate::scene::ControllerSettings;

impl<R: Real> Controller<R> {
    /// This controller with a first layer that takes the raw state in the ground's frame.
    ///
    /// An observation is a fixed linear function of the state: mean, scales, the goal, the rotation
    /// of an incline; and clocks of one frequency are mixtures of one sine and one cosine. Folding
    /// all of it into the first layer, once per rollout, leaves `h = tanh(W1 s + b1)`,
    /// `u = tanh(W2 h + b2)` with the sensed values `s` in this order: x of all nodes, y of all
    /// nodes, x velocity of all, y velocity of all, `sin(omega t)`, `cos(omega t)`. A goal that does
    /// not move is in the biases. `presence` is that of [`observation`](super::observation()).
    ///
    /// # Panics
    /// If the controller was not made for observations by these settings, or not for so many nodes.
    pub fn folded(&self, settings: &ControllerSettings, presence: &[R], ground: &Ground) -> Self {
        let nodes = self.inputs.saturating_sub(settings.clocks + 2) / 4;
        assert_eq!(
            self.inputs,
            observation_length(settings, nodes),
            "the controller takes another number of inputs than the settings give"
        );
        let (sines, cosines) = phases(settings)
            .map(f64::sin_cos)
            .map(|(sin, cos)| (R::lit(sin), R::lit(cos)))
            .unzip();
        let fold = Fold {
            settings,
            ground,
            nodes,
            presence,
            total: R::sum_of(presence),
            sines,
            cosines,
        };
        assert!(
            presence.is_empty() || presence.len() == nodes,
            "the presence of {} nodes, and the controller observes {nodes}",
            presence.len()
        );
        let mut w1 = Vec::with_capacity(self.hidden * (4 * nodes + 2));
        let mut b1 = Vec::with_capacity(self.hidden);
        let rows = self.w1.chunks_exact(self.inputs);
        for (row, &bias) in rows.zip(&self.b1) {
            b1.push(fold.unit(row, bias, &mut w1));
        }
        Self {
            hidden: self.hidden,
            inputs: 4 * nodes + 2,
            w1,
            b1,
            w2: self.w2.clone(),
            b2: self.b2.clone(),
        }
    }
}

/// The settings with which a first layer is folded.
struct Fold<'a, R> {
    settings: &'a ControllerSettings,
    ground: &'a Ground,
    nodes: usize,
    presence: &'a [R],
    /// The sum of the presence.
    total: R,
    /// Every clock's share of `cos(omega t)`.
    sines: Vec<R>,
    /// Every clock's share of `sin(omega t)`.
    cosines: Vec<R>,
}

impl<R: Real> Fold<'_, R> {
    /// Folds one hidden unit: appends its weights on the raw state, returns its bias.
    fn unit(&self, row: &[R], bias: R, weights: &mut Vec<R>) -> R {
        let (clocks, row) = row.split_at(self.settings.clocks);
        let (goal, row) = row.split_at(2);
        let (offsets, velocities) = row.split_at(2 * self.nodes);
        let goal_scale = R::lit(self.settings.goal_scale);
        let goal = Vector::new([goal[0], goal[1]]) * goal_scale;

        let columns = self.turned(offsets, self.settings.offset_scale);
        for (column, goal) in columns.into_iter().zip(goal) {
            weights.extend(self.centred(self.present(column), goal));
        }
        for column in self.turned(velocities, self.settings.velocity_scale) {
            weights.extend(self.present(column));
        }
        weights.extend([&self.cosines, &self.sines].map(|shares| R::dot(clocks, shares)));
        bias + R::dot(goal.as_slice(), self.constant_goal().map(R::lit).as_slice())
    }

    /// Weights on world vectors `x0, y0, x1, ...` as weights on their components along the ground
    /// and across it: the transposed rotation, times a scale.
    fn turned(&self, row: &[R], scale: f64) -> Vector<Vec<R>> {
        let weights = row.as_chunks::<2>().0.iter().copied().map(Vector::new);
        if self.ground.is_flat() {
            let scale = R::lit(scale);
            let column = |k: usize| weights.clone().map(|weight| weight[k] * scale).collect();
            return Vector::from_fn(column);
        }
        Vector::new([self.ground.tangent(), self.ground.normal()]).map(|axis| {
            let axis: Vector<R> = Vector::lit(axis * scale);
            let weights = weights.clone();
            weights
                .map(|weight| R::dot(weight.as_slice(), axis.as_slice()))
                .collect()
        })
    }

    /// Weights on the nodes, each by how much it is observed.
    fn present(&self, mut column: Vec<R>) -> Vec<R> {
        for (weight, &presence) in column.iter_mut().zip(self.presence) {
            *weight *= presence;
        }
        column
    }

    /// Weights on offsets from the mean (and on the mean, for a goal relative to it) as weights on
    /// the positions themselves.
    fn centred(&self, mut column: Vec<R>, goal: R) -> Vec<R> {
        let mut on_mean = R::sum_of(&column);
        if self.settings.goal_relative {
            on_mean += goal;
        }
        if self.presence.is_empty() {
            let shift = on_mean * R::lit(1.0 / self.nodes as f64);
            column.iter_mut().for_each(|weight| *weight -= shift);
        } else {
            let shift = on_mean / self.total;
            for (weight, &presence) in column.iter_mut().zip(self.presence) {
                *weight -= shift * presence;
            }
        }
        column
    }

    /// The part of the goal that does not move with the robot. The state is measured from a point
    /// of the ground and the goal from the world's origin, which is what the shift is for.
    fn constant_goal(&self) -> Vector<f64> {
        let goal = Vector::new(self.settings.goal);
        if !self.settings.goal_relative {
            return goal;
        }
        goal - self.ground.vertical() * self.ground.height
    }
}

#[cfg(test)]
mod tests {
    use crate::controller::{Controller, clock, observation};
    use crate::geometry::{Ground, Vector};
    use crate::lattice::{Lattice, State};
    use crate::random::{Purpose, stream, symmetric};
    use crate::scene::ControllerSettings;

    /// The inputs of a folded controller for a state in the ground's frame.
    fn sensed(state: &State<f64>, clock: &[f64]) -> Vec<f64> {
        [state.to_columns(), clock.to_vec()].concat()
    }

    fn random_state(nodes: usize) -> State<f64> {
        let mut stream = stream(1, Purpose::Judgement);
        let mut point = |_| Vector::from_fn(|_| symmetric(&mut stream, 1.0));
        State {
            x: (0..nodes).map(&mut point).collect(),
            v: (0..nodes).map(&mut point).collect(),
        }
    }

    /// Compares the folded controller with the observation and the network as they are defined.
    fn check(settings: &ControllerSettings, presence: &[f64], ground: &Ground) {
        let lattice = Lattice::sample(3, 2, 0.0);
        let state = random_state(lattice.nodes());
        let mut controller = Controller::xavier(settings, &lattice, 0);
        controller.b1.fill(0.2);
        controller.b2.fill(-0.1);
        let time = 4096.0 * 0.002;
        let plain = controller.activation(&observation(settings, time, &state, presence, ground));
        let sensed = sensed(&state.to_ground(ground), &clock(settings, time));
        let got = controller
            .folded(settings, presence, ground)
            .activation(&sensed);
        assert_eq!(got.len(), plain.len());
        for (a, b) in got.iter().zip(&plain) {
            // Some thirty terms of order one in each sum, rounded at 1e-16; the phase of a clock,
            // near 82 rad, is itself rounded at 1e-14.
            assert!((a - b).abs() < 1e-13);
        }
    }

    #[test]
    fn folding_changes_nothing_but_the_rounding() {
        for incline_deg in [0.0, 15.0, -40.0] {
            for (goal_relative, clocks) in [(false, 10), (true, 10), (true, 3), (false, 0)] {
                let settings = ControllerSettings {
                    hidden: 7,
                    clocks,
                    goal_scale: 0.7,
                    goal_relative,
                    offset_scale: 1.3,
                    velocity_scale: 0.4,
                    ..ControllerSettings::default()
                };
                let ground = Ground {
                    height: 0.3,
                    incline_deg,
                };
                check(&settings, &[], &ground);
                check(&settings, &[1.0, 0.3, 0.0, 0.9, 1e-3, 1.0], &ground);
            }
        }
    }
}
