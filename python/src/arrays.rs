//! Arrays from Python and for Python, and their shapes.

use autodiff::Real;
use cosmic::geometry::{Dimension, Vector};
use cosmic::lattice::Lattice;
use cosmic::policy::{Block, Goals, blocks_of};
use cosmic::scene::{ControllerSettings, GoalKind};
use cosmic::world::Trajectory;
use numpy::{Element, IntoPyArray, PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;
use std::iter::once;

/// A number type that arrays from Python may have.
pub(crate) trait Number: Real + Element + Into<f64> {}
impl Number for f32 {}
impl Number for f64 {}

/// The sizes of a robot, from which the shapes of its arrays follow.
#[derive(Clone)]
pub(crate) struct Sizes {
    /// Whether the nodes are in the plane or in space.
    pub(crate) dimension: Dimension,
    pub(crate) nodes: usize,
    pub(crate) edges: usize,
    /// The blocks of the controller's parameters; none for robots with given activations.
    pub(crate) blocks: Vec<Block>,
    /// The numbers of steps at which goals change, ascending; `None` if goals are not inputs of a rollout.
    pub(crate) changes: Option<Vec<usize>>,
    /// The further arrays of a request.
    pub(crate) others: Others,
}

/// The arrays of a request besides those of [`Inputs`](cosmic::inputs::Inputs), in the order of their flat list of numbers.
#[derive(Clone, Default)]
pub(crate) struct Others {
    /// The number of steps with given activations, one per edge, for robots without a controller.
    pub(crate) driven: Option<usize>,
    /// The number of numbers of the goals; 0 if robots have the scene's goal.
    pub(crate) goals: usize,
    /// The names and lengths of arrays that change the physics: numbers of the surroundings, or the factors
    /// [`FACTORS`](cosmic::lattice::FACTORS) of the body.
    pub(crate) physics: Vec<(String, usize)>,
}

impl Others {
    /// Splits a list of numbers: the activations, the components of the goals, and the arrays of the physics with their
    /// names.
    pub(crate) fn split<'a, R>(
        &'a self,
        edges: usize,
        numbers: &'a [R],
    ) -> (&'a [R], &'a [R], impl Iterator<Item = (&'a str, &'a [R])>) {
        let (activations, rest) = numbers.split_at(edges * self.driven.unwrap_or(0));
        let (goals, mut rest) = rest.split_at(self.goals);
        let physics = self.physics.iter().map(move |(name, len)| {
            let (own, later) = rest.split_at(*len);
            rest = later;
            (name.as_str(), own)
        });
        (activations, goals, physics)
    }
}

impl Sizes {
    /// Returns the sizes of robots on a lattice.
    pub(crate) fn of(lattice: &Lattice, controller: &ControllerSettings) -> Self {
        Self {
            dimension: lattice.dimension,
            nodes: lattice.nodes(),
            edges: lattice.edges.len(),
            blocks: blocks_of(controller, lattice),
            changes: (controller.goals == GoalKind::Given).then(Vec::new),
            others: Others::default(),
        }
    }

    /// Returns the goals with these components.
    pub(crate) fn goals<R: Number>(&self, numbers: &[R]) -> Goals<R> {
        let mut points = self.dimension.from_flat(numbers).into_iter();
        let first = points.next().unwrap_or_else(Vector::zero);
        let later = self.changes.iter().flatten().copied().zip(points);
        later.fold(Goals::at(first), |goals, (steps, point)| {
            goals.then(steps, point)
        })
    }

    /// Returns the shape of an array of positions or velocities: the nodes, and the components of a vector.
    pub(crate) fn points(&self) -> [usize; 2] {
        [self.nodes, self.dimension.count()]
    }

    /// Returns the name and the shape of every array of [`Inputs`], in the order of its flat list of numbers.
    pub(crate) fn shapes(&self) -> Vec<(&'static str, Vec<usize>)> {
        let points = self.points().to_vec();
        let own = self.blocks.iter();
        let own = own.map(|block| (block.name, block.shape.axes()));
        once(("z", vec![self.edges, 3]))
            .chain(own)
            .chain([("x0", points.clone()), ("v0", points)])
            .collect()
    }
}

/// Makes a NumPy array of this shape.
pub(crate) fn array<'py, T: Element>(
    py: Python<'py>,
    numbers: Vec<T>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    numbers.into_pyarray(py).reshape(shape.to_vec())
}

/// Returns the positions of all states of trajectories as one flat list, then their velocities as another.
pub(crate) fn flattened<R: Real>(trajectories: &[Trajectory<R>]) -> [Vec<R>; 2] {
    let states = trajectories.iter().flat_map(|seen| &seen.states);
    let mut all = [Vec::new(), Vec::new()];
    for state in states {
        let parts = state.to_flat();
        for (all, part) in all.iter_mut().zip(parts) {
            all.extend(part);
        }
    }
    all
}
