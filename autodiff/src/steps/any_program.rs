//! A program for code that does not know its number type.

use std::marker::PhantomData;

use super::checks::{Known, Shape};
use super::operation::StepOperation;
use super::program::Program;
use crate::arrays::{Array, Graph, Kernel, UniformKernel};
use crate::real::{ByType, Real};
use crate::record::replay::Plan;
use crate::record::{Places, ReplayedKernel, recorded};

/// A [`Program`] for code that does not know the number type. Methods of a trait object cannot be generic, so they take
/// this type instead. [`Program::any`] creates it.
///
/// It has some of the operations of [`Program`]. A kernel is compiled for `f64` and `f32`, in the crate that calls this
/// type. All other number types replay a recording of the kernel, which gives the same numbers but is several times
/// slower. For these types the methods panic if the kernel cannot be recorded. A kernel cannot be recorded if it asks
/// whether a number [is zero](num_traits::Zero::is_zero) or whether [any](crate::Mask::any) lane of a mask is true, or
/// if it calls a [custom rule](crate::custom) or another [fused](Real::fused) function.
///
/// ```
/// use autodiff::{AnyProgram, Array, Kernel, Model, Program, Real, Rollout, gradient, kernel};
/// use std::sync::Arc;
///
/// /// A part of a model that is chosen at run time.
/// trait Force: Send + Sync {
///     fn record(&self, program: &mut AnyProgram, x: Array) -> Array;
/// }
///
/// struct Pull(f64);
/// impl Force for Pull {
///     fn record(&self, program: &mut AnyProgram, x: Array) -> Array {
///         program.map(Spring(self.0), [x])[0]
///     }
/// }
///
/// struct Spring(f64);
/// #[kernel]
/// impl Kernel<1, 1> for Spring {
///     fn eval<R: Real>(&self, [x]: [R; 1]) -> [R; 1] {
///         [-R::lit(self.0) * x]
///     }
/// }
///
/// #[derive(Clone)]
/// struct Relaxation(Arc<dyn Force>);
/// impl Model for Relaxation {
///     fn record<R: Real>(&self, program: &mut Program<R>) {
///         let x = program.state(1);
///         let force = self.0.record(&mut program.any(), x);
///         program.advance(x, force);
///     }
/// }
///
/// let rollout = Rollout::new(Relaxation(Arc::new(Pull(0.5))), 2);
/// assert_eq!(rollout.run(&[8.0], &[]), [2.0]);
/// assert_eq!(gradient(|x| rollout.run(x, &[])[0], &[8.0]), [0.25]);
/// ```
pub struct AnyProgram<'a>(Numbers<'a>);

enum Numbers<'a> {
    Double(&'a mut Program<f64>),
    Single(&'a mut Program<f32>),
    Other(&'a mut dyn Replaying),
}

impl<R: Real> Program<R> {
    /// Borrows this program for code that does not know the number type.
    pub fn any(&mut self) -> AnyProgram<'_> {
        R::by_type(Any(PhantomData), self)
    }
}

/// Converts a program that is borrowed for `'a` to an [`AnyProgram`].
struct Any<'a>(PhantomData<&'a ()>);

