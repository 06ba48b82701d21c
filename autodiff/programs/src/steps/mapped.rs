//! Kernels that a step maps over arrays. The step does not know their types, so each is a trait object.

use std::any::type_name;
use std::panic::Location;

use autodiff::Real;
use autodiff::internal::{lanes, of_floats};

use crate::arrays::{Array, Compiled, EdgeMap, Graph, InLanes, Kernel, Map, Operation};
use crate::record::replay::Plan;
use crate::record::{Places, ReplayedKernel, WithUniforms, recorded};

/// A kernel that is mapped over arrays.
pub struct Mapped {
    kernel: Box<dyn AnyKernel>,
    pub arrays: Arrays,
    /// Where the kernel is mapped.
    place: &'static Location<'static>,
}

/// What a kernel reads and writes.
pub struct Arrays {
    pub inputs: Vec<Array>,
    pub uniforms: Vec<Array>,
    /// The output arrays, adjacent in memory.
    pub outputs: Vec<Array>,
    /// The edges over which the kernel is mapped; `None` if it is mapped over the elements of the arrays.
    pub(super) edges: Option<Edges>,
}

/// The edges over which a kernel is mapped.
pub(super) struct Edges {
    /// The graph of one start.
    pub(super) graph: Graph,
    /// The number of starts, whose numbers are interleaved.
    pub(super) starts: usize,
    /// The number of inputs that are differences of node values. They come first.
    pub(super) differences: usize,
    /// Whether results are summed at the nodes; otherwise they stay at the edges.
    pub(super) sums: bool,
}

impl Mapped {
    #[track_caller]
    pub(super) fn new(kernel: impl AnyKernel, arrays: Arrays) -> Self {
        Self {
            kernel: Box::new(kernel),
            arrays,
            place: Location::caller(),
        }
    }

    /// The kernel as an operation. For plain floats it is compiled, unless it asks for replays, or is compiled in lanes only
    /// and the processor has none. All other number types replay its recording.
    pub(super) fn compiled<R: Real>(self) -> Box<dyn Operation<R>> {
        // The condition is constant, so that nothing else is compiled for other number types.
        if const { !R::IS_FLOAT } {
            return Box::new(self.replayed());
        }
        let has_lanes = !R::KERNELS_NEED_LANES || lanes::<R>() > 1;
        if !has_lanes || self.kernel.compiled().is_replayed() {
            return Box::new(self.replayed());
        }
        let has_uniforms = !self.arrays.uniforms.is_empty();
        let recorded = has_uniforms.then(|| self.recorded());
        type CompileFn<R> = fn(Box<dyn AnyKernel>, &Arrays) -> Box<dyn Operation<R>>;
        let compile: CompileFn<R> = of_floats(
            <dyn AnyKernel>::double as CompileFn<f64>,
            <dyn AnyKernel>::single as CompileFn<f32>,
        );
        let compiled = compile(self.kernel, &self.arrays);
        match recorded {
            Some(recorded) => {
                Box::new(WithUniforms::new(compiled, &self.arrays.uniforms, recorded))
            }
            None => compiled,
        }
    }

    /// The recording of the kernel.
    ///
    /// # Panics
    /// If it cannot be recorded: see [`Program`](super::Program).
    pub fn replayed(&self) -> ReplayedKernel {
        self.recorded().unwrap_or_else(|why| panic!("{why}"))
    }

    /// The recording of the kernel, or why it cannot be recorded.
    fn recorded(&self) -> Result<ReplayedKernel, String> {
        let Arrays {
            inputs,
            uniforms,
            outputs,
            edges,
        } = &self.arrays;
        let places = match edges {
            None => Places::elements(outputs),
            Some(edges) => Places::edges(&edges.graph, edges.differences, edges.sums),
        };
        let Some(plan) = self.kernel.recorded() else {
            return Err(format!(
                "kernel {}, mapped at {}, cannot be replayed on this number type: it branches on a value (a zero test or \
                 a mask) or calls a fused function; it needs f64 or f32, a processor with SIMD lanes, and uniform inputs \
                 without derivatives",
                self.kernel.name(),
                self.place
            ));
        };
        Ok(ReplayedKernel::new(plan, places, inputs, uniforms, outputs))
    }
}

