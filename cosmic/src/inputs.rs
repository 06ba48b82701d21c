//! The inputs of a rollout, and derivatives by them.
//!
//! [`Inputs`] is all that a rollout can be differentiated by. Losses of it are written once over
//! [`Real`]; [`Inputs::differentiate`] puts the blocks that are asked for on the reverse tape.

use autodiff::{Real, Tape, Var};

use crate::controller::Controller;
use crate::lattice::State;

/// All numbers that a rollout depends on and may be differentiated by.
#[derive(Clone, Debug, PartialEq)]
pub struct Inputs<R> {
    /// Design vectors, one per edge.
    pub z: Vec<[R; 3]>,
    /// The controller.
    pub controller: Controller<R>,
    /// Initial positions and velocities in the world's frame.
    pub start: State<R>,
}

/// A part of the numbers of [`Inputs`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Block {
    /// Design vectors.
    Z,
    /// First weights of the controller.
    W1,
    /// First biases.
    B1,
    /// Second weights.
    W2,
    /// Second biases.
    B2,
    /// Initial positions.
    X0,
    /// Initial velocities.
    V0,
}

/// The design vectors.
pub const DESIGN: &[Block] = &[Block::Z];
/// The blocks of the controller.
pub const CONTROLLER: &[Block] = &[Block::W1, Block::B1, Block::W2, Block::B2];
/// No block.
pub const NOTHING: &[Block] = &[];
/// Everything, in the order in which files and tables list it.
pub const ALL: &[Block] = &[
    Block::Z,
    Block::W1,
    Block::B1,
    Block::W2,
    Block::B2,
    Block::X0,
    Block::V0,
];

impl Block {
    /// Its key in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Z => "z",
            Self::W1 => "w1",
            Self::B1 => "b1",
            Self::W2 => "w2",
            Self::B2 => "b2",
            Self::X0 => "x0",
            Self::V0 => "v0",
        }
    }
}

impl<R: Real> Inputs<R> {
    /// The numbers of a block.
    pub fn block(&self, block: Block) -> &[R] {
        match block {
            Block::Z => self.z.as_flattened(),
            Block::W1 => &self.controller.w1,
            Block::B1 => &self.controller.b1,
            Block::W2 => &self.controller.w2,
            Block::B2 => &self.controller.b2,
            Block::X0 => self.start.x.as_flattened(),
            Block::V0 => self.start.v.as_flattened(),
        }
    }

    /// Replaces the numbers of some blocks by those of one slice.
    ///
    /// # Panics
    /// If the slice does not hold just so many numbers.
    pub fn set(&mut self, blocks: &[Block], mut numbers: &[R]) {
        for block in blocks {
            let block = match block {
                Block::Z => self.z.as_flattened_mut(),
                Block::W1 => &mut self.controller.w1,
                Block::B1 => &mut self.controller.b1,
                Block::W2 => &mut self.controller.w2,
                Block::B2 => &mut self.controller.b2,
                Block::X0 => self.start.x.as_flattened_mut(),
                Block::V0 => self.start.v.as_flattened_mut(),
            };
            let (part, rest) = numbers.split_at(block.len());
            block.copy_from_slice(part);
            numbers = rest;
        }
        assert!(
            numbers.is_empty(),
            "{} numbers are left over",
            numbers.len()
        );
    }

    /// The numbers of some blocks in one vector.
    pub fn get(&self, blocks: &[Block]) -> Vec<R> {
        let numbers = blocks.iter().flat_map(|&block| self.block(block));
        numbers.copied().collect()
    }

    /// Every number replaced by a function of it.
    fn map<S>(&self, f: impl Fn(R) -> S) -> Inputs<S> {
        Inputs {
            z: self.z.iter().map(|z| z.map(&f)).collect(),
            controller: self.controller.map(&f),
            start: self.start.map(&f),
        }
    }

    /// The value of a function and its gradient by the chosen blocks, in one vector.
    pub fn differentiate(
        &self,
        blocks: &[Block],
        function: impl FnOnce(&Inputs<Var<R>>) -> Var<R>,
    ) -> (R, Vec<R>) {
        let [result] = self.differentiate_each(blocks, |inputs| [function(inputs)]);
        result
    }

    /// Values of functions of a copy each, and the gradient of each by the chosen blocks of its
    /// copy: one recording, swept once for all.
    pub fn differentiate_copies<const N: usize>(
        &self,
        blocks: &[Block],
        functions: impl FnOnce(&[Inputs<Var<R>>; N]) -> [Var<R>; N],
    ) -> [(R, Vec<R>); N] {
        let numbers = self.get(blocks);
        let mut tape = Tape::new();
        let values = tape.record(&numbers.repeat(N), |variables| {
            functions(&std::array::from_fn(|k| {
                let of_copy = &variables[k * numbers.len()..][..numbers.len()];
                self.with_variables(blocks, of_copy)
            }))
        });
        let gradients = tape.pullback(&values, &[R::one(); N]);
        std::array::from_fn(|k| {
            let of_copy = &gradients[k * numbers.len()..][..numbers.len()];
            (values[k].value(), of_copy.to_vec())
        })
    }

    /// The numbers as constants, those of some blocks as variables.
    fn with_variables(&self, blocks: &[Block], variables: &[Var<R>]) -> Inputs<Var<R>> {
        let mut inputs = self.map(Var::constant);
        inputs.set(blocks, variables);
        inputs
    }

    /// Values of functions and the gradient of each: one recording, swept once per function.
    pub fn differentiate_each<const N: usize>(
        &self,
        blocks: &[Block],
        functions: impl FnOnce(&Inputs<Var<R>>) -> [Var<R>; N],
    ) -> [(R, Vec<R>); N] {
        let numbers = self.get(blocks);
        let mut tape = Tape::new();
        let values = tape.record(&numbers, |variables| {
            functions(&self.with_variables(blocks, variables))
        });
        values.map(|value| {
            let gradient = tape.pullback(&[value], &[R::one()]).to_vec();
            (value.value(), gradient)
        })
    }
}

impl Inputs<f64> {
    /// The same numbers as constants of another type.
    pub fn lift<R: Real>(&self) -> Inputs<R> {
        self.map(R::lit)
    }
}
