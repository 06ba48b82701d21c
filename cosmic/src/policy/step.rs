//! The trait that every policy implements, and the part of a step that a policy records.

use std::fmt::Debug;

use autodiff_programs::{Array, Program};

use super::block::{Block, Shape};
use super::goals::{Offset, Towards};
use super::sensing::Sight;
use super::source::{BlockSource, ObservedLayer, Outputs};
use super::weighted::weighted;
use crate::geometry::{Axes, Dimension};
use crate::in_dimension;
use crate::lattice::Sides;
use crate::laws::Motion;
use crate::scene::{ControllerSettings, Senses};

/// The properties of a robot that determine the parameters of its policy.
#[derive(Clone, Copy, Debug)]
pub struct Sizes<'a> {
    /// Whether the robot moves in the plane or in space.
    pub dimension: Dimension,
    /// The number of nodes.
    pub nodes: usize,
    /// The number of edges. A policy computes one activation per edge.
    pub edges: usize,
    /// The sides that are mirror images of each other, if the robot is its own image (`lattice.mirror`).
    pub mirrored: Option<Sides>,
    /// The section `controller` of the scene.
    pub settings: &'a ControllerSettings,
}

impl Sizes<'_> {
    /// The number of entries in an observation of this robot.
    pub fn observation(&self, sight: Sight) -> usize {
        sight.length(self.settings, self.dimension, self.nodes)
    }
}

/// A policy computes the activations of the edges from the state of a robot.
///
/// A policy declares its parameters and records one step. Nothing more is needed for rollouts, gradients, optimisation
/// and files. `cosmic/program/examples/rhythm.rs` is an example.
pub trait Policy: Debug + Send + Sync {
    /// The blocks of the parameters. The name of a block is its key in files. It consists of lower case letters, digits
    /// and underscores. [`TEMPO`](super::TEMPO) is the name of the block of a learned clock.
    fn parameters(&self, robot: &Sizes) -> Vec<Block>;

    /// What the policy observes: the input of [an observed layer](PolicyStep::observed_layer).
    fn observe(&self) -> Sight {
        Sight::Robot
    }

    /// Records how a step computes the activations. Returns an array with a number from -1 to 1 for each edge: the
    /// result of [`PolicyStep::output_layer`], or of a kernel mapped over arrays [per edge](PolicyStep::per_edge).
    fn record(&self, step: &mut PolicyStep) -> Array;
}

/// The arrays of a step that a policy can read. Vectors are in the ground's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    /// Positions and velocities of the nodes.
    pub(crate) nodes: Motion,
    /// The rest length of the edge in every slot, m.
    pub(crate) rest_length: Array,
    /// The two numbers `sin(omega t)` and `cos(omega t)`.
    pub(crate) clock: Array,
    /// The [presence](crate::lattice::Body::presence) of each node, from 0 to 1; `None` if all nodes are present.
    pub(crate) presence: Option<Array>,
    /// The components of the goal of the step; `None` if the goal is a number of the controller.
    pub(crate) goal: Option<Array>,
}

/// A step under construction, in which a policy records its part.
pub struct PolicyStep<'a> {
    program: &'a mut Program,
    blocks: &'a [Block],
    /// Whether the observation depends on positions, and whether it depends on velocities.
    senses: Senses,
    follows_goal: bool,
    /// The factor on the observed goal, 1/m.
    goal_scale: f64,
    seen: Seen,
    outputs: Outputs<'a>,
    /// The arrays of the observation, once they are recorded.
    observation: Option<Vec<Array>>,
    /// The sources of the parameters declared so far, in the order of their declaration.
    sources: Vec<BlockSource>,
}

impl<'a> PolicyStep<'a> {
    pub(crate) fn new(
        program: &'a mut Program,
        blocks: &'a [Block],
        (sight, settings): (Sight, &ControllerSettings),
        mut seen: Seen,
        outputs: Outputs<'a>,
    ) -> Self {
        seen.goal = seen.goal.filter(|_| sight.sees_given_goal(settings));
        Self {
            program,
            blocks,
            senses: sight.senses(settings),
            follows_goal: sight.follows_goal(settings),
            goal_scale: settings.goal_scale,
            seen,
            outputs,
            observation: None,
            sources: Vec::new(),
        }
    }

    /// The sources of the parameters, in the order of their declaration.
    pub(crate) fn into_sources(self) -> Vec<BlockSource> {
        self.sources
    }

    /// An array with two numbers: `sin(omega t)` and `cos(omega t)`.
    pub fn clock(&self) -> Array {
        self.seen.clock
    }

