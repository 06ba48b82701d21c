//! The inputs of a rollout, and derivatives of functions with respect to these inputs.
//!
//! [`Inputs`] has all numbers with respect to which a rollout can be differentiated, in blocks. A loss is written once,
//! for any number type [`Real`]. [`Inputs::differentiate`] makes the numbers of the chosen blocks the variables of a
//! tape.

use crate::design::{Design, Mixture};
use crate::lattice::State;
use crate::policy::Controller;
use crate::world::{Robot, World};
use autodiff::{Dual, Parameters, Real, Tape, Var};
use std::borrow::Cow;
use std::ops::Range;

/// All numbers with respect to which a rollout can be differentiated.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Inputs<R> {
    /// Design vectors, one per edge.
    pub z: Vec<[R; 3]>,
    /// The controller.
    pub controller: Controller<R>,
    /// Initial positions and velocities in the world's frame.
    pub start: State<R>,
}

/// One of the groups (blocks) into which the numbers of [`Inputs`] are divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputBlock {
    /// Design vectors.
    Z,
    /// All numbers of the controller.
    Controller,
    /// Initial positions.
    X0,
    /// Initial velocities.
    V0,
}

/// A list of blocks that has only the design vectors.
pub const DESIGN: &[InputBlock] = &[InputBlock::Z];
/// A list of blocks that has only the numbers of the controller.
pub const CONTROLLER: &[InputBlock] = &[InputBlock::Controller];
/// The empty list of blocks, for functions that differentiate nothing.
pub const NOTHING: &[InputBlock] = &[];
/// All blocks, in the order in which files and tables list them.
pub const ALL: &[InputBlock] = &[
    InputBlock::Z,
    InputBlock::Controller,
    InputBlock::X0,
    InputBlock::V0,
];

/// The numbers that files store under one key. They are a whole [`InputBlock`], or one named block of the controller's
/// parameters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// The key under which files store the numbers.
    pub name: String,
    /// The block that contains the part.
    pub block: InputBlock,
    /// The range of the part within the block.
    pub range: Range<usize>,
}