/// A kernel of any type.
pub(super) trait AnyKernel: Send + 'static {
    /// See [`Kernel::COMPILED`].
    fn compiled(&self) -> Compiled;
    fn double(self: Box<Self>, arrays: &Arrays) -> Box<dyn Operation<f64>>;
    fn single(self: Box<Self>, arrays: &Arrays) -> Box<dyn Operation<f32>>;
    /// Returns `None` if the kernel cannot be recorded.
    fn recorded(&self) -> Option<Plan>;
    /// The name of its type.
    fn name(&self) -> &'static str;
}

/// A kernel of a known type.
trait Compile: Send + 'static {
    type Kernel;
    const COMPILED: Compiled;
    fn operation<R: Real>(self, arrays: &Arrays) -> Box<dyn Operation<R>>;
    fn recorded(&self) -> Option<Plan>;
}

impl<K: Compile> AnyKernel for K {
    fn compiled(&self) -> Compiled {
        K::COMPILED
    }
    fn double(self: Box<Self>, arrays: &Arrays) -> Box<dyn Operation<f64>> {
        operation(*self, arrays)
    }
    fn single(self: Box<Self>, arrays: &Arrays) -> Box<dyn Operation<f32>> {
        operation(*self, arrays)
    }
    fn recorded(&self) -> Option<Plan> {
        Compile::recorded(self)
    }
    fn name(&self) -> &'static str {
        type_name::<K::Kernel>()
    }
}

/// A compiled kernel as an operation. A kernel that is replayed is not compiled.
fn operation<R: Real, K: Compile>(kernel: K, arrays: &Arrays) -> Box<dyn Operation<R>> {
    if const { K::COMPILED.is_replayed() } {
        unreachable!("a kernel that is replayed was compiled");
    } else {
        kernel.operation(arrays)
    }
}

/// A kernel that is mapped over elements.
pub(super) struct OfElements<K, const I: usize, const O: usize>(pub(super) K);

impl<K: Kernel<I, O>, const I: usize, const O: usize> Compile for OfElements<K, I, O> {
    type Kernel = K;
    const COMPILED: Compiled = K::COMPILED;
    fn operation<R: Real>(self, arrays: &Arrays) -> Box<dyn Operation<R>> {
        let (inputs, outputs) = (handles(&arrays.inputs), handles(&arrays.outputs));
        Box::new(InLanes(Map::new(self.0, inputs, &arrays.uniforms, outputs)))
    }
    fn recorded(&self) -> Option<Plan> {
        recorded(&self.0)
    }
}

/// A kernel that is mapped over edges. Its first `C` inputs are differences of node values. `SUMS` is [`Edges::sums`].
pub(super) struct OfEdges<K, const C: usize, const I: usize, const O: usize, const SUMS: bool>(
    pub(super) K,
);

impl<K, const C: usize, const I: usize, const O: usize, const SUMS: bool> Compile
    for OfEdges<K, C, I, O, SUMS>
where
    K: Kernel<I, O>,
{
    type Kernel = K;
    const COMPILED: Compiled = K::COMPILED;
    fn operation<R: Real>(self, arrays: &Arrays) -> Box<dyn Operation<R>> {
        let edges = arrays
            .edges
            .as_ref()
            .expect("the kernel is mapped over edges");
        Box::new(InLanes(EdgeMap::<R, K, C, I, O, SUMS>::new(
            self.0,
            &edges.graph.side_by_side(edges.starts),
            handles(&arrays.inputs),
            &arrays.uniforms,
            handles(&arrays.outputs),
        )))
    }
    fn recorded(&self) -> Option<Plan> {
        recorded(&self.0)
    }
}

/// Converts handles to an array. There is one for each input or result of a kernel.
pub(super) fn handles<const N: usize>(handles: &[Array]) -> [Array; N] {
    std::array::from_fn(|k| handles[k])
}