    /// Records a layer that reads the observation `o`: `tanh(W o + b)`. `weights` and `biases` are the names of the
    /// blocks `W` and `b`.
    ///
    /// # Panics
    /// If a block is unknown.
    pub fn observed_layer(&mut self, weights: &'static str, biases: &'static str) -> Array {
        self.layer_of_observation(weights, biases, false)
    }

    /// Like [`observed_layer`](Self::observed_layer), for the observation of the robot's mirror image: nodes change places
    /// with their images, and the components along the ground (in space: across), also of the goal, change their signs.
    ///
    /// # Panics
    /// If a block is unknown, or the robot is not its own mirror image (`lattice.mirror`).
    pub fn image_layer(&mut self, weights: &'static str, biases: &'static str) -> Array {
        self.layer_of_observation(weights, biases, true)
    }

    fn layer_of_observation(
        &mut self,
        weights: &'static str,
        biases: &'static str,
        sees_image: bool,
    ) -> Array {
        let observation = self.observation();
        let (rows, _) = self.matrix_of(weights);
        let columns = observation.iter().map(|array| array.len()).sum();
        let matrix = self.program.matrix(rows, columns);
        let bias = self.program.parameter(rows);
        let layer = ObservedLayer {
            weights,
            biases,
            sees_image,
        };
        let sources = [BlockSource::Weights(layer), BlockSource::Biases(layer)];
        self.sources.extend(sources);
        self.program.dense_tanh(matrix, &observation, bias)
    }

    /// The sides that are mirror images of each other, if the robot is its own image (`lattice.mirror`).
    pub fn mirrored(&self) -> Option<Sides> {
        self.outputs.mirror.map(|mirror| mirror.sides)
    }

    /// Records a layer that reads the array `x`: `tanh(W x + b)`. `weights` and `biases` are the names of the blocks
    /// `W` and `b`.
    ///
    /// # Panics
    /// If a block is unknown, or `x` has another length than a row of `W`.
    pub fn layer(&mut self, weights: &'static str, biases: &'static str, x: Array) -> Array {
        let (rows, columns) = self.matrix_of(weights);
        let matrix = self.program.matrix(rows, columns);
        self.sources.push(BlockSource::Whole(weights));
        let bias = self.block(biases);
        self.program.dense_tanh(matrix, &[x], bias)
    }

    /// Records the layer that computes the activations of the edges: `tanh(W x + b)`. `weights` and `biases` are the
    /// names of the blocks `W` and `b`. `W` has one row per edge, and `b` has one number per edge.
    ///
    /// # Panics
    /// The panics of [`layer`](Self::layer).
    pub fn output_layer(&mut self, weights: &'static str, biases: &'static str, x: Array) -> Array {
        self.output_layer_of(weights, biases, &[x])
    }

    /// Like [`output_layer`](Self::output_layer), for a layer that reads several arrays, one after the other.
    ///
    /// # Panics
    /// The panics of [`layer`](Self::layer).
    pub fn output_layer_of(
        &mut self,
        weights: &'static str,
        biases: &'static str,
        x: &[Array],
    ) -> Array {
        let (_, columns) = self.matrix_of(weights);
        let sources = [weights, biases].map(BlockSource::OfActuators);
        self.layer_of_actuators(columns, sources, x)
    }

    /// Like [`output_layer_of`](Self::output_layer_of), for pairs of arrays of equal length: the first array of a pair belongs
    /// to the robot, the second one to its mirror image. The second array is multiplied by the weights of the first one, but
    /// acts on the images of the edges. Each bias is the mean of the biases of an edge and of its image.
    ///
    /// # Panics
    /// The panics of [`layer`](Self::layer); if the robot is not its own mirror image (`lattice.mirror`).
    pub fn output_layer_with_images(
        &mut self,
        weights: &'static str,
        biases: &'static str,
        x: &[Array],
    ) -> Array {
        let (_, columns) = self.matrix_of(weights);
        let part = 2 * columns / x.len();
        let sources = [
            BlockSource::WithImages(weights, part),
            BlockSource::MeanWithImages(biases),
        ];
        self.layer_of_actuators(2 * columns, sources, x)
    }

    fn layer_of_actuators(
        &mut self,
        columns: usize,
        sources: [BlockSource; 2],
        x: &[Array],
    ) -> Array {
        let rows = self.outputs.actuated.len();
        let matrix = self.program.matrix(rows, columns);
        let bias = self.program.parameter(rows);
        self.sources.extend(sources);
        let mut row_of_slot = vec![None; self.outputs.graph.slots()];
        for (row, &slot) in self.outputs.actuated.iter().enumerate() {
            row_of_slot[slot] = Some(row);
        }
        let activations = self.program.dense_tanh(matrix, x, bias);
        self.program.gather(activations, &row_of_slot)
    }

