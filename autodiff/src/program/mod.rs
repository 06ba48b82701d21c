//! Programs over arrays: what one step of a simulation computes, recorded once and run many
//! times, forward and in reverse.
//!
//! A step is written once as a generic function over `R: Real` that calls the methods of
//! [`Program`]. For plain floats every operation runs in SIMD lanes; for duals, extended
//! precision or tape variables the same operations run on those numbers. There is no control
//! flow inside a program: kernels select, and what a scene does not need is not recorded.

mod aligned;
mod dense;
mod edges;
mod gather;
mod graph;
mod map;
mod run;

use std::ops::Range;

use crate::kernel::Adjoint;
use crate::lanes::{Lane, Vectorized, WIDEST};
use crate::real::Real;

pub(crate) use aligned::Aligned;
pub use graph::Graph;

/// A handle to an array of a [`Program`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Array {
    id: usize,
    start: usize,
    len: usize,
}

impl Array {
    /// How many numbers the array holds.
    #[allow(clippy::len_without_is_empty)] // an empty array cannot be declared
    pub fn len(self) -> usize {
        self.len
    }

    /// Where it lies in the arena.
    fn range(self) -> Range<usize> {
        self.start..self.start + self.len
    }

    /// Where its entries from the `i`th on lie.
    #[inline(always)]
    fn from(self, i: usize) -> Range<usize> {
        self.start + i..self.start + self.len
    }
}

/// A handle to a matrix parameter of a [`Program`].
#[derive(Clone, Copy, Debug)]
pub struct Matrix {
    parameter: usize,
    rows: usize,
    columns: usize,
}

/// What a parameter slot of a program expects.
#[derive(Clone, Copy, Debug)]
enum Parameter {
    Array(Array),
    Matrix(Matrix),
}

/// One recorded operation. Values and cotangents ("bars") lie in two arenas of equal layout.
trait Operation<R: Real>: Send {
    fn inputs(&self) -> Vec<Array>;
    fn outputs(&self) -> Vec<Array>;
    fn forward(&mut self, values: &mut [R]);
    /// Adds to the bars of the inputs what the bars of the outputs give.
    fn reverse(&mut self, values: &[R], bars: &mut [R]);
    /// The values that `reverse` reads.
    fn reverse_reads(&self) -> Vec<Array>;
    /// Tells which arrays and matrices carry derivatives; the rest may be skipped.
    fn set_active(&mut self, arrays: &[bool], parameters: &[bool]);
    /// Takes over the matrices among the parameters (row-major).
    fn load(&mut self, _parameters: &[&[R]]) {}
    /// Whether the outputs cost enough to be kept for the reverse sweep.
    fn expensive(&self) -> bool {
        false
    }
    /// Adds the cotangents of matrices (row-major) after the last step of a sweep.
    fn matrix_bars(&mut self, _parameter_bars: &mut [Vec<R>]) {}
}

/// A recorded step. See the [module](self).
///
/// Parameters are declared first, then states and inputs, then operations.
pub struct Program<R: Real> {
    arrays: Vec<Array>,
    parameters: Vec<Parameter>,
    states: Vec<Array>,
    next: Vec<Option<Array>>,
    inputs: Vec<Array>,
    kept: Vec<Array>,
    operations: Vec<Box<dyn Operation<R>>>,
    /// Per operation: must it run again in the reverse sweep?
    rerun: Vec<bool>,
    layout: Layout,
    arena_len: usize,
    parameters_end: usize,
    /// How far past the arrays lanes may reach, beyond their own width.
    margin: usize,
}

/// Where the arrays that are copied every step lie, neighbours joined.
#[derive(Default)]
struct Layout {
    state: Vec<Range<usize>>,
    next: Vec<Range<usize>>,
    kept: Vec<Range<usize>>,
    inputs: Vec<Range<usize>>,
}

/// The ranges of arrays, those joined that touch.
fn joined(arrays: impl IntoIterator<Item = Array>) -> Vec<Range<usize>> {
    let mut ranges: Vec<Range<usize>> = Vec::new();
    for array in arrays {
        match ranges.last_mut() {
            Some(last) if last.end == array.start => last.end += array.len,
            _ => ranges.push(array.range()),
        }
    }
    ranges
}

struct LaneCount;

impl<R: Real> Vectorized<R> for LaneCount {
    type Output = usize;
    #[inline(always)]
    fn run<L: Lane<R>>(self) -> usize {
        L::N
    }
}

/// Lanes of this type on this machine.
fn lanes<R: Real>() -> usize {
    R::vectorize(LaneCount)
}

impl<R: Real> Default for Program<R> {
    fn default() -> Self {
        Self {
            arrays: Vec::new(),
            parameters: Vec::new(),
            states: Vec::new(),
            next: Vec::new(),
            inputs: Vec::new(),
            kept: Vec::new(),
            operations: Vec::new(),
            rerun: Vec::new(),
            layout: Layout::default(),
            arena_len: 0,
            parameters_end: 0,
            margin: 0,
        }
    }
}

/// Declaring what a step works on.
impl<R: Real> Program<R> {
    /// A parameter: an array that stays the same for all steps.
    pub fn parameter(&mut self, len: usize) -> Array {
        let array = self.parameter_space(len);
        self.parameters.push(Parameter::Array(array));
        array
    }

    /// A matrix parameter, given row by row.
    pub fn matrix(&mut self, rows: usize, columns: usize) -> Matrix {
        let matrix = Matrix {
            parameter: self.parameters.len(),
            rows,
            columns,
        };
        self.parameters.push(Parameter::Matrix(matrix));
        matrix
    }

