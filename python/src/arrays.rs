//! Converts arrays between Python and the library.

use crate::errors::refused;
use crate::memory::has_room;
use autodiff::Real;
use cosmic::geometry::{Vector, from_flat};
use cosmic::inputs::Inputs;
use cosmic::lattice::{Lattice, State};
use cosmic::policy::{Block, Controller, Goals, NETWORK, blocks_of};
use cosmic::scene::{ControllerSettings, GoalKind};
use cosmic::simulator::Trajectory;
use numpy::{
    Element, IntoPyArray, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods,
};
use pyo3::prelude::*;

/// A number type that arrays from Python may have.
pub(crate) trait Number: Real + Element + Into<f64> {}
impl Number for f32 {}
impl Number for f64 {}

/// The sizes of a robot, from which the shapes of its arrays follow.
#[derive(Clone)]
pub(crate) struct Sizes {
    pub(crate) nodes: usize,
    pub(crate) edges: usize,
    pub(crate) inputs: usize,
    /// The blocks of the controller's parameters. Here a controller is always a network.
    pub(crate) blocks: Vec<Block>,
    /// The numbers of steps at which goals change, ascending; `None` if goals are not inputs of a rollout.
    pub(crate) changes: Option<Vec<usize>>,
}

/// The number of arrays with the parameters of a controller.
const CONTROLLER: usize = NETWORK.len();

/// Two arrays: the observed positions and the observed velocities.
pub(crate) type Seen<'py> = [Bound<'py, PyAny>; 2];

/// The names of the arrays of [`Inputs`], in their order.
pub(crate) const NAMES: [&str; 3 + CONTROLLER] = {
    let [first, second, third, fourth] = NETWORK;
    ["z", first, second, third, fourth, "x0", "v0"]
};

impl Sizes {
    /// Returns the sizes of robots on a lattice.
    pub(crate) fn of(lattice: &Lattice, controller: &ControllerSettings) -> Self {
        Self {
            nodes: lattice.nodes(),
            edges: lattice.edges.len(),
            inputs: controller.observation_length(lattice.nodes()),
            blocks: blocks_of(controller, lattice),
            changes: (controller.goals == GoalKind::Given).then(Vec::new),
        }
    }

    /// Returns the goals with these components, which are two for each goal.
    pub(crate) fn goals<R: Number>(&self, numbers: &[R]) -> Goals<R> {
        let changes = self.changes.iter().flatten();
        let mut points = from_flat(numbers).into_iter();
        let first = points.next().unwrap_or_else(Vector::zero);
        changes
            .zip(points)
            .fold(Goals::at(first), |goals, (&steps, point)| {
                goals.then(steps, point)
            })
    }

    /// Lists the blocks of numbers of [`Inputs`] in the order of its flat list of numbers: the number of the array
    /// that contains the block, and the length of the block.
    fn pieces(&self) -> impl Iterator<Item = (usize, usize)> {
        let own = self.blocks.iter().filter_map(|block| {
            let array = array_of(block.name)?;
            Some((1 + array, block.shape.len()))
        });
        [(0, 3 * self.edges)]
            .into_iter()
            .chain(own)
            .chain([5, 6].map(|array| (array, 2 * self.nodes)))
    }

    /// Returns the controller whose numbers are in these arrays.
    fn controller<R: Number>(&self, mut arrays: Vec<&[R]>) -> Controller<R> {
        let own = self.pieces().filter(|(k, _)| (1..=CONTROLLER).contains(k));
        let numbers = own.flat_map(|(k, length)| {
            let (block, rest) = arrays[k - 1].split_at(length);
            arrays[k - 1] = rest;
            block
        });
        Controller::new(&self.blocks, numbers.copied().collect())
    }

    /// Splits the flat list of the numbers of [`Inputs`] into the numbers of the seven arrays.
    pub(crate) fn split<R: Number>(&self, numbers: &[R]) -> [Vec<R>; 7] {
        let mut arrays = [const { Vec::new() }; 7];
        let mut begin = 0;
        for (array, length) in self.pieces() {
            arrays[array].extend_from_slice(&numbers[begin..][..length]);
            begin += length;
        }
        arrays
    }

    /// Returns the total number of values in the arrays of [`Inputs`].
    pub(crate) fn numbers(&self) -> f64 {
        let counts = self.shapes();
        let counts = counts
            .iter()
            .map(|shape| shape.iter().map(|&n| n as f64).product::<f64>());
        counts.sum()
    }

