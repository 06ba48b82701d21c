//! Where the numbers of the parameters of a step come from: the blocks of a controller.

use std::borrow::Cow;

use autodiff::Real;
use autodiff_programs::Graph;

use super::block::Controller;
use super::fold::Fold;
use super::image;
use crate::lattice::Mirror;

/// The slots in which a step stores its activations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outputs<'a> {
    pub(crate) graph: &'a Graph,
    /// The slots of the edges that have an actuator, ascending.
    pub(crate) actuated: &'a [usize],
    /// The mirror image of the robot, if the robot is its own image.
    pub(crate) mirror: Option<&'a Mirror>,
}

impl Outputs<'_> {
    /// The mirror image of the robot.
    ///
    /// # Panics
    /// If the robot is not its own image.
    fn image(&self) -> &Mirror {
        self.mirror.expect("the robot must be its own mirror image")
    }

    /// The edges with an actuator, in the order of their slots. With this order, whole SIMD lanes of results can be
    /// moved to slots.
    fn edges(&self) -> Vec<usize> {
        let edges = self.graph.edge_of_slot();
        let slots = self.actuated.iter();
        slots.filter_map(|&slot| edges[slot]).collect()
    }
}

/// A layer that reads the observation: the names of its blocks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ObservedLayer {
    pub(super) weights: &'static str,
    pub(super) biases: &'static str,
    /// True if the layer sees the mirror image of the robot and of its goal.
    pub(super) sees_image: bool,
}

impl ObservedLayer {
    /// The weights for an observation of the robot itself.
    fn weights<'c, R: Real>(
        &self,
        controller: &'c Controller<R>,
        fold: &Fold<R>,
        outputs: &Outputs,
    ) -> Cow<'c, [R]> {
        let weights = controller.block(self.weights);
        match self.sees_image {
            true => fold.image(weights, outputs.image()).into(),
            false => weights.into(),
        }
    }
}

/// The source of the numbers of one parameter of a step. The strings are names of blocks of the controller.
#[derive(Clone, Copy, Debug)]
pub(crate) enum BlockSource {
    /// The [folded](Fold) weights of a layer that reads the observation.
    Weights(ObservedLayer),
    /// The folded biases of a layer that reads the observation.
    Biases(ObservedLayer),
    /// A whole block.
    Whole(&'static str),
    /// A block with one number per edge. The parameter has each number in the slot of its edge.
    OfEdges(&'static str),
    /// Some rows of a block: the rows that belong to edges with an actuator. The block has one row, or one number, per
    /// edge.
    OfActuators(&'static str),
    /// Like `OfActuators`, for a robot that is its own mirror image: behind each part of a row, of this length, comes the
    /// same part of the row that belongs to the image of the edge.
    WithImages(&'static str, usize),
    /// Like `OfActuators`: for each edge the mean of its row and of the row that belongs to its image.
    MeanWithImages(&'static str),
}

impl BlockSource {
    /// Computes the numbers of this parameter, given a controller.
    pub(crate) fn numbers<R: Real>(
        self,
        controller: &Controller<R>,
        fold: &Fold<R>,
        outputs: &Outputs,
    ) -> Vec<R> {
        match self {
            Self::Weights(layer) => fold.weights(&layer.weights(controller, fold, outputs)),
            Self::Biases(layer) => {
                let weights = layer.weights(controller, fold, outputs);
                fold.biases(&weights, controller.block(layer.biases))
            }
            Self::Whole(name) => controller.block(name).to_vec(),
            Self::OfEdges(name) => outputs.graph.to_slots(controller.block(name)),
            Self::OfActuators(name) => {
                let block = controller.block(name);
                let length = block.len() / outputs.graph.slot_of_edge().len();
                let row = |&edge: &usize| &block[edge * length..][..length];
                let rows: Vec<&[R]> = outputs.edges().iter().map(row).collect();
                rows.concat()
            }
            Self::WithImages(name, part) => {
                let (weights, edges) = (controller.block(name), outputs.edges());
                image::moved(weights, &edges, part, outputs.image())
            }
            Self::MeanWithImages(name) => {
                image::biases(controller.block(name), &outputs.edges(), outputs.image())
            }
        }
    }
}
