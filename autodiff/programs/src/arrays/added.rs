//! Operations on arrays that other crates add.

use autodiff::Real;
use autodiff::simd::Lane;

use super::array::Array;
use super::operation::LaneOperation;
use super::row::{Bars, StepValues};

/// An operation on whole arrays that your crate adds to steps, with its forward and its reverse sweep.
///
/// Most steps need none: a function of the numbers at one place of the arrays is a [`Kernel`](crate::Kernel). An operation
/// may connect all places, such as a sum along an array or the solution of equations.
/// [`Program::operation`](crate::Program::operation) records it.
///
/// For floats both sweeps are compiled in registers `L`, whose methods load and store several numbers at once. All other
/// number types run the compiled code one number at a time, several times slower than floats. The attribute
/// [`kernel`](macro@crate::kernel) on the `impl` makes the methods part of the code that is compiled for an instruction set.
/// Put it also on the functions of yours that they call.
///
/// A batch runs several starts (initial states) at once, and their numbers are interleaved: number `k` of start `s` is at
/// `k * starts + s`. A start gives the same bits in every batch if its numbers are computed by the same operations in the
/// same order for any number of starts and lanes.
///
/// ```
/// use autodiff::simd::Lane;
/// use autodiff::{Real, gradient};
/// use autodiff_programs::operations::{ArrayOperation, Forward, Reverse};
/// use autodiff_programs::{Model, Program, Rollout, kernel};
///
/// /// Running sums: `y[k] = x[0] + ... + x[k]`.
/// #[derive(Clone)]
/// struct RunningSums;
///
/// #[kernel]
/// impl ArrayOperation for RunningSums {
///     fn forward<R: Real, L: Lane<R>>(&self, Forward { x, y, .. }: Forward<R>) {
///         y.copy_from_slice(x.get(0));
///         for at in x.starts()..y.len() {
///             let before = y[at - x.starts()];
///             y[at] += before;
///         }
///     }
///
///     fn reverse<R: Real, L: Lane<R>>(&self, step: Reverse<R>) {
///         let Reverse { x, y_bar, mut x_bar, .. } = step;
///         let Some(x_bar) = x_bar.get_mut(0) else { return };
///         // The cotangent of `x[k]` is the sum of those of `y[k]`, `y[k + 1]`, ...
///         for start in 0..x.starts() {
///             let mut sum = R::zero();
///             for at in (start..y_bar.len()).step_by(x.starts()).rev() {
///                 sum += y_bar[at];
///                 x_bar[at] += sum;
///             }
///         }
///     }
/// }
///
/// impl Model for RunningSums {
///     fn record(&self, program: &mut Program) {
///         let x = program.state(3);
///         let sums = program.operation(RunningSums, &[x], &[3]);
///         program.advance(x, sums[0]);
///     }
/// }
///
/// let twice = Rollout::new(RunningSums, 2);
/// assert_eq!(twice.run(&[1.0, 10.0, 100.0], &[]), [1.0, 12.0, 123.0]);
/// assert_eq!(gradient(|x| twice.run(x, &[])[2], &[1.0, 10.0, 100.0]), [3.0, 2.0, 1.0]);
/// ```
pub trait ArrayOperation: Send + 'static {
    #[doc(hidden)]
    const USE_THE_ATTRIBUTE_KERNEL: ();

    /// Computes the outputs.
    fn forward<R: Real, L: Lane<R>>(&self, step: Forward<R>);

    /// Adds to the cotangents of the inputs those that follow from the cotangents of the outputs. Products of a partial and
    /// a cotangent go through [`Real::chain_add`] if the partial may be infinite.
    fn reverse<R: Real, L: Lane<R>>(&self, step: Reverse<R>);
}

/// What the forward sweep of an [`ArrayOperation`] reads and writes.
pub struct Forward<'a, R> {
    /// The inputs.
    pub x: InputValues<'a, R>,
    /// The numbers of all outputs, one output after the other. They must all be written.
    pub y: &'a mut [R],
    /// A buffer that the operation may resize. Its content is not defined at the beginning of a sweep.
    pub scratch: &'a mut Vec<R>,
}