    /// Returns the shapes of the arrays of [`Inputs`].
    pub(crate) fn shapes(&self) -> [Vec<usize>; 7] {
        let points = vec![self.nodes, 2];
        let of_array = |array: usize| {
            let own = self.blocks.iter();
            let own = own.filter(|block| array_of(block.name) == Some(array));
            joined(own.map(|block| block.shape.axes()))
        };
        let [w1, b1, w2, b2] = [0, 1, 2, 3].map(of_array);
        [vec![self.edges, 3], w1, b1, w2, b2, points.clone(), points]
    }
}

/// The number of the array in [`NETWORK`] that contains a block of the controller's parameters. The hidden layer of the
/// policy `gaits` has several blocks, such as `w1_ahead` and `w1_behind`: they are one array, one block below the
/// other. A learned tempo is not in these arrays.
pub(crate) fn array_of(block: &str) -> Option<usize> {
    let name = block.split('_').next();
    NETWORK.iter().position(|array| Some(*array) == name)
}

/// The lengths of the axes of an array whose blocks are one below the other.
pub(crate) fn joined(blocks: impl Iterator<Item = Vec<usize>>) -> Vec<usize> {
    let add = |mut whole: Vec<usize>, block: Vec<usize>| {
        whole[0] += block[0];
        whole
    };
    blocks.reduce(add).unwrap_or_default()
}

/// An array argument from Python, with its name for error messages.
pub(crate) struct Given<'py, R: Number> {
    array: PyReadonlyArrayDyn<'py, R>,
    name: String,
}

impl<'py, R: Number> Given<'py, R> {
    /// Reads an array argument. The messages of errors contain `name`.
    pub(crate) fn new(name: &str, object: &Bound<'py, PyAny>) -> PyResult<Self> {
        let array = object.cast::<PyArrayDyn<R>>().map_err(|_| {
            refused(format!(
                "{name}: expected an array of {}",
                numpy::dtype::<R>(object.py())
            ))
        })?;
        let array = array
            .try_readonly()
            .map_err(|_| refused(format!("{name}: the array is being written to elsewhere")))?;
        let name = name.to_owned();
        Ok(Self { array, name })
    }

    pub(crate) fn shape(&self) -> &[usize] {
        self.array.shape()
    }

    /// Returns the numbers in C order. Numbers that are not finite are an error.
    pub(crate) fn finite(&self) -> PyResult<&[R]> {
        let numbers = self.numbers()?;
        // A piece is searched without an early exit, so that the compiler can vectorise the loop.
        let is_finite = |piece: &[R]| {
            piece
                .iter()
                .fold(true, |all, &x| all & x.into().is_finite())
        };
        if numbers.chunks(256).all(is_finite) {
            return Ok(numbers);
        }
        let is_wrong = |&x: &R| !x.into().is_finite();
        let wrong = numbers.iter().position(is_wrong).unwrap_or_default();
        let place = index(wrong, self.shape());
        let value: f64 = numbers[wrong].into();
        Err(refused(format!(
            "{}{place:?} is {value}: expected finite numbers",
            self.name
        )))
    }

    /// Returns the numbers in C order.
    pub(crate) fn numbers(&self) -> PyResult<&[R]> {
        self.array.as_slice().map_err(|_| {
            refused(format!(
                "{}: expected an aligned array that is contiguous in C order",
                self.name
            ))
        })
    }

    /// Checks that the array has the shape `shape`, with or without an additional axis in front. Returns the length of
    /// that axis, if there is one.
    pub(crate) fn batch(&self, shape: &[usize]) -> PyResult<Option<usize>> {
        let found = self.shape();
        match found.strip_suffix(shape) {
            Some([]) => Ok(None),
            Some([0]) => Err(refused(format!(
                "{}: the batch has no robots; expected one or more",
                self.name
            ))),
            Some([count]) => Ok(Some(*count)),
            _ => {
                let batched: Vec<String> = shape.iter().map(usize::to_string).collect();
                Err(refused(format!(
                    "{}: expected the shape {shape:?}, or (batch, {}) for several robots, found {found:?}",
                    self.name,
                    batched.join(", ")
                )))
            }
        }
    }
}

/// Converts an element's position in C order to its index in an array of this shape.
fn index(mut position: usize, shape: &[usize]) -> Vec<usize> {
    let mut index: Vec<usize> = (shape.iter().rev())
        .map(|&length| {
            let at = position % length.max(1);
            position /= length.max(1);
            at
        })
        .collect();
    index.reverse();
    index
}