impl<R: Real> Inputs<R> {
    /// The numbers of a block.
    pub fn block(&self, block: InputBlock) -> Cow<'_, [R]> {
        let dimension = self.start.dimension;
        Cow::Borrowed(match block {
            InputBlock::Z => self.z.as_flattened(),
            InputBlock::Controller => self.controller.numbers(),
            InputBlock::X0 => return Cow::Owned(dimension.flat(&self.start.x)),
            InputBlock::V0 => return Cow::Owned(dimension.flat(&self.start.v)),
        })
    }

    /// Replaces the numbers of `blocks` by `numbers`, which holds the numbers of each block, one block after the other.
    ///
    /// # Panics
    /// If `numbers` does not have exactly as many entries as the blocks.
    pub fn set(&mut self, blocks: &[InputBlock], mut numbers: &[R]) {
        let dimension = self.start.dimension;
        for &block in blocks {
            let (part, rest) = numbers.split_at(self.block(block).len());
            match block {
                InputBlock::Z => self.z.as_flattened_mut().copy_from_slice(part),
                InputBlock::Controller => self.controller.numbers_mut().copy_from_slice(part),
                InputBlock::X0 => dimension.fill(&mut self.start.x, part),
                InputBlock::V0 => dimension.fill(&mut self.start.v, part),
            }
            numbers = rest;
        }
        assert!(
            numbers.is_empty(),
            "`numbers` has {} entries more than the blocks need",
            numbers.len()
        );
    }

    /// Lists the parts of these inputs, in the order of [`ALL`]. Every number belongs to exactly one part.
    pub fn parts(&self) -> Vec<Part> {
        let part = |name: &str, block: InputBlock, range: Range<usize>| Part {
            name: name.to_owned(),
            block,
            range,
        };
        let whole = |name: &str, block: InputBlock| part(name, block, 0..self.block(block).len());
        let own = self.controller.blocks();
        [whole("z", InputBlock::Z)]
            .into_iter()
            .chain(own.map(|(name, _, range)| part(name, InputBlock::Controller, range)))
            .chain([whole("x0", InputBlock::X0), whole("v0", InputBlock::V0)])
            .collect()
    }

    /// The robot with this controller and this start, in the surroundings of the scene. `design` is what the caller makes of
    /// the design vectors.
    pub fn robot(&self, world: &World, design: &Design<Mixture<R>>) -> Robot<R> {
        world.robot(world.body(design), self.controller.clone(), &self.start)
    }

    /// The numbers of a part.
    pub fn part(&self, part: &Part) -> Vec<R> {
        self.block(part.block)[part.range.clone()].to_vec()
    }

    /// Replaces the numbers of a part.
    ///
    /// # Panics
    /// If `numbers` does not have exactly as many entries as the part.
    pub fn set_part(&mut self, part: &Part, numbers: &[R]) {
        let mut block = self.block(part.block).to_vec();
        block[part.range.clone()].copy_from_slice(numbers);
        self.set(&[part.block], &block);
    }

    /// The numbers of `blocks`, one block after the other.
    pub fn get(&self, blocks: &[InputBlock]) -> Vec<R> {
        let mut numbers = Vec::new();
        for &block in blocks {
            numbers.extend_from_slice(&self.block(block));
        }
        numbers
    }

    /// The value of `f` and its gradient with respect to the numbers of `blocks`. The gradient has the order of
    /// [`get`](Self::get).
    pub fn differentiate(
        &self,
        blocks: &[InputBlock],
        function: impl FnOnce(&Inputs<Var<R>>) -> Var<R>,
    ) -> (R, Vec<R>) {
        let [result] = self.differentiate_each(blocks, |inputs| [function(inputs)]);
        result
    }

    /// Evaluates `N` functions, each on its own copy of the inputs. Returns the value of each function, and its
    /// gradient with respect to the numbers of `blocks` in its copy. All functions share one recording and one reverse
    /// sweep.
    pub(crate) fn differentiate_copies<const N: usize>(
        &self,
        blocks: &[InputBlock],
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

    /// A copy of the inputs in which `variables` are the numbers of `blocks`. All other numbers are constants.
    fn with_variables(&self, blocks: &[InputBlock], variables: &[Var<R>]) -> Inputs<Var<R>> {
        let mut inputs = self.map(Var::constant);
        inputs.set(blocks, variables);
        inputs
    }

    /// The values of a function with several results, and its vector-Jacobian product: the gradient of `sum_k cotangent_k
    /// value_k` with respect to the numbers of `blocks`.
    ///
    /// # Panics
    /// If the number of cotangents is not the number of results.
    pub fn vjp(
        &self,
        blocks: &[InputBlock],
        function: impl FnOnce(&Inputs<Var<R>>) -> Vec<Var<R>>,
        cotangents: &[R],
    ) -> (Vec<R>, Vec<R>) {
        let on = |variables: &[Var<R>]| function(&self.with_variables(blocks, variables));
        autodiff::vjp(on, &self.get(blocks), cotangents)
    }

    /// The values of a function with several results, and its Jacobian-vector product: the derivatives of these values
    /// in the direction `tangents`.
    pub fn jvp(
        &self,
        tangents: &Self,
        function: impl FnOnce(&Inputs<Dual<R, 1>>) -> Vec<Dual<R, 1>>,
    ) -> (Vec<R>, Vec<R>) {
        let along = |numbers: &[Dual<R, 1>]| {
            let mut inputs = self.map(Dual::constant);
            inputs.set(ALL, numbers);
            function(&inputs)
        };
        autodiff::jvp(along, &self.get(ALL), &tangents.get(ALL))
    }

    /// For each of `N` functions, its value and its gradient with respect to the numbers of `blocks`. All functions
    /// share one recording. Each function has its own reverse sweep.
    pub(crate) fn differentiate_each<const N: usize>(
        &self,
        blocks: &[InputBlock],
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
    /// A copy of the inputs with every number converted to a constant of the number type `R`.
    pub fn lift<R: Real>(&self) -> Inputs<R> {
        self.map(R::lit)
    }
}