/// What the reverse sweep of an [`ArrayOperation`] reads and writes.
pub struct Reverse<'a, R> {
    /// The inputs.
    pub x: InputValues<'a, R>,
    /// The numbers of all outputs, one output after the other.
    pub y: &'a [R],
    /// The cotangents of the outputs.
    pub y_bar: &'a [R],
    /// The cotangents of the inputs.
    pub x_bar: InputBars<'a, R>,
    /// A buffer that the operation may resize. Its content is not defined at the beginning of a sweep.
    pub scratch: &'a mut Vec<R>,
}

/// The inputs of an [`ArrayOperation`].
#[derive(Clone, Copy)]
pub struct InputValues<'a, R> {
    arrays: &'a [Array],
    values: StepValues<'a, R>,
    starts: usize,
}

impl<'a, R: Real> InputValues<'a, R> {
    /// The numbers of input `k`, in the order in which the operation was recorded.
    #[inline(always)]
    pub fn get(self, k: usize) -> &'a [R] {
        self.values.get(self.arrays[k])
    }

    /// The number of inputs.
    #[inline(always)]
    pub fn count(self) -> usize {
        self.arrays.len()
    }

    /// The number of starts, whose numbers are interleaved: at most the number of lanes of a register.
    #[inline(always)]
    pub fn starts(self) -> usize {
        self.starts
    }
}

/// The cotangents of the inputs of an [`ArrayOperation`].
pub struct InputBars<'a, R> {
    arrays: &'a [Array],
    active: &'a [bool],
    bars: Bars<'a, R>,
}

impl<R: Real> InputBars<'_, R> {
    /// The cotangents of input `k`, to which the reverse sweep adds; `None` if they are not needed.
    #[inline(always)]
    pub fn get_mut(&mut self, k: usize) -> Option<&mut [R]> {
        match self.active[k] {
            true => Some(self.bars.get_mut(self.arrays[k])),
            false => None,
        }
    }
}

/// The arrays of an [`ArrayOperation`].
#[derive(Clone, Debug)]
pub struct AddedArrays {
    pub inputs: Vec<Array>,
    /// The outputs, adjacent in the row. There is at least one.
    pub outputs: Vec<Array>,
}

/// An [`ArrayOperation`] that runs with numbers of type `R`.
pub(crate) struct Added<T, R> {
    operation: T,
    arrays: AddedArrays,
    /// For each input, whether it carries derivatives.
    active: Vec<bool>,
    scratch: Vec<R>,
}

impl<T, R> Added<T, R> {
    pub(crate) fn new(operation: T, arrays: AddedArrays) -> Self {
        Self {
            operation,
            active: vec![true; arrays.inputs.len()],
            arrays,
            scratch: Vec::new(),
        }
    }
}

impl<R: Real, T: ArrayOperation> LaneOperation<R> for Added<T, R> {
    fn outputs(&self) -> Vec<Array> {
        self.arrays.outputs.clone()
    }
    fn set_active(&mut self, arrays: &[bool]) -> bool {
        let inputs = self.arrays.inputs.iter();
        self.active = inputs.map(|input| arrays[input.id]).collect();
        self.active.contains(&true)
    }
    #[inline(always)]
    fn forward_in<L: Lane<R>>(&mut self, parameters: &[R], row: &mut [R]) {
        let AddedArrays { inputs, outputs } = &self.arrays;
        let (values, y) = StepValues::and_outputs(parameters, row, outputs);
        self.operation.forward::<R, L>(Forward {
            x: InputValues {
                arrays: inputs,
                values,
                starts: outputs[0].starts,
            },
            y,
            scratch: &mut self.scratch,
        });
    }
    #[inline(always)]
    fn reverse_in<L: Lane<R>>(&mut self, values: StepValues<R>, bars: &mut Bars<R>) {
        if !self.active.contains(&true) {
            return;
        }
        let AddedArrays { inputs, outputs } = &self.arrays;
        let (bars, y_bar) = bars.and_outputs(outputs);
        self.operation.reverse::<R, L>(Reverse {
            x: InputValues {
                arrays: inputs,
                values,
                starts: outputs[0].starts,
            },
            y: &values.row[outputs[0].start..][..y_bar.len()],
            y_bar,
            x_bar: InputBars {
                arrays: inputs,
                active: &self.active,
                bars,
            },
            scratch: &mut self.scratch,
        });
    }
}
