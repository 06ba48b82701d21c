//! Folds the observation into the first layer of a policy: its weights are converted once, so that a rollout can apply
//! the layer directly to the state.

use autodiff::Real;

use super::image;
use super::sensing::{Parts, Sight, phases};
use crate::geometry::{Dimension, Ground, Vector};
use crate::lattice::Mirror;
use crate::scene::{ControllerSettings, GoalKind, Senses};

/// How a folded layer takes the mean position and the presence of the nodes into account.
#[derive(Clone, Copy, Debug)]
pub enum Mean<'a, R> {
    /// All nodes are present. The subtraction of the mean position is folded into the weights.
    OfAll,
    /// Each node is weighted by its presence (0 to 1) in this list. These weights are folded into the weights of the
    /// layer too.
    Folded(&'a [R]),
    /// The presences are an input of the step. The step weights the nodes and computes their mean, and the layer reads
    /// the weighted nodes.
    InStep,
}

/// Converts the weights of a layer that reads an [observation](super::observation()) to the weights of a folded layer.
/// The folded layer computes the same from the state in the ground's frame.
///
/// This is possible because an observation is a linear function of the state and of one sine and one cosine: the
/// scales, the goal and the rotation of an incline are constant, and all clocks have one frequency. The folded layer
/// has these columns:
///
/// - the positions: the first component of all nodes, then the second one, and in space the third one,
/// - the velocities in the same order,
/// - `sin(omega t)` and `cos(omega t)`,
/// - the mean position, one column for each component, if the goal is relative to it and the mean is [`Mean::InStep`],
/// - the observed goal, one column for each component, if it is given to the rollout.
///
/// The step could compute the observation instead. With the scales and the mean in the step, designing a robot of `earth` took
/// 0.3 % more instructions, and a rollout of the paper's lattice with its gradient 4.7 %; with the clocks and the goal too,
/// 6.5 %. The fold would stay even then, because controllers for MuJoCo read the state directly.
///
/// With [`Mean::InStep`] the columns for positions read the weighted offsets of the nodes from their weighted mean, and
/// the columns for velocities read the weighted velocities. The constant part of the goal is folded into the biases.
#[derive(Clone, Debug)]
pub struct Fold<'a, R> {
    settings: &'a ControllerSettings,
    ground: &'a Ground,
    dimension: Dimension,
    nodes: usize,
    sight: Sight,
    /// Says whether the folded layer has columns for positions, and whether it has columns for velocities.
    senses: Senses,
    mean: Mean<'a, R>,
    /// For each clock, the sine of its phase: the coefficient of `cos(omega t)` in `sin(omega t + phase)`.
    sines: Vec<R>,
    /// For each clock, the cosine of its phase: the coefficient of `sin(omega t)` in `sin(omega t + phase)`.
    cosines: Vec<R>,
}

impl<'a, R: Real> Fold<'a, R> {
    /// The weights of a folded layer that has a column for everything that `sight` observes. No column is left out or
    /// joined with another.
    ///
    /// # Panics
    /// If there is not one presence per node.
    pub fn new(
        settings: &'a ControllerSettings,
        ground: &'a Ground,
        (dimension, nodes): (Dimension, usize),
        sight: Sight,
        mean: Mean<'a, R>,
    ) -> Self {
        if let Mean::Folded(presence) = mean {
            assert_eq!(presence.len(), nodes, "expected one presence per node");
        }
        let (sines, cosines) = phases(settings)
            .map(f64::sin_cos)
            .map(|(sin, cos)| (R::lit(sin), R::lit(cos)))
            .unzip();
        Self {
            settings,
            ground,
            dimension,
            nodes,
            sight,
            senses: Senses {
                x: sight == Sight::Robot,
                v: sight == Sight::Robot,
            },
            mean,
            sines,
            cosines,
        }
    }

    /// This fold without the columns whose weights are always zero: those for positions or velocities that the policy
    /// does not observe.
    #[must_use]
    pub(crate) fn without_constants(self) -> Self {
        Self {
            senses: self.sight.senses(self.settings),
            ..self
        }
    }

    /// The weights of the folded layer, row by row. `weights` are the weights of the layer that reads an observation.
    ///
    /// # Panics
    /// If the length of `weights` is not a multiple of the length of the observation.
    pub fn weights(&self, weights: &[R]) -> Vec<R> {
        let inputs = self.inputs(weights);
        let mut folded = Vec::new();
        for row in weights.chunks_exact(inputs) {
            self.fold_row(row, &mut folded);
        }
        folded
    }

    /// The biases of the folded layer. `weights` and `biases` belong to the layer that reads an observation.
    ///
    /// # Panics
    /// The panics of [`weights`](Self::weights).
    pub fn biases(&self, weights: &[R], biases: &[R]) -> Vec<R> {
        let rows = weights.chunks_exact(self.inputs(weights)).zip(biases);
        let goal = R::lits(&self.dimension.list(self.constant_goal()));
        rows.map(|(row, &bias)| bias + R::dot(&self.on_goal(&self.parts(row)), &goal))
            .collect()
    }

