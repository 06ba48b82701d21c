//! Arrays from Python, and the robots whose numbers they contain. Python has checked their shapes and their numbers.

use autodiff::Real;
use cosmic::geometry::{Vector, flat, from_flat};
use cosmic::inputs::Inputs;
use cosmic::lattice::{Lattice, State};
use cosmic::policy::{Block, Controller, Goals, blocks_of};
use cosmic::scene::{ControllerSettings, GoalKind};
use cosmic::simulator::Trajectory;
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
    pub(crate) nodes: usize,
    pub(crate) edges: usize,
    /// The blocks of the controller's parameters.
    pub(crate) blocks: Vec<Block>,
    /// The numbers of steps at which goals change, ascending; `None` if goals are not inputs of a rollout.
    pub(crate) changes: Option<Vec<usize>>,
}

impl Sizes {
    /// Returns the sizes of robots on a lattice.
    pub(crate) fn of(lattice: &Lattice, controller: &ControllerSettings) -> Self {
        Self {
            nodes: lattice.nodes(),
            edges: lattice.edges.len(),
            blocks: blocks_of(controller, lattice),
            changes: (controller.goals == GoalKind::Given).then(Vec::new),
        }
    }

    /// Returns the goals with these components, which are two for each goal.
    pub(crate) fn goals<R: Number>(&self, numbers: &[R]) -> Goals<R> {
        let mut points = from_flat(numbers).into_iter();
        let first = points.next().unwrap_or_else(Vector::zero);
        let later = self.changes.iter().flatten().copied().zip(points);
        later.fold(Goals::at(first), |goals, (steps, point)| {
            goals.then(steps, point)
        })
    }

    /// Returns the name and the shape of every array of [`Inputs`], in the order of its flat list of numbers.
    pub(crate) fn shapes(&self) -> Vec<(&'static str, Vec<usize>)> {
        let points = vec![self.nodes, 2];
        let own = self.blocks.iter();
        let own = own.map(|block| (block.name, block.shape.axes()));
        once(("z", vec![self.edges, 3]))
            .chain(own)
            .chain([("x0", points.clone()), ("v0", points)])
            .collect()
    }
}

/// The inputs of several robots. Inputs that all robots share are stored once.
pub(crate) struct Batch<R> {
    z: Vec<Vec<[R; 3]>>,
    controllers: Vec<Controller<R>>,
    starts: Vec<State<R>>,
    /// The goals of each robot; empty if the robots have the scene's goal.
    goals: Vec<Goals<R>>,
    pub(crate) robots: usize,
}

impl<R: Number> Batch<R> {
    /// Reads the arrays of [`Sizes::shapes`], and the goals if there is one array more. Each has an axis for robots in
    /// front, of length 1 if all robots share the array.
    pub(crate) fn new(arrays: &[Bound<PyAny>], sizes: &Sizes) -> PyResult<Self> {
        let arrays = arrays.iter().map(|array| {
            let array = array.cast::<PyArrayDyn<R>>()?;
            Ok(array.try_readonly()?)
        });
        let arrays: Vec<_> = arrays.collect::<PyResult<_>>()?;
        let counts: Vec<usize> = arrays.iter().map(|array| array.shape()[0]).collect();
        let data = arrays.iter().map(|array| Ok(array.as_slice()?));
        let data: Vec<&[R]> = data.collect::<PyResult<_>>()?;
        let part = |array: usize, robot: usize| {
            let length = data[array].len() / counts[array];
            &data[array][robot % counts[array] * length..][..length]
        };
        // The numbers of the robots that differ in at least one of these arrays.
        let differ = |arrays: Range<usize>| 0..counts[arrays].iter().copied().max().unwrap_or(0);
        let x0 = 1 + sizes.blocks.len();
        let own = |robot: usize| (1..x0).flat_map(move |array| part(array, robot)).copied();
        let state = |robot: usize| State {
            x: from_flat(part(x0, robot)),
            v: from_flat(part(x0 + 1, robot)),
        };
        Ok(Self {
            z: (differ(0..1).map(|robot| part(0, robot).as_chunks().0.to_vec())).collect(),
            controllers: (differ(1..x0))
                .map(|robot| Controller::new(&sizes.blocks, own(robot).collect()))
                .collect(),
            starts: differ(x0..x0 + 2).map(state).collect(),
            goals: (differ(x0 + 2..counts.len()))
                .map(|robot| sizes.goals(part(x0 + 2, robot)))
                .collect(),
            robots: differ(0..counts.len()).end,
        })
    }

    /// Returns the controller of all robots, if they share one.
    pub(crate) fn shared_controller(&self) -> Option<&Controller<R>> {
        match &self.controllers[..] {
            [controller] => Some(controller),
            _ => None,
        }
    }

    pub(crate) fn z(&self, robot: usize) -> &[[R; 3]] {
        &self.z[robot % self.z.len()]
    }

    pub(crate) fn controller(&self, robot: usize) -> &Controller<R> {
        &self.controllers[robot % self.controllers.len()]
    }

    pub(crate) fn start(&self, robot: usize) -> &State<R> {
        &self.starts[robot % self.starts.len()]
    }

    /// Returns the goals of a robot; `None` if it has the scene's goal.
    pub(crate) fn goals(&self, robot: usize) -> Option<&Goals<R>> {
        self.goals.get(robot % self.goals.len().max(1))
    }

    /// Returns the components of a robot's goals; empty if it has the scene's goal.
    pub(crate) fn components(&self, robot: usize) -> Vec<R> {
        let goals = self.goals(robot).into_iter().flat_map(Goals::iter);
        goals.flatten().collect()
    }

    /// True if all robots have the same design vectors.
    #[cfg(feature = "gpu")]
    pub(crate) fn shares_design(&self) -> bool {
        self.z.len() < 2
    }

    /// True if all robots have the same goals.
    pub(crate) fn shares_goals(&self) -> bool {
        self.goals.len() < 2
    }

    pub(crate) fn inputs(&self, robot: usize) -> Inputs<R> {
        Inputs {
            z: self.z(robot).to_vec(),
            controller: self.controller(robot).clone(),
            start: self.start(robot).clone(),
        }
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
    let states = || trajectories.iter().flat_map(|seen| &seen.states);
    [
        states().flat_map(|state| flat(&state.x)).collect(),
        states().flat_map(|state| flat(&state.v)).collect(),
    ]
}