impl<'a> ByType for Any<'a> {
    type Of<R: Real> = &'a mut Program<R>;
    type Output<R: Real> = AnyProgram<'a>;
    fn f64(self, program: &'a mut Program<f64>) -> AnyProgram<'a> {
        AnyProgram(Numbers::Double(program))
    }
    fn f32(self, program: &'a mut Program<f32>) -> AnyProgram<'a> {
        AnyProgram(Numbers::Single(program))
    }
    fn other<R: Real>(self, program: &'a mut Program<R>) -> AnyProgram<'a> {
        AnyProgram(Numbers::Other(program))
    }
}

impl AnyProgram<'_> {
    /// Like [`Program::map`].
    ///
    /// # Panics
    /// Like [`Program::map`]. Also if the number type is not a float and the kernel [cannot be recorded](AnyProgram).
    #[track_caller]
    pub fn map<K, const I: usize, const O: usize>(&mut self, kernel: K, x: [Array; I]) -> [Array; O]
    where
        K: Kernel<I, O>,
    {
        self.map_with(kernel, x, &[])
    }

    /// Like [`Program::map_with`].
    ///
    /// # Panics
    /// Like [`Program::map_with`]. Also if the number type is not a float and the kernel [cannot be
    /// recorded](AnyProgram).
    #[track_caller]
    pub fn map_with<K, const I: usize, const O: usize>(
        &mut self,
        kernel: K,
        x: [Array; I],
        uniforms: &[Array],
    ) -> [Array; O]
    where
        K: UniformKernel<I, O>,
    {
        match &mut self.0 {
            Numbers::Double(program) => program.map_with(kernel, x, uniforms),
            Numbers::Single(program) => program.map_with(kernel, x, uniforms),
            Numbers::Other(program) => {
                let shape = Shape::of::<K, I, O>();
                program.arrays_known().check_map(&x, uniforms, shape);
                array(program.map_recorded(recorded(&kernel), &x, uniforms))
            }
        }
    }

    /// Like [`Program::map_edges`].
    ///
    /// # Panics
    /// Like [`Program::map_edges`]. Also if the number type is not a float and the kernel [cannot be
    /// recorded](AnyProgram).
    #[track_caller]
    pub fn map_edges<K, const C: usize, const I: usize, const O: usize>(
        &mut self,
        graph: &Graph,
        kernel: K,
        ends: [Array; C],
        per_edge: &[Array],
    ) -> [Array; O]
    where
        K: Kernel<I, O>,
    {
        self.map_edges_with(graph, kernel, ends, per_edge, &[])
    }

    /// Like [`Program::map_edges_with`].
    ///
    /// # Panics
    /// Like [`Program::map_edges_with`]. Also if the number type is not a float and the kernel [cannot be
    /// recorded](AnyProgram).
    #[track_caller]
    pub fn map_edges_with<K, const C: usize, const I: usize, const O: usize>(
        &mut self,
        graph: &Graph,
        kernel: K,
        ends: [Array; C],
        per_edge: &[Array],
        uniforms: &[Array],
    ) -> [Array; O]
    where
        K: UniformKernel<I, O>,
    {
        match &mut self.0 {
            Numbers::Double(program) => {
                program.map_edges_with(graph, kernel, ends, per_edge, uniforms)
            }
            Numbers::Single(program) => {
                program.map_edges_with(graph, kernel, ends, per_edge, uniforms)
            }
            Numbers::Other(program) => {
                let inputs = [&ends[..], per_edge];
                let shape = Shape::of::<K, I, O>();
                (program.arrays_known()).check_edges(graph, inputs, uniforms, shape);
                let kernel = recorded(&kernel);
                array(program.map_edges_recorded(graph, kernel, inputs, uniforms, true))
            }
        }
    }

    /// Like [`Program::map_each_edge`].
    ///
    /// # Panics
    /// Like [`Program::map_each_edge`]. Also if the number type is not a float and the kernel [cannot be
    /// recorded](AnyProgram).
    #[track_caller]
    pub fn map_each_edge<K, const C: usize, const I: usize, const O: usize>(
        &mut self,
        graph: &Graph,
        kernel: K,
        ends: [Array; C],
        per_edge: &[Array],
        uniforms: &[Array],
    ) -> [Array; O]
    where
        K: UniformKernel<I, O>,
    {
        match &mut self.0 {
            Numbers::Double(program) => {
                program.map_each_edge(graph, kernel, ends, per_edge, uniforms)
            }
            Numbers::Single(program) => {
                program.map_each_edge(graph, kernel, ends, per_edge, uniforms)
            }
            Numbers::Other(program) => {
                let inputs = [&ends[..], per_edge];
                let shape = Shape::of::<K, I, O>();
                (program.arrays_known()).check_edges(graph, inputs, uniforms, shape);
                let kernel = recorded(&kernel);
                array(program.map_edges_recorded(graph, kernel, inputs, uniforms, false))
            }
        }
    }

    /// Like [`Program::gather`].
    ///
    /// # Panics
    /// Like [`Program::gather`].
    #[track_caller]
    pub fn gather(&mut self, x: Array, indices: &[Option<usize>]) -> Array {
        match &mut self.0 {
            Numbers::Double(program) => program.gather(x, indices),
            Numbers::Single(program) => program.gather(x, indices),
            Numbers::Other(program) => {
                program.arrays_known().check_gather(x, indices);
                program.gather_any(x, indices)
            }
        }
    }

    /// Like [`Program::weighted`].
    ///
    /// # Panics
    /// Like [`Program::weighted`].
    #[track_caller]
    pub fn weighted(
        &mut self,
        weights: Array,
        offsets: &[Array],
        values: &[Array],
        others: &[Array],
    ) -> [Array; 2] {
        match &mut self.0 {
            Numbers::Double(program) => program.weighted(weights, offsets, values, others),
            Numbers::Single(program) => program.weighted(weights, offsets, values, others),
            Numbers::Other(program) => {
                let arrays = [offsets, values, others];
                program.arrays_known().check_weighted(weights, arrays);
                program.weighted_any(weights, arrays)
            }
        }
    }

    /// Like [`Program::solve`].
    ///
    /// # Panics
    /// Like [`Program::solve`].
    #[track_caller]
    pub fn solve<const N: usize>(
        &mut self,
        graph: &Graph,
        nodes: &[Array],
        edges: &[Array],
        b: [Array; N],
    ) -> [Array; N] {
        self.solve_held(graph, nodes, edges, &[], b)
    }

    /// Like [`Program::solve_held`].
    ///
    /// # Panics
    /// Like [`Program::solve_held`].
    #[track_caller]
    pub fn solve_held<const N: usize>(
        &mut self,
        graph: &Graph,
        nodes: &[Array],
        edges: &[Array],
        held: &[Array],
        b: [Array; N],
    ) -> [Array; N] {
        let equations = [nodes, edges, &b, held];
        array(match &mut self.0 {
            Numbers::Double(program) => program.solve_all(graph, equations),
            Numbers::Single(program) => program.solve_all(graph, equations),
            Numbers::Other(program) => {
                program.arrays_known().check_solve(graph, equations);
                program.solve_any(graph, equations)
            }
        })
    }

    /// Like [`Program::sum_at_nodes`].
    ///
    /// # Panics
    /// Like [`Program::sum_at_nodes`].
    #[track_caller]
    pub fn sum_at_nodes(&mut self, graph: &Graph, x: Array) -> Array {
        match &mut self.0 {
            Numbers::Double(program) => program.sum_at_nodes(graph, x),
            Numbers::Single(program) => program.sum_at_nodes(graph, x),
            Numbers::Other(program) => {
                program.arrays_known().check_node_sum(graph, x);
                program.sum_at_nodes_any(graph, x)
            }
        }
    }
}

/// Converts the list of outputs to an array of fixed length. There is one output for each result of the kernel.
fn array<const O: usize>(outputs: Vec<Array>) -> [Array; O] {
    outputs
        .try_into()
        .expect("there is one array for each result")
}

/// A program whose number type replays kernels. This trait hides the number type of the program.
pub(super) trait Replaying {
    /// The arrays of the program. The other methods do not check theirs.
    fn arrays_known(&self) -> Known<'_>;
    fn map_recorded(&mut self, kernel: Plan, x: &[Array], uniforms: &[Array]) -> Vec<Array>;
    fn map_edges_recorded(
        &mut self,
        graph: &Graph,
        kernel: Plan,
        inputs: [&[Array]; 2],
        uniforms: &[Array],
        sums: bool,
    ) -> Vec<Array>;
    fn gather_any(&mut self, x: Array, indices: &[Option<usize>]) -> Array;
    fn solve_any(&mut self, graph: &Graph, equations: [&[Array]; 4]) -> Vec<Array>;
    fn sum_at_nodes_any(&mut self, graph: &Graph, x: Array) -> Array;
    fn weighted_any(&mut self, weights: Array, arrays: [&[Array]; 3]) -> [Array; 2];
}

impl<R: Real> Replaying for Program<R> {
    fn arrays_known(&self) -> Known<'_> {
        self.known()
    }

    fn map_recorded(&mut self, kernel: Plan, x: &[Array], uniforms: &[Array]) -> Vec<Array> {
        let len = x.first().map_or(0, |x| x.len());
        let outputs = self.outputs(len, kernel.results());
        let places = Places::elements(&outputs);
        let kernel = ReplayedKernel::new(kernel, places, x, uniforms, &outputs);
        self.operations.push(StepOperation::Replayed(kernel));
        outputs
    }

    fn map_edges_recorded(
        &mut self,
        graph: &Graph,
        kernel: Plan,
        inputs: [&[Array]; 2],
        uniforms: &[Array],
        sums: bool,
    ) -> Vec<Array> {
        let (graph, outputs) = self.edge_outputs(graph, kernel.results(), sums);
        let places = Places::edges(&graph, inputs[0].len(), sums);
        let kernel = ReplayedKernel::new(kernel, places, &inputs.concat(), uniforms, &outputs);
        self.operations.push(StepOperation::Replayed(kernel));
        outputs
    }

    fn gather_any(&mut self, x: Array, indices: &[Option<usize>]) -> Array {
        self.gather(x, indices)
    }

    fn solve_any(&mut self, graph: &Graph, equations: [&[Array]; 4]) -> Vec<Array> {
        self.solve_all(graph, equations)
    }

    fn sum_at_nodes_any(&mut self, graph: &Graph, x: Array) -> Array {
        self.sum_at_nodes(graph, x)
    }

    fn weighted_any(
        &mut self,
        weights: Array,
        [offsets, values, others]: [&[Array]; 3],
    ) -> [Array; 2] {
        self.weighted(weights, offsets, values, others)
    }
}
