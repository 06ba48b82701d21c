//! The recording of a step.

use super::operation::StepOperation;
use crate::arrays::{Array, Matrix, Parameter, RowLayout, TOO_LONG, checked_sum};
use crate::real::Real;
use crate::simd::lanes;

/// An array with different values in every step, and their cotangents.
pub(super) struct Control<R> {
    pub(super) array: Array,
    /// `array.len` numbers for each step, one step after the other.
    pub(super) values: Vec<R>,
    /// The cotangents in the same order; `None` if they are not needed.
    pub(super) bars: Option<Vec<R>>,
}

/// A recorded step. See the [module](super).
///
/// Parameters, states, inputs and controls are declared in any order, before the operations that read them. Arrays
/// may be empty.
pub struct Program<R: Real> {
    pub(super) arrays: Vec<Array>,
    pub(super) parameters: Vec<Parameter>,
    /// Whether every start has its own value, for each parameter; set by `load`.
    pub(super) own: Vec<bool>,
    pub(super) states: Vec<Array>,
    /// The new value of each part of the state.
    pub(super) next: Vec<Option<Array>>,
    pub(super) inputs: Vec<Array>,
    pub(super) controls: Vec<Control<R>>,
    /// The number of inputs of a step. All starts share them.
    pub(crate) inputs_len: usize,
    pub(super) operations: Vec<StepOperation<R>>,
    /// The number of starts that run at once, with interleaved numbers.
    pub(crate) starts: usize,
    /// The numbers in the parameters' arrays and in a row so far.
    pub(super) ends: [usize; 2],
    pub(super) layout: RowLayout,
    /// The numbers of a later row that each operation prefetches, in whole cache lines.
    pub(super) prefetch_len: usize,
    /// How far past the arrays lanes may reach, in addition to their own width.
    pub(super) margin: usize,
}

impl<R: Real> Default for Program<R> {
    fn default() -> Self {
        Self {
            arrays: Vec::new(),
            parameters: Vec::new(),
            own: Vec::new(),
            states: Vec::new(),
            next: Vec::new(),
            inputs: Vec::new(),
            controls: Vec::new(),
            inputs_len: 0,
            operations: Vec::new(),
            starts: 1,
            ends: [0; 2],
            layout: RowLayout::default(),
            prefetch_len: 0,
            margin: 0,
        }
    }
}

/// Declarations of parameters, states, inputs and controls.
impl<R: Real> Program<R> {
    /// A program for this many starts at once: one, two, or one for each lane.
    pub(crate) fn side_by_side(starts: usize) -> Self {
        let most = lanes::<R>();
        assert!(
            starts == 1 || starts == most || starts == 2 && most > 2,
            "a program cannot run {starts} starts at once; it runs one, two, or one for each lane"
        );
        Self {
            starts,
            ..Self::default()
        }
    }

    /// Declares a parameter: an array of `len` numbers that is the same for all steps.
    pub fn parameter(&mut self, len: usize) -> Array {
        self.align(true);
        let array = self.allocate(true, len);
        self.parameters.push(Parameter::Array(array));
        array
    }

    /// Declares a matrix parameter for [`dense`](Program::dense) layers. It is given row by row.
    pub fn matrix(&mut self, rows: usize, columns: usize) -> Matrix {
        let matrix = Matrix {
            parameter: self.parameters.len(),
            rows,
            columns,
        };
        self.parameters.push(Parameter::Matrix(matrix));
        matrix
    }

    /// Declares a part of the state: an array of `len` numbers that each step passes to the next, see
    /// [`advance`](Program::advance).
    pub fn state(&mut self, len: usize) -> Array {
        let array = self.allocate(false, len);
        self.states.push(array);
        self.next.push(None);
        array
    }

    /// Declares an input: `len` constants for every step, from [`Rollout::inputs`](crate::Rollout::inputs). Inputs
    /// carry no derivatives. If you need derivatives, declare a [control](Program::control).
    pub fn input(&mut self, len: usize) -> Array {
        let array = self.allocate(false, len);
        self.inputs.push(array);
        // This cannot overflow, because `allocate` has checked the row, which holds the inputs too.
        self.inputs_len += len;
        array
    }