    /// The weights of a layer that sees the [mirror image](Mirror) of the robot and of its goal, not folded.
    pub(super) fn image(&self, weights: &[R], mirror: &Mirror) -> Vec<R> {
        let sizes = (self.inputs(weights), self.settings.clocks);
        image::observed(weights, sizes, self.dimension, mirror)
    }

    /// The length of an observation. Checks that it divides the number of weights.
    fn inputs(&self, weights: &[R]) -> usize {
        let inputs = self.sight.length(self.settings, self.dimension, self.nodes);
        assert!(
            weights.len().is_multiple_of(inputs),
            "the rows of the weights must be as long as an observation"
        );
        inputs
    }

    fn parts<'w>(&self, row: &'w [R]) -> Parts<'w, R> {
        Parts::of(row, self.settings.clocks, self.dimension)
    }

    /// The weights that multiply the goal in an observation, multiplied by the scale of the goal: they multiply the goal in
    /// metres.
    fn on_goal(&self, row: &Parts<R>) -> Vec<R> {
        let scale = R::lit(self.settings.goal_scale);
        row.goal.iter().map(|&weight| weight * scale).collect()
    }

    /// Appends a folded row to `folded`: the columns in the order that [`Fold`] states.
    fn fold_row(&self, row: &[R], folded: &mut Vec<R>) {
        let row = self.parts(row);
        let on_goal = self.on_goal(&row);
        let follows_goal = self.sight.follows_goal(self.settings);
        if self.senses.x {
            let columns = self.by_component(row.offsets, self.settings.offset_scale);
            for (column, &on_goal) in columns.into_iter().zip(&on_goal) {
                folded.extend(self.centred(column, follows_goal.then_some(on_goal)));
            }
        }
        if self.senses.v {
            for column in self.by_component(row.velocities, self.settings.velocity_scale) {
                folded.extend(self.weighted(column));
            }
        }
        // sin(omega t + phase) = cos(phase) sin(omega t) + sin(phase) cos(omega t)
        folded.extend([&self.cosines, &self.sines].map(|shares| R::dot(row.clocks, shares)));
        if follows_goal && self.senses.x && matches!(self.mean, Mean::InStep) {
            folded.extend(on_goal.into_iter().map(|weight| -weight));
        }
        if self.sight.sees_given_goal(self.settings) {
            folded.extend_from_slice(row.goal);
        }
    }

    /// Sorts weights of vectors, node by node in the world's frame, to one column for each component in the ground's frame,
    /// with a weight for every node. They are multiplied by `scale`.
    fn by_component(&self, row: &[R], scale: f64) -> Vec<Vec<R>> {
        let count = self.dimension.count();
        let nodes = row.chunks_exact(count);
        if self.ground.is_flat() {
            let scale = R::lit(scale);
            let column = |k: usize| nodes.clone().map(|of_node| of_node[k] * scale).collect();
            return (0..count).map(column).collect();
        }
        let column = |axis: Vector<f64>| {
            let axis = self
                .dimension
                .list(self.ground.vector_to_world(axis) * scale);
            let axis = R::lits(&axis);
            nodes
                .clone()
                .map(|of_node| R::dot(of_node, &axis))
                .collect()
        };
        self.dimension
            .unit_vectors()
            .into_iter()
            .map(column)
            .collect()
    }

    /// Multiplies the weights of a column by the presences of the nodes, unless the step does that.
    fn weighted(&self, mut column: Vec<R>) -> Vec<R> {
        if let Mean::Folded(presence) = self.mean {
            for (weight, &presence) in column.iter_mut().zip(presence) {
                *weight *= presence;
            }
        }
        column
    }

    /// Converts weights of offsets from the mean position to weights of positions, unless the step subtracts the mean.
    /// `on_goal` is the weight of a goal that is relative to the mean position.
    fn centred(&self, column: Vec<R>, on_goal: Option<R>) -> Vec<R> {
        let mut column = self.weighted(column);
        let mut on_mean = R::sum_of(&column);
        if let Some(on_goal) = on_goal {
            on_mean += on_goal;
        }
        match self.mean {
            Mean::InStep => {}
            Mean::OfAll => {
                let shift = on_mean * R::lit(1.0 / self.nodes as f64);
                column.iter_mut().for_each(|weight| *weight -= shift);
            }
            Mean::Folded(presence) => {
                let shift = on_mean / R::sum_of(presence);
                for (weight, &presence) in column.iter_mut().zip(presence) {
                    *weight -= shift * presence;
                }
            }
        }
        column
    }

    /// The constant part of the goal, which does not move with the robot; zero if the goal is given to the rollout.
    fn constant_goal(&self) -> Vector<f64> {
        match self.settings.goals {
            GoalKind::Given => Vector::zero(),
            GoalKind::Fixed => self.settings.goal,
        }
    }
}