/// The inputs of one robot or of several. Inputs that all robots share are stored once.
pub(crate) struct Batch<R> {
    z: Vec<Vec<[R; 3]>>,
    controllers: Vec<Controller<R>>,
    starts: Vec<State<R>>,
    /// The goals of each robot; empty if the robots have the scene's goal.
    goals: Vec<Goals<R>>,
    /// The number of robots; `None` for a single robot, whose arrays have no axis for robots in front.
    pub(crate) size: Option<usize>,
}

impl<R: Number> Batch<R> {
    /// Reads the seven arrays of [`NAMES`], and the goals if there is an eighth array. Each has an axis for robots in
    /// front, or all robots share it.
    pub(crate) fn new(arrays: &[Given<R>], sizes: &Sizes) -> PyResult<Self> {
        let changes = sizes.changes.as_ref().map_or(0, Vec::len);
        let shapes = sizes.shapes().into_iter().chain([vec![1 + changes, 2]]);
        let shapes: Vec<Vec<usize>> = shapes.collect();
        let mut size: Option<(usize, &str)> = None;
        let mut counts = [1; 8];
        let mut data: [&[R]; 8] = [&[]; 8];
        for (k, array) in arrays.iter().enumerate() {
            let count = array.batch(&shapes[k])?;
            data[k] = array.finite()?;
            let Some(count) = count else {
                continue;
            };
            counts[k] = count;
            match size {
                Some((other, name)) if other != count => {
                    return Err(refused(format!(
                        "{}: {count} robots, but {name} has {other}",
                        array.name
                    )));
                }
                _ => size = Some((count, array.name.as_str())),
            }
        }
        if let Some((count, _)) = size {
            // Every robot gets a copy of all arrays, including the shared ones.
            let bytes = count as f64 * sizes.numbers() * size_of::<R>() as f64;
            let what = format!("a copy of the inputs of {count} robots");
            has_room(bytes, &what, "use fewer robots at once")?;
        }
        let part = |k: usize, robot: usize| {
            let length = data[k].len() / counts[k];
            &data[k][if counts[k] == 1 { 0 } else { robot * length }..][..length]
        };
        let many = |blocks: &[usize]| blocks.iter().map(|&k| counts[k]).max().unwrap_or(1);
        let pairs = |k: usize, robot: usize| from_flat(part(k, robot));
        let own: Vec<usize> = (1..=CONTROLLER).collect();
        let controller = |robot: usize| {
            let arrays = own.iter().map(|&k| part(k, robot));
            sizes.controller(arrays.collect())
        };
        let with_goals = arrays.len() > NAMES.len();
        let start = |robot: usize| State {
            x: pairs(5, robot),
            v: pairs(6, robot),
        };
        Ok(Self {
            z: (0..counts[0])
                .map(|robot| part(0, robot).as_chunks().0.to_vec())
                .collect(),
            controllers: (0..many(&own)).map(controller).collect(),
            starts: (0..many(&[5, 6])).map(start).collect(),
            goals: (0..if with_goals { counts[7] } else { 0 })
                .map(|robot| sizes.goals(part(7, robot)))
                .collect(),
            size: size.map(|(count, _)| count),
        })
    }

    /// Returns the number of robots.
    pub(crate) fn robots(&self) -> usize {
        self.size.unwrap_or(1)
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

    /// Returns the components of a robot's goals; empty if it has the scene's goal.
    pub(crate) fn components(&self, robot: usize) -> Vec<R> {
        let goals = self.goals(robot).into_iter().flat_map(Goals::iter);
        goals.flatten().collect()
    }

    /// Returns the goals of a robot; `None` if it has the scene's goal.
    pub(crate) fn goals(&self, robot: usize) -> Option<&Goals<R>> {
        self.goals.get(robot % self.goals.len().max(1))
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

/// Returns `shape` with the axis of a batch in front. Without a batch, returns `shape` itself.
pub(crate) fn behind(batch: Option<usize>, shape: &[usize]) -> Vec<usize> {
    batch.into_iter().chain(shape.iter().copied()).collect()
}

/// The positions of trajectories as one flat list, and their velocities as another.
pub(crate) struct Flat<R> {
    pub(crate) x: Vec<R>,
    pub(crate) v: Vec<R>,
}

/// Concatenates the states of trajectories, in the order of the trajectories.
pub(crate) fn flattened<R: Real>(trajectories: &[Trajectory<R>]) -> Flat<R> {
    let states = || trajectories.iter().flat_map(|seen| &seen.states);
    Flat {
        x: states()
            .flat_map(|state| &state.x)
            .flatten()
            .copied()
            .collect(),
        v: states()
            .flat_map(|state| &state.v)
            .flatten()
            .copied()
            .collect(),
    }
}