    /// Declares a block of the controller as a parameter of the step and returns its array.
    ///
    /// # Panics
    /// If the block is unknown.
    pub fn block(&mut self, name: &'static str) -> Array {
        let len = self.shape_of(name).len();
        self.sources.push(BlockSource::Whole(name));
        self.program.parameter(len)
    }

    /// Declares a block with one number per edge as a parameter of the step. The array that it returns has the order of
    /// the activations.
    pub fn per_edge(&mut self, name: &'static str) -> Array {
        self.sources.push(BlockSource::OfEdges(name));
        self.program.parameter(self.outputs.graph.slots())
    }

    /// An array with one entry per activation. All entries are the number at `index` of `x`.
    pub fn for_every_edge(&mut self, x: Array, index: usize) -> Array {
        let slots = self.outputs.graph.slots();
        self.program().gather(x, &vec![Some(index); slots])
    }

    /// Gathers positions (m) and velocities (m/s) of the two ends of every edge, in the ground's frame. The arrays have the
    /// order of the activations. In entries that belong to no edge, these numbers and the rest length are 0.
    pub fn ends(&mut self) -> [Motion; 2] {
        let nodes = self.outputs.graph.nodes_of_slot();
        [0, 1].map(|end| {
            let indices: Vec<_> = nodes.iter().map(|of| of.map(|of| of[end])).collect();
            let mut gather =
                |axes: Axes<Array>| axes.map(|axis| self.program.gather(axis, &indices));
            let Motion { x, v } = self.seen.nodes;
            Motion {
                x: gather(x),
                v: gather(v),
            }
        })
    }

    /// The rest length of every edge, m, in the order of the activations.
    pub fn rest_lengths(&self) -> Array {
        self.seen.rest_length
    }

    /// Whether the robot moves in the plane or in space.
    pub fn dimension(&self) -> Dimension {
        self.seen.nodes.x.dimension()
    }

    /// The program that the step is recorded into. A policy can map [kernels](autodiff_programs::Kernel) over arrays with it.
    pub fn program(&mut self) -> &mut Program {
        self.program
    }

    /// Records the observed goal if it is not recorded yet: its components along the ground, in space across, and normal to
    /// it. `None` if the goal is a number of the controller or is not observed.
    pub fn observed_goal(&mut self) -> Option<Array> {
        let observation = self.observation();
        self.seen.goal.and(observation.last().copied())
    }

    /// The arrays that are the inputs of a layer folded by [`Fold`](super::Fold), recorded on the first call.
    fn observation(&mut self) -> Vec<Array> {
        if self.observation.is_none() {
            self.observation = Some(self.record_observation());
        }
        self.observation.clone().expect("it is recorded")
    }

    fn record_observation(&mut self) -> Vec<Array> {
        let (nodes, clock) = (self.seen.nodes, self.seen.clock);
        let [x, v] = [(self.senses.x, nodes.x), (self.senses.v, nodes.v)].map(|(is_seen, axes)| {
            let components = axes.as_slice().iter().copied();
            components.filter(|_| is_seen).collect::<Vec<Array>>()
        });
        // Without nodes there is nothing to weight.
        let presence = self.seen.presence.filter(|_| x.len() + v.len() > 0);
        let Some(presence) = presence else {
            return [x, v, vec![clock]].concat();
        };
        let [all, mean] = weighted(self.program, presence, [&x, &v, &[clock]]);
        match self.seen.goal {
            Some(goal) => vec![all, self.towards(goal, mean)],
            None if self.follows_goal && self.senses.x => vec![all, mean],
            None => vec![all],
        }
    }

    /// Records how the robot observes a goal, from its mean position.
    fn towards(&mut self, goal: Array, mean: Array) -> Array {
        let kernel = Towards {
            scale: self.goal_scale,
        };
        let dimension = self.dimension();
        let p = self.program();
        let [offset] = p.map(Offset, [goal, mean], &[]);
        in_dimension!(dimension, D => {
            let turned: [Array; D] = std::array::from_fn(|by| match by {
                0 => offset,
                _ => p.gather(offset, &std::array::from_fn::<_, D, _>(|k| Some((k + by) % D))),
            });
            let [seen] = p.map(kernel, turned, &[]);
            seen
        })
    }

    fn shape_of(&self, name: &str) -> Shape {
        let block = self.blocks.iter().find(|block| block.name == name);
        let block = block.unwrap_or_else(|| panic!("the policy declares no block {name:?}"));
        block.shape
    }

    fn matrix_of(&self, name: &str) -> (usize, usize) {
        match self.shape_of(name) {
            Shape::Matrix { rows, columns } => (rows, columns),
            Shape::Vector(_) => panic!("block {name:?} is not a matrix"),
        }
    }
}
