//! The parameters of a policy: named blocks of one flat vector.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use autodiff::Parameters;

/// The names of the blocks of a network in order: weights and biases of the hidden layer, weights and biases of the output
/// layer.
pub const NETWORK: [&str; 4] = [W1, B1, W2, B2];
pub(super) const W1: &str = "w1";
pub(super) const B1: &str = "b1";
pub(super) const W2: &str = "w2";
pub(super) const B2: &str = "b2";

/// The shape of a block: a vector or a matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// A vector with this number of entries.
    Vector(usize),
    /// A matrix whose rows are stored one after the other.
    Matrix {
        /// The number of rows.
        rows: usize,
        /// The length of a row.
        columns: usize,
    },
}

impl Shape {
    /// The number of entries in a block of this shape. A file may state absurd sizes: if their product exceeds the
    /// largest `usize`, the result is the largest `usize`.
    pub fn len(self) -> usize {
        match self {
            Self::Vector(len) => len,
            Self::Matrix { rows, columns } => rows.saturating_mul(columns),
        }
    }

    /// True if a block of this shape has no numbers.
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }

    /// The lengths of the axes, like the `shape` of an array in NumPy.
    pub fn axes(self) -> Vec<usize> {
        match self {
            Self::Vector(len) => vec![len],
            Self::Matrix { rows, columns } => vec![rows, columns],
        }
    }
}

/// The role of a block. It decides how the initial numbers of the block are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Role {
    /// Weights. They start with random numbers between plus and minus `gain sqrt(6 / (rows + columns))`. The weights of
    /// a layer have one row per unit.
    Weights {
        /// The factor by which the range of the random numbers is multiplied.
        gain: f64,
    },
    /// Biases, or other numbers that start at zero.
    Biases,
}

/// Describes a block: a part of a policy's parameters that has a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// The key of the block in files.
    pub name: &'static str,
    /// The shape of the block.
    pub shape: Shape,
    /// The role of the block.
    pub role: Role,
}

impl Block {
    /// A block with the weights of a layer: one row of `columns` numbers for each unit.
    pub fn weights(name: &'static str, rows: usize, columns: usize, gain: f64) -> Self {
        Self {
            name,
            shape: Shape::Matrix { rows, columns },
            role: Role::Weights { gain },
        }
    }

    /// A block with one vector, which starts with random numbers between plus and minus `gain sqrt(6 / len)`.
    pub fn drawn(name: &'static str, len: usize, gain: f64) -> Self {
        Self {
            name,
            shape: Shape::Vector(len),
            role: Role::Weights { gain },
        }
    }

    /// A block with one vector, which starts at zero.
    pub fn biases(name: &'static str, len: usize) -> Self {
        Self {
            name,
            shape: Shape::Vector(len),
            role: Role::Biases,
        }
    }
}

/// A part of the flat vector of parameters: the name and the shape of a block.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Part {
    pub(super) name: Cow<'static, str>,
    pub(super) shape: Shape,
}

/// The name of the block of given activations. The blocks of policies are identifiers, so none has this name.
const GIVEN: &str = "given activations";

/// The parameters of a robot's policy: named blocks of one flat vector.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Controller<R> {
    layout: Arc<[Part]>,
    numbers: Vec<R>,
}

impl<R> Controller<R> {
    /// Makes a controller with these blocks. `numbers` holds the entries of all blocks, one block after the other.
    ///
    /// # Panics
    /// If the number of entries of all blocks is not the length of `numbers`.
    pub fn new(blocks: &[Block], numbers: Vec<R>) -> Self {
        let part = |block: &Block| Part {
            name: Cow::Borrowed(block.name),
            shape: block.shape,
        };
        Self::of_parts(blocks.iter().map(part).collect(), numbers)
    }

    pub(super) fn of_parts(layout: Arc<[Part]>, numbers: Vec<R>) -> Self {
        let len: usize = layout.iter().map(|part| part.shape.len()).sum();
        assert_eq!(
            numbers.len(),
            len,
            "there must be one number for each entry of the blocks"
        );
        Self { layout, numbers }
    }

    /// Activations that are given in place of a policy, as in trajectory optimisation and reinforcement learning: a number from
    /// -1 to 1 for each step of a walk and each edge, step by step, or one for each edge if the activations stay constant.
    pub fn given(activations: Vec<R>) -> Self {
        let part = Part {
            name: Cow::Borrowed(GIVEN),
            shape: Shape::Vector(activations.len()),
        };
        Self::of_parts(Arc::new([part]), activations)
    }

    /// The [given](Self::given) activations; `None` if a policy computes them.
    pub fn activations(&self) -> Option<&[R]> {
        let is_given = self.layout.iter().any(|part| part.name == GIVEN);
        is_given.then_some(&self.numbers)
    }

    /// The number of parameters in all blocks.
    pub fn weights(&self) -> usize {
        self.numbers.len()
    }

    /// All parameters as one list, one block after the other.
    pub fn numbers(&self) -> &[R] {
        &self.numbers
    }

    /// Like [`numbers`](Self::numbers), but mutable.
    pub fn numbers_mut(&mut self) -> &mut [R] {
        &mut self.numbers
    }

    /// The name and the shape of every block, and its range within the flat vector.
    pub fn blocks(&self) -> impl Iterator<Item = (&str, Shape, Range<usize>)> {
        let mut end = 0;
        self.layout.iter().map(move |part| {
            end += part.shape.len();
            (&*part.name, part.shape, end - part.shape.len()..end)
        })
    }

    fn range(&self, name: &str) -> Range<usize> {
        let found = self.blocks().find(|(other, ..)| *other == name);
        let (.., range) = found.unwrap_or_else(|| panic!("the controller has no block {name:?}"));
        range
    }

    /// The numbers of the block with this name.
    ///
    /// # Panics
    /// If there is no block of this name.
    pub fn block(&self, name: &str) -> &[R] {
        &self.numbers[self.range(name)]
    }

    /// Like [`block`](Self::block), but mutable.
    pub fn block_mut(&mut self, name: &str) -> &mut [R] {
        let range = self.range(name);
        &mut self.numbers[range]
    }
}