    /// Declares a control: an array of `len` numbers with different values in every step, which carry derivatives. In
    /// a rollout it is one parameter of `steps * len` numbers, one step after the other.
    ///
    /// ```
    /// use autodiff::{Kernel, Model, Program, Real, Rollout, Var, gradient};
    ///
    /// /// A mass of 1 on a spring, pushed by a force, in steps of 0.1 s.
    /// #[derive(Clone, Copy)]
    /// struct Push;
    ///
    /// impl Kernel<3, 2> for Push {
    ///     #[inline(always)]
    ///     fn eval<R: Real>(&self, [x, v, force]: [R; 3]) -> [R; 2] {
    ///         let v = v + R::lit(0.1) * (force - x * v);
    ///         [x + R::lit(0.1) * v, v]
    ///     }
    /// }
    ///
    /// impl Model for Push {
    ///     fn record<R: Real>(&self, program: &mut Program<R>) {
    ///         let [x, v] = [(); 2].map(|()| program.state(1));
    ///         let force = program.control(1);
    ///         let [x_next, v_next] = program.map(Push, [x, v, force]);
    ///         program.advance(x, x_next);
    ///         program.advance(v, v_next);
    ///     }
    /// }
    ///
    /// let forces = [1.0, 2.0, 0.5, -1.0];
    /// let rollout = Rollout::new(Push, forces.len());
    /// let start = [0.0, 1.0].map(Var::constant);
    /// let by_rollout = gradient(|forces| rollout.run(&start, &[forces])[0], &forces);
    /// let step = |[x, v]: [_; 2], &force: &_| Push.eval([x, v, force]);
    /// let by_tape = gradient(|forces| forces.iter().fold(start, step)[0], &forces);
    /// for (a, b) in by_rollout.into_iter().zip(by_tape) {
    ///     assert!((a - b).abs() < 1e-15);
    /// }
    /// ```
    pub fn control(&mut self, len: usize) -> Array {
        let array = self.allocate(false, len);
        self.parameters
            .push(Parameter::Control(self.controls.len()));
        self.controls.push(Control {
            array,
            values: Vec::new(),
            bars: None,
        });
        array
    }

    /// Sets the array that a part of the state becomes at the end of the step: the output of an operation, a part of
    /// the state at the beginning of the step, a parameter, an input or a control.
    ///
    /// # Panics
    /// If `state` is not a part of the state or was advanced before, if the lengths differ, or if `next` belongs to
    /// another program.
    pub fn advance(&mut self, state: Array, next: Array) {
        let part = self.states.iter().position(|s| *s == state);
        let part = part.expect("advance: the first array must be a part of the state");
        self.assert_known(&[next]);
        assert_eq!(
            state.len, next.len,
            "advance: the arrays must have the same length"
        );
        let before = self.next[part].replace(next);
        assert!(
            before.is_none(),
            "advance: this part of the state was advanced before"
        );
    }

    /// # Panics
    /// If an array does not belong to this program. Steps read the inputs of operations without checks.
    pub(super) fn assert_known(&self, arrays: &[Array]) {
        let known = |array: &Array| self.arrays.get(array.id) == Some(array);
        assert!(
            arrays.iter().all(known),
            "an array belongs to another program"
        );
    }

    /// A new array behind all other parameters, or behind all other arrays of the row.
    fn allocate(&mut self, parameter: bool, len: usize) -> Array {
        let starts = self.starts;
        let len = len.checked_mul(starts).expect(TOO_LONG);
        let end = &mut self.ends[usize::from(!parameter)];
        let array = Array {
            id: self.arrays.len(),
            parameter,
            start: *end,
            len,
            starts,
        };
        *end = checked_sum(*end, len);
        self.arrays.push(array);
        array
    }

    /// Lets the next array begin at a multiple of the lanes.
    pub(super) fn align(&mut self, parameter: bool) {
        let end = &mut self.ends[usize::from(!parameter)];
        *end = checked_sum(0, end.next_multiple_of(lanes::<R>()));
    }

    /// New adjacent arrays for the outputs of an operation.
    pub(super) fn outputs(&mut self, len: usize, count: usize) -> Vec<Array> {
        self.align(false);
        (0..count).map(|_| self.allocate(false, len)).collect()
    }

    /// A new array directly behind the last one of the row.
    pub(super) fn unaligned_output(&mut self, len: usize) -> Array {
        self.allocate(false, len)
    }

    /// A new array for the output of an operation.
    pub(super) fn output(&mut self, len: usize) -> Array {
        self.align(false);
        self.allocate(false, len)
    }
}
