//! The program of a step: declarations and memory layout.

use super::checks::Known;
use super::operation::StepOperation;
use crate::arrays::{Array, Matrix, Parameter, TOO_LONG, checked_sum};

/// A recorded step of a simulation, which a [`Rollout`](crate::Rollout) runs many times, forward and in reverse.
///
/// All arrays of a step, except for the parameters, lie one after the other in a **row**. If the state comes first in
/// the row, the next row begins at this row's new state. A rollout that keeps all rows then copies nothing. The reverse
/// sweep reads the rows from the last to the first and recomputes the values inside operations. The memory is `steps`
/// rows, or less with a [`Memory`](crate::Memory) budget.
///
/// Parameters, states, inputs and controls can be declared in any order, but before the operations that read them.
/// Arrays may be empty.
///
/// A program does not depend on the type of the numbers with which a [`Rollout`](crate::Rollout) runs it. A kernel is
/// compiled for `f64` and `f32`, in the crate that records it. All other number types replay a recording of the kernel,
/// which gives the same numbers but is several times slower. With these types, rollouts panic if a kernel cannot be
/// recorded, because it asks whether a number [is zero](num_traits::Zero::is_zero) or whether [any](autodiff::Mask::any) lane
/// of a mask is true, or because it calls a [custom rule](autodiff::custom) or another [fused](autodiff::Real::fused) function.
///
/// So a part of a model can be chosen at run time:
///
/// ```
/// use autodiff::{Real, gradient};
/// use autodiff_programs::{Array, Kernel, Model, Program, Rollout, kernel};
/// use std::sync::Arc;
///
/// trait Force: Send + Sync {
///     fn record(&self, program: &mut Program, x: Array) -> Array;
/// }
///
/// struct Pull(f64);
/// impl Force for Pull {
///     fn record(&self, program: &mut Program, x: Array) -> Array {
///         program.map(Spring(self.0), [x], &[])[0]
///     }
/// }
///
/// struct Spring(f64);
/// #[kernel]
/// impl Kernel<1, 1> for Spring {
///     fn eval<R: Real>(&self, [x]: [R; 1], _: &[R]) -> [R; 1] {
///         [-R::lit(self.0) * x]
///     }
/// }
///
/// #[derive(Clone)]
/// struct Relaxation(Arc<dyn Force>);
/// impl Model for Relaxation {
///     fn record(&self, program: &mut Program) {
///         let x = program.state(1);
///         let force = self.0.record(program, x);
///         program.advance(x, force);
///     }
/// }
///
/// let rollout = Rollout::new(Relaxation(Arc::new(Pull(0.5))), 2);
/// assert_eq!(rollout.run(&[8.0], &[]), [2.0]);
/// assert_eq!(gradient(|x| rollout.run(x, &[])[0], &[8.0]), [0.25]);
/// ```
pub struct Program {
    pub(crate) arrays: Vec<Array>,
    pub(crate) parameters: Vec<Parameter>,
    pub(crate) states: Vec<Array>,
    /// For each part of the state, the array that holds its new value.
    pub(crate) next: Vec<Option<Array>>,
    pub(crate) inputs: Vec<Array>,
    pub(crate) controls: Vec<Array>,
    /// How many numbers each step takes as input. The inputs are the same for all starts (initial states).
    pub(crate) inputs_len: usize,
    pub(crate) operations: Vec<StepOperation>,
    /// The number of starts that run at once, with interleaved numbers.
    pub(crate) starts: usize,
    /// The number of lanes of a register.
    lanes: usize,
    /// How many numbers are allocated so far: first for the parameters, then for a row.
    pub(crate) ends: [usize; 2],
    /// Accesses of whole registers may go beyond the end of an array by this many numbers, in addition to the width of
    /// a register.
    pub(super) margin: usize,
}

impl Default for Program {
    fn default() -> Self {
        Self::side_by_side(1, 1)
    }
}

/// Declarations of parameters, states, inputs and controls.
impl Program {
    /// Creates a program that runs `starts` starts at once: one, two, or one for each of the `lanes` of a register.
    #[track_caller]
    pub(crate) fn side_by_side(starts: usize, lanes: usize) -> Self {
        assert!(
            starts == 1 || starts == lanes || starts == 2 && lanes > 2,
            "a program cannot run {starts} starts at once; the number must be 1, 2 or {lanes} (one for each lane)"
        );
        Self {
            arrays: Vec::new(),
            parameters: Vec::new(),
            states: Vec::new(),
            next: Vec::new(),
            inputs: Vec::new(),
            controls: Vec::new(),
            inputs_len: 0,
            operations: Vec::new(),
            starts,
            lanes,
            ends: [0; 2],
            margin: 0,
        }
    }

    /// Declares a parameter: an array of `len` numbers that is the same in all steps.
    #[track_caller]
    pub fn parameter(&mut self, len: usize) -> Array {
        self.align(true);
        let array = self.allocate(true, len);
        self.parameters.push(Parameter::Array(array));
        array
    }

    /// Declares a matrix parameter for [`dense`](Program::dense) layers. Its values are given in row-major order.
    #[track_caller]
    pub fn matrix(&mut self, rows: usize, columns: usize) -> Matrix {
        let matrix = Matrix {
            parameter: self.parameters.len(),
            rows,
            columns,
        };
        self.parameters.push(Parameter::Matrix(matrix));
        matrix
    }

