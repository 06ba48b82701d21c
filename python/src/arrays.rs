//! Arrays from Python and for Python, and their shapes.

use autodiff::Real;
use cosmic::geometry::{Dimension, Vector};
use cosmic::lattice::Lattice;
use cosmic::policy::{Block, Goals, blocks_of};
use cosmic::scene::{ControllerSettings, GoalKind};
use cosmic::world::Trajectory;
use numpy::{Element, IntoPyArray, PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;
use std::iter::once;
use std::ops::Range;

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

/// The arrays of a request behind those of [`Sizes::shapes`], in this order.
#[derive(Clone, Default)]
pub(crate) struct Others {
    /// The number of steps with given activations, one per edge, for robots without a controller.
    pub(crate) driven: Option<usize>,
    /// The number of numbers of the goals; 0 if robots have the scene's goal.
    pub(crate) goals: usize,
    /// The names and lengths of arrays that change the physics: numbers of the surroundings, or the factors
    /// [`SCALABLE`](cosmic::lattice::SCALABLE) of the body.
    pub(crate) physics: Vec<(String, usize)>,
}

/// The numbers of a robot, array by array.
pub(crate) struct Row<'a, R> {
    pub(crate) z: &'a [[R; 3]],
    /// The numbers of the controller.
    pub(crate) controller: &'a [R],
    /// The positions and the velocities at the start.
    pub(crate) start: [&'a [R]; 2],
    pub(crate) activations: &'a [R],
    pub(crate) goals: &'a [R],
    /// The arrays that change the physics, with their names.
    pub(crate) physics: Vec<(&'a str, &'a [R])>,
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
    pub(crate) fn goals<R: Real>(&self, numbers: &[R]) -> Goals<R> {
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

    /// Returns the name and the shape of every array that all requests have, in the order of a row.
    pub(crate) fn shapes(&self) -> Vec<(&'static str, Vec<usize>)> {
        let points = self.points().to_vec();
        let own = self.blocks.iter();
        let own = own.map(|block| (block.name, block.shape.axes()));
        once(("z", vec![self.edges, 3]))
            .chain(own)
            .chain([("x0", points.clone()), ("v0", points)])
            .collect()
    }

    /// Splits a row: the numbers of all arrays of a robot, one array after the other.
    pub(crate) fn split<'a, R>(&'a self, row: &'a [R]) -> Row<'a, R> {
        let mut rest = row;
        let mut next = |count: usize| {
            let (own, later) = rest.split_at(count);
            rest = later;
            own
        };
        let [z, controller, x0, v0, _] = self.lengths();
        let Others {
            driven,
            goals,
            physics,
        } = &self.others;
        Row {
            z: next(z).as_chunks().0,
            controller: next(controller),
            start: [x0, v0].map(&mut next),
            activations: next(self.edges * driven.unwrap_or(0)),
            goals: next(*goals),
            physics: (physics.iter())
                .map(|(name, count)| (&**name, next(*count)))
                .collect(),
        }
    }

    /// The places in a row of the arrays whose bits are set in `by`; see [`GRADIENTS`].
    pub(crate) fn places(&self, by: u32) -> Vec<usize> {
        let mut end = 0;
        let ranges = self.lengths().map(|count| {
            end += count;
            end - count..end
        });
        let chosen = ranges.into_iter().enumerate();
        let chosen = chosen.filter(|(k, _)| by >> k & 1 == 1);
        chosen.flat_map(|(_, range)| range).collect()
    }

    /// How many numbers of a row belong to each of [`GRADIENTS`].
    fn lengths(&self) -> [usize; GRADIENTS.len()] {
        let points = self.points().iter().product();
        let Others {
            driven,
            goals,
            physics,
        } = &self.others;
        [
            3 * self.edges,
            self.blocks.iter().map(|block| block.shape.len()).sum(),
            points,
            points,
            self.edges * driven.unwrap_or(0)
                + goals
                + physics.iter().map(|(_, count)| count).sum::<usize>(),
        ]
    }
}

/// The arrays of a robot in the order of the bits of `by`, which chooses the gradients that are computed. The last are all
/// [`Others`].
pub(crate) const GRADIENTS: [&str; 5] = ["z", "controller", "x0", "v0", "others"];

/// An array: the numbers of all robots, or those of one if all share them.
pub(crate) struct Array<R> {
    numbers: Vec<R>,
    robots: usize,
}

/// The arrays of a request: those of [`Sizes::shapes`], and then the [`Others`].
pub(crate) struct Arrays<R>(Vec<Array<R>>);

impl<R: Number> Arrays<R> {
    /// Copies arrays, which have an axis for robots in front, of length 1 if all robots share the array. Python has checked
    /// their shapes.
    pub(crate) fn read(arrays: &[Bound<PyAny>]) -> PyResult<Self> {
        let read = |array: &Bound<PyAny>| {
            let array = array.cast::<PyArrayDyn<R>>()?.try_readonly()?;
            let robots = array.shape()[0];
            Ok((array.as_slice()?.to_vec(), robots))
        };
        let arrays = arrays.iter().map(read).collect::<PyResult<Vec<_>>>()?;
        Ok(Self::new(arrays))
    }

    /// Takes the numbers of each array, and of how many robots they are.
    pub(crate) fn new(arrays: impl IntoIterator<Item = (Vec<R>, usize)>) -> Self {
        let arrays = arrays.into_iter();
        let array = |(numbers, robots)| Array { numbers, robots };
        Self(arrays.map(array).collect())
    }

    /// The number of robots; 1 if they share all arrays.
    pub(crate) fn robots(&self) -> usize {
        let counts = self.0.iter().map(|array| array.robots);
        counts.max().unwrap_or(0)
    }

    /// The rows of `z`, which is the first array.
    pub(crate) fn z(&self) -> &[[R; 3]] {
        self.0[0].numbers.as_chunks().0
    }

    /// True if all robots share each of these arrays.
    pub(crate) fn are_shared(&self, arrays: Range<usize>) -> bool {
        self.0[arrays].iter().all(|array| array.robots < 2)
    }

    /// The number of arrays.
    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    /// The numbers of a robot, one array after the other.
    pub(crate) fn row(&self, robot: usize) -> Vec<R> {
        let parts = self.0.iter().map(|array| {
            let length = array.numbers.len() / array.robots;
            &array.numbers[robot % array.robots * length..][..length]
        });
        parts.collect::<Vec<_>>().concat()
    }

    /// Replaces numbers that are not finite by 0, and such rows of `z` by void, because not every projection takes a row of
    /// zeros. Returns which robots had such numbers.
    pub(crate) fn clean(&mut self, robots: usize) -> Vec<bool> {
        let is_finite = |number: &R| Into::<f64>::into(*number).is_finite();
        let mut lost = vec![false; robots];
        for (k, Array { numbers, robots }) in self.0.iter_mut().enumerate() {
            if numbers.iter().all(is_finite) {
                continue;
            }
            let parts: Vec<_> = numbers.chunks(numbers.len() / *robots).collect();
            for (robot, lost) in lost.iter_mut().enumerate() {
                *lost |= !parts[robot % *robots].iter().all(is_finite);
            }
            if k == 0 {
                let rows = numbers.as_chunks_mut().0.iter_mut();
                rows.filter(|row: &&mut [R; 3]| !row.iter().all(is_finite))
                    .for_each(|row| *row = [R::one(), R::zero(), R::zero()]);
            }
            let rest = numbers.iter_mut().filter(|number| !is_finite(number));
            rest.for_each(|number| *number = R::zero());
        }
        lost
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
