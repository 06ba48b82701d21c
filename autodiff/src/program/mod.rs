//! Programs over arrays: what one step of a simulation computes, recorded once and run many
//! times, forward and in reverse.
//!
//! A step is written once as a generic function over `R: Real` that calls the methods of
//! [`Program`]. For plain floats every operation runs in SIMD lanes; for duals, extended
//! precision or tape variables the same operations run on those numbers. There is no control
//! flow inside a program: kernels select, and what a model does not need is not recorded.
//!
//! All arrays of a step but the parameters lie one after the other in its **row**. If the state comes
//! first, the row of the next step begins where this one puts its new state, so that a rollout that
//! keeps its rows copies nothing: they are the record from which the reverse sweep works.
//!
//! A program may run from several **starts** at once: from two, or from a register's lanes of them.
//! Their numbers are interleaved: every number of a row stands there once for each start, so that an
//! array is that many times as long, and a graph is that many graphs interleaved. Operations treat the
//! longer arrays like any others; only products with matrices, which all starts share, are different.
//! Parameters other than matrices may differ from start to start.

mod aligned;
mod dense;
mod edges;
mod gather;
mod graph;
mod map;
mod operations;
mod outer;
mod panels;
mod product;
mod row;
mod run;
mod tiles;
mod watch;

use std::ops::Range;

use crate::lanes::{Lane, Vectorized, WIDEST};
use crate::real::Real;

pub(crate) use aligned::Aligned;
pub use graph::Graph;
use row::{Bars, Frame, Layout};
pub(crate) use watch::Watch;

/// A handle to an array of a [`Program`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Array {
    id: usize,
    /// Whether it lies among the parameters, or in the row of each step.
    parameter: bool,
    /// Where it begins there.
    start: usize,
    /// How many numbers it takes there, those of all starts together.
    len: usize,
    starts: usize,
}

impl Array {
    /// How many numbers the array holds.
    pub fn len(self) -> usize {
        self.len / self.starts
    }

    /// Whether it holds none, like an array along the edges of a graph without edges.
    pub fn is_empty(self) -> bool {
        self.len == 0
    }

    /// Where it lies, among the parameters or in the row.
    #[inline(always)]
    fn range(self) -> Range<usize> {
        self.start..self.start + self.len
    }
}

/// A handle to a matrix parameter of a [`Program`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Matrix {
    parameter: usize,
    rows: usize,
    columns: usize,
}

impl Matrix {
    /// How many numbers the matrix holds.
    fn len(self) -> usize {
        self.rows.checked_mul(self.columns).expect(TOO_LONG)
    }
}

/// What a parameter slot of a program expects.
#[derive(Clone, Copy, Debug)]
enum Parameter {
    Array(Array),
    Matrix(Matrix),
    /// By its index among the controls.
    Control(usize),
}

/// An array with values of its own in every step, and their cotangents.
struct Control<R> {
    array: Array,
    /// `array.len` numbers for each step, one step after the other.
    values: Vec<R>,
    /// Likewise; `None` where they are not asked for.
    bars: Option<Vec<R>>,
}

/// One recorded operation. Its outputs lie in the row after everything it reads.
trait Operation<R: Real>: Send {
    fn outputs(&self) -> Vec<Array>;
    fn forward(&mut self, parameters: &[R], row: &mut [R]);
    /// Adds to the bars of the inputs what follows from those of the outputs.
    fn reverse(&mut self, values: &Frame<R>, bars: &mut Bars<R>);
    /// Tells which arrays (by id) and which parameters carry derivatives; the rest may be skipped.
    fn set_active(&mut self, arrays: &[bool], parameters: &[bool]);
    /// Takes over the matrices among the parameters (row-major).
    fn load(&mut self, _parameters: &[&[R]]) {}
    /// Adds the cotangents of matrices (row-major) after the last step of a sweep.
    fn matrix_bars(&mut self, _parameter_bars: &mut [Vec<R>]) {}
}

/// A recorded step. See the [module](self).
///
/// Parameters, states, inputs and controls are declared in any order, before what reads them. Any
/// array may be empty.
pub struct Program<R: Real> {
    arrays: Vec<Array>,
    parameters: Vec<Parameter>,
    /// For each parameter, whether every start has its own; set by `load`.
    own: Vec<bool>,
    states: Vec<Array>,
    /// What each part of the state becomes.
    next: Vec<Option<Array>>,
    inputs: Vec<Array>,
    controls: Vec<Control<R>>,
    /// How many numbers the inputs of a step have, which all starts share.
    inputs_len: usize,
    operations: Vec<Box<dyn Operation<R>>>,
    /// From how many starts it runs at once, their numbers interleaved.
    starts: usize,
    /// How many numbers the parameters' arrays and a step's row take so far.
    ends: [usize; 2],
    layout: Layout,
    /// How many numbers of a later row each operation prefetches, in whole cache lines.
    prefetch_len: usize,
    /// How far past the arrays lanes may reach, beyond their own width.
    margin: usize,
}

struct LaneCount;

impl<R: Real> Vectorized<R> for LaneCount {
    type Output = usize;
    #[inline(always)]
    fn run<L: Lane<R>>(self) -> usize {
        L::N
    }
}