    /// Declares a part of the state: an array of `len` numbers that each step passes to the next. The step must call
    /// [`advance`](Program::advance) for it.
    #[track_caller]
    pub fn state(&mut self, len: usize) -> Array {
        let array = self.allocate(false, len);
        self.states.push(array);
        self.next.push(None);
        array
    }

    /// Declares an input: `len` constants for each step, taken from [`Rollout::inputs`](crate::Rollout::inputs). Inputs
    /// carry no derivatives. If you need derivatives, declare a [control](Program::control).
    #[track_caller]
    pub fn input(&mut self, len: usize) -> Array {
        let array = self.allocate(false, len);
        self.inputs.push(array);
        // This cannot overflow: the row also holds the inputs, and `allocate` has checked its length.
        self.inputs_len += len;
        array
    }

    /// Declares a control: an array of `len` numbers whose values differ from step to step and carry derivatives. A
    /// rollout takes it as one parameter of `steps * len` numbers, one step after the other.
    ///
    /// ```
    /// use autodiff::{Real, Var, gradient};
    /// use autodiff_programs::{Kernel, Model, Program, Rollout, kernel};
    ///
    /// /// A mass of 1 on a spring, pushed by a force, in steps of 0.1 s.
    /// #[derive(Clone, Copy)]
    /// struct Push;
    ///
    /// #[kernel]
    /// impl Kernel<3, 2> for Push {
    ///     fn eval<R: Real>(&self, [x, v, force]: [R; 3], _: &[R]) -> [R; 2] {
    ///         let v = v + R::lit(0.1) * (force - x);
    ///         [x + R::lit(0.1) * v, v]
    ///     }
    /// }
    ///
    /// impl Model for Push {
    ///     fn record(&self, program: &mut Program) {
    ///         let [x, v] = [(); 2].map(|()| program.state(1));
    ///         let force = program.control(1);
    ///         let [x_next, v_next] = program.map(Push, [x, v, force], &[]);
    ///         program.advance(x, x_next);
    ///         program.advance(v, v_next);
    ///     }
    /// }
    ///
    /// let forces = [1.0, 2.0, 0.5, -1.0];
    /// let rollout = Rollout::new(Push, forces.len());
    /// let start = [0.0, 1.0].map(Var::constant);
    /// let by_rollout = gradient(|forces| rollout.run(&start, &[forces])[0], &forces);
    /// let step = |[x, v]: [_; 2], &force: &_| Push.eval([x, v, force], &[]);
    /// let by_tape = gradient(|forces| forces.iter().fold(start, step)[0], &forces);
    /// for (a, b) in by_rollout.into_iter().zip(by_tape) {
    ///     assert!((a - b).abs() < 1e-15);
    /// }
    /// ```
    #[track_caller]
    pub fn control(&mut self, len: usize) -> Array {
        let array = self.allocate(false, len);
        self.parameters
            .push(Parameter::Control(self.controls.len()));
        self.controls.push(array);
        array
    }

    /// Sets the new value of a part of the state: the value at the end of the step. `next` can be the output of an
    /// operation, the old value of a part of the state, a parameter, an input or a control.
    ///
    /// # Panics
    /// If `state` is not a part of the state or was already advanced, if the lengths differ, or if `next` belongs to
    /// another program.
    #[track_caller]
    pub fn advance(&mut self, state: Array, next: Array) {
        let part = self.states.iter().position(|s| *s == state);
        let part = part.expect("advance: `state` must be a part of the state");
        self.known().check(&[next]);
        assert_eq!(
            state.len, next.len,
            "advance: `state` and `next` must have the same length"
        );
        let before = self.next[part].replace(next);
        assert!(
            before.is_none(),
            "advance: this part of the state was already advanced; call `advance` once for each part"
        );
    }

    /// Returns the arrays of this program, for checks.
    pub(super) fn known(&self) -> Known<'_> {
        Known(&self.arrays)
    }

    /// # Panics
    /// If a part of the state was not advanced.
    #[track_caller]
    pub(crate) fn assert_advanced(&self) {
        assert!(
            self.next.iter().all(Option::is_some),
            "a part of the state is never advanced; call `Program::advance` for each part"
        );
    }

    /// Allocates an array after all other parameters, or after all other arrays of the row.
    #[track_caller]
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

    /// Makes the next array begin at a multiple of the lane count.
    #[track_caller]
    pub(super) fn align(&mut self, parameter: bool) {
        let end = &mut self.ends[usize::from(!parameter)];
        *end = checked_sum(0, end.next_multiple_of(self.lanes));
    }

    /// Allocates adjacent arrays for the outputs of an operation.
    #[track_caller]
    pub(super) fn outputs(&mut self, len: usize, count: usize) -> Vec<Array> {
        self.align(false);
        let mut outputs = Vec::with_capacity(count);
        for _ in 0..count {
            outputs.push(self.allocate(false, len));
        }
        outputs
    }

    /// Allocates an array at the end of the row, directly after the last array.
    #[track_caller]
    pub(super) fn unaligned_output(&mut self, len: usize) -> Array {
        self.allocate(false, len)
    }

    /// Allocates an array for the output of an operation.
    #[track_caller]
    pub(super) fn output(&mut self, len: usize) -> Array {
        self.align(false);
        self.allocate(false, len)
    }
}