    /// A part of the state: an array that one step hands to the next.
    pub fn state(&mut self, len: usize) -> Array {
        let array = self.allocate(len);
        self.states.push(array);
        self.next.push(None);
        array
    }

    /// A per-step input: constants given for every step, which carry no derivative.
    pub fn input(&mut self, len: usize) -> Array {
        let array = self.allocate(len);
        self.inputs.push(array);
        array
    }

    /// States which array a part of the state becomes at the end of the step.
    pub fn advance(&mut self, state: Array, next: Array) {
        let part = self.states.iter().position(|s| *s == state);
        let part = part.expect("advance: the first array is no part of the state");
        assert_eq!(state.len, next.len, "advance: the arrays differ in length");
        self.next[part] = Some(next);
    }

    /// Keeps an array of every step for the reverse sweep in place of computing it again.
    pub fn keep(&mut self, array: Array) {
        self.kept.push(array);
    }

    fn parameter_space(&mut self, len: usize) -> Array {
        assert!(
            self.states.is_empty() && self.inputs.is_empty() && self.operations.is_empty(),
            "parameters of a program are declared before its states, inputs and operations"
        );
        let array = self.allocate(len);
        self.parameters_end = self.arena_len;
        array
    }

    fn allocate(&mut self, len: usize) -> Array {
        assert!(len > 0, "an array of a program holds at least one number");
        let array = Array {
            id: self.arrays.len(),
            start: self.arena_len,
            len,
        };
        self.arrays.push(array);
        self.arena_len += len;
        array
    }

    fn push(&mut self, operation: impl Operation<R> + 'static) {
        if operation.expensive() {
            self.kept.extend(operation.outputs());
        }
        self.operations.push(Box::new(operation));
    }
}

/// The operations.
impl<R: Real> Program<R> {
    /// Maps a kernel over arrays of one length.
    pub fn map<K, const I: usize, const O: usize>(&mut self, kernel: K, x: [Array; I]) -> [Array; O]
    where
        K: Adjoint<I, O>,
    {
        let len = x[0].len;
        assert!(
            x.iter().all(|a| a.len == len),
            "map: the arrays differ in length"
        );
        let outputs = std::array::from_fn(|_| self.allocate(len));
        self.push(map::Map::new(kernel, x, outputs));
        outputs
    }

    /// `matrix * (x_0, x_1, ...) + bias`.
    pub fn dense(&mut self, matrix: Matrix, x: &[Array], bias: Array) -> Array {
        self.dense_layer(matrix, x, bias, false)
    }

    /// `tanh(matrix * (x_0, x_1, ...) + bias)`.
    pub fn dense_tanh(&mut self, matrix: Matrix, x: &[Array], bias: Array) -> Array {
        self.dense_layer(matrix, x, bias, true)
    }

    fn dense_layer(&mut self, matrix: Matrix, x: &[Array], bias: Array, tanh: bool) -> Array {
        let columns: usize = x.iter().map(|a| a.len).sum();
        assert_eq!(
            columns, matrix.columns,
            "dense: inputs and matrix columns differ"
        );
        assert_eq!(bias.len, matrix.rows, "dense: bias and matrix rows differ");
        let output = self.allocate(matrix.rows);
        self.push(dense::Dense::new(matrix, x.to_vec(), [bias, output], tanh));
        output
    }

    /// Maps a kernel over the edges of a graph and sums its results up at their nodes.
    ///
    /// The kernel's inputs are, per edge, the differences of `ends` (the value at the head less
    /// that at the tail, of arrays over the nodes) and then `per_edge` (arrays in the slot layout
    /// of the [`Graph`]). Each result counts plus at the edge's tail and minus at its head: the
    /// outputs are arrays over the nodes.
    pub fn map_edges<K, const C: usize, const I: usize, const O: usize>(
        &mut self,
        graph: &Graph,
        kernel: K,
        (ends, per_edge): ([Array; C], &[Array]),
    ) -> [Array; O]
    where
        K: Adjoint<I, O>,
    {
        let fits = ends.iter().all(|a| a.len == graph.nodes());
        assert!(fits, "map_edges: an array of ends has one value per node");
        let fits = per_edge.iter().all(|a| a.len == graph.slots());
        assert!(fits, "map_edges: an array per edge has one value per slot");
        self.margin = self.margin.max(graph.lead());
        let outputs = [(); O].map(|()| self.allocate(graph.nodes()));
        self.push(edges::EdgeMap::new(
            kernel,
            graph,
            (ends, per_edge),
            outputs,
        ));
        outputs
    }

    /// `x[index]` for every index, and zero where there is none.
    pub fn gather(&mut self, x: Array, indices: &[Option<usize>]) -> Array {
        assert!(
            indices.iter().flatten().all(|&i| i < x.len),
            "gather: an index is out of range"
        );
        let output = self.allocate(indices.len());
        self.push(gather::Gather::new(x, indices, output));
        output
    }
}

fn copy_in<R: Real>(ranges: &[Range<usize>], values: &mut [R], mut from: &[R]) {
    for range in ranges {
        let (part, rest) = from.split_at(range.len());
        values[range.clone()].copy_from_slice(part);
        from = rest;
    }
}

fn copy_out<R: Real>(ranges: &[Range<usize>], values: &[R], to: &mut Vec<R>) {
    for range in ranges {
        to.extend_from_slice(&values[range.clone()]);
    }
}