/// How many lanes a register of this type has on this machine.
pub(crate) fn lanes<R: Real>() -> usize {
    let lanes = R::vectorize(LaneCount);
    let fits = lanes.is_power_of_two() && lanes <= WIDEST;
    assert!(
        fits,
        "lanes of a number type are a power of two, {WIDEST} at most"
    );
    lanes
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
            layout: Layout::default(),
            prefetch_len: 0,
            margin: 0,
        }
    }
}

/// Declaring what a step works on.
impl<R: Real> Program<R> {
    /// A program that runs from this many starts at once: one, two, or one for each lane.
    pub(crate) fn side_by_side(starts: usize) -> Self {
        let most = lanes::<R>();
        assert!(
            starts == 1 || starts == most || starts == 2 && most > 2,
            "a program runs from one start, from two or from one for each lane"
        );
        Self {
            starts,
            ..Self::default()
        }
    }

    /// A parameter: an array of `len` numbers that stays the same for all steps.
    pub fn parameter(&mut self, len: usize) -> Array {
        self.align(true);
        let array = self.allocate(true, len);
        self.parameters.push(Parameter::Array(array));
        array
    }

    /// A matrix parameter, given row by row; for [`dense`](Program::dense) layers.
    pub fn matrix(&mut self, rows: usize, columns: usize) -> Matrix {
        let matrix = Matrix {
            parameter: self.parameters.len(),
            rows,
            columns,
        };
        self.parameters.push(Parameter::Matrix(matrix));
        matrix
    }

    /// A part of the state: an array of `len` numbers that one step hands to the next, see
    /// [`advance`](Program::advance).
    pub fn state(&mut self, len: usize) -> Array {
        let array = self.allocate(false, len);
        self.states.push(array);
        self.next.push(None);
        array
    }

    /// A per-step input: `len` constants for every step, without derivatives, from
    /// [`Rollout::inputs`](crate::Rollout::inputs). Where derivatives by them are wanted, declare a
    /// [control](Program::control).
    pub fn input(&mut self, len: usize) -> Array {
        let array = self.allocate(false, len);
        self.inputs.push(array);
        // Cannot overflow: `allocate` has checked the row, which holds them too.
        self.inputs_len += len;
        array
    }

    /// A control: an array with values of its own in every step, which carry derivatives. A rollout
    /// takes them as one parameter of `steps * len` numbers, one step after the other.
    ///
    /// ```
    /// use autodiff::{Adjoint, Kernel, Model, Program, Real, Rollout, Var, gradient_of};
    ///
    /// /// A mass of 1 that a force pushes, in steps of 0.1 s.
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
    /// impl Adjoint<3, 2> for Push {}
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
    /// let by_rollout = gradient_of(|forces| rollout.run(&start, &[forces])[0], &forces);
    /// let step = |[x, v]: [_; 2], &force: &_| Push.eval([x, v, force]);
    /// let by_tape = gradient_of(|forces| forces.iter().fold(start, step)[0], &forces);
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

    /// Says which array a part of the state becomes at the end of the step: the output of an
    /// operation, a part of the state as it was at the beginning, a parameter, an input or a control.
    ///
    /// # Panics
    /// If `state` is no part of the state or has been advanced before, the two differ in length, or
    /// `next` is of another program.
    pub fn advance(&mut self, state: Array, next: Array) {
        let part = self.states.iter().position(|s| *s == state);
        let part = part.expect("advance: the first array is no part of the state");
        self.assert_known(&[next]);
        assert_eq!(state.len, next.len, "advance: the arrays differ in length");
        let before = self.next[part].replace(next);
        assert!(
            before.is_none(),
            "advance: this part of the state was advanced before"
        );
    }

    /// An operation reads arrays that are there, and come before its outputs: steps rely on that
    /// without checks.
    fn assert_known(&self, arrays: &[Array]) {
        let known = |array: &Array| self.arrays.get(array.id) == Some(array);
        assert!(arrays.iter().all(known), "an array is of another program");
    }

    /// A new array behind all others of its part.
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

    /// Makes the next array begin at a multiple of the lanes.
    fn align(&mut self, parameter: bool) {
        let end = &mut self.ends[usize::from(!parameter)];
        *end = checked_sum(0, end.next_multiple_of(lanes::<R>()));
    }

    /// New arrays for the outputs of an operation, one after the other.
    fn outputs<const O: usize>(&mut self, len: usize) -> [Array; O] {
        self.align(false);
        [(); O].map(|()| self.allocate(false, len))
    }
}

/// The sum of places in a row. Unchecked reads rely on it: it must not wrap around.
fn checked_sum(a: usize, b: usize) -> usize {
    a.checked_add(b)
        .filter(|&sum| sum <= isize::MAX as usize)
        .expect(TOO_LONG)
}

const TOO_LONG: &str = "the arrays of a program are longer than any memory";

/// Every item `times` times, one after the other.
fn repeated<T: Copy>(items: &[T], times: usize) -> Vec<T> {
    let each = items
        .iter()
        .flat_map(|&item| std::iter::repeat_n(item, times));
    each.collect()
}
