//! Kernels as lists of operations, which any number type runs.

use std::any::type_name;

use super::arithmetic::{binary, holds, logic, number, unary};
use super::operation::{Op, Place, Run};
use super::recording::{Recording, record};
use super::symbol::Symbol;
use crate::arrays::{Array, Bars, Graph, Kernel, Operation, Pullback, SlotEdge, StepValues};
use crate::real::{Mask, Real};

/// The operations of some generic code, and the places of its results among them.
struct List {
    ops: Vec<Op>,
    results: Vec<Place>,
}

impl List {
    /// # Panics
    /// If the code of the kernel `K` asks for values, or calls a function whose derivative is its own:
    /// then the operations do not stand for it.
    fn of<K>(inputs: usize, code: impl FnOnce(&[Symbol]) -> Vec<Symbol>) -> Self {
        let (results, recording) = record(Recording::default(), || {
            let x: Vec<Symbol> = (0..inputs).map(Symbol::input).collect();
            code(&x)
        });
        assert!(
            !recording.unfit,
            "the kernel {} asks whether a number is zero or a mask holds, or calls a fused function: \
             from an `AnyProgram` it runs on f64 and f32 alone",
            type_name::<K>()
        );
        Self {
            ops: recording.ops,
            results: results.iter().map(|symbol| symbol.0).collect(),
        }
    }

    /// The results at `x`; `values` is working memory.
    fn run<R: Real>(&self, x: &[R], values: &mut Vec<R>) -> impl Iterator<Item = R> {
        values.clear();
        for &op in &self.ops {
            let at = |place: Place| values[place.at()];
            let several =
                |run: Run, len: u32| (0..len).map(|j| at(run.at(j as usize))).collect::<Vec<R>>();
            let value = match op {
                Op::Input(index) => x[index as usize],
                Op::Constant(bits) => R::lit(f64::from_bits(bits)),
                Op::Always(is_true) => number(R::Mask::splat(is_true)),
                Op::Unary(f, x) => unary(f, at(x)).0,
                Op::Binary(f, [a, b]) => binary(f, at(a), at(b)).0,
                Op::Logic(f, [a, b]) => logic(f, at(a), at(b)),
                Op::Fma([a, b, c]) => at(a).fma(at(b), at(c)),
                Op::Select(mask, [a, b]) => R::select(holds(at(mask)), at(a), at(b)),
                Op::Dot([a, b], len) => R::dot(&several(a, len), &several(b, len)),
                Op::Sum(x, len) => R::sum_of(&several(x, len)),
            };
            values.push(value);
        }
        self.results.iter().map(|place| values[place.at()])
    }
}

/// A kernel and its adjoint as lists of operations.
pub(super) struct ListedKernel {
    eval: List,
    /// Its arguments are the kernel's inputs and, behind them, the cotangents of the results.
    vjp: List,
}

impl ListedKernel {
    pub(super) fn new<K: Kernel<I, O>, const I: usize, const O: usize>(kernel: &K) -> Self {
        let inputs = |x: &[Symbol]| std::array::from_fn::<_, I, _>(|k| x[k]);
        Self {
            eval: List::of::<K>(I, |x| kernel.eval(inputs(x)).to_vec()),
            vjp: List::of::<K>(I + O, |x| {
                let (x, y_bar) = (inputs(x), std::array::from_fn(|k| x[I + k]));
                kernel.vjp(Pullback::new(kernel, x, [y_bar])).concat()
            }),
        }
    }

    pub(super) fn results(&self) -> usize {
        self.eval.results.len()
    }
}

/// The elements or edges that a kernel is applied to.
pub(super) enum Points {
    /// Each element of arrays of one length.
    Elements(usize),
    /// The edges of a graph; see [`Program::map_edges`](crate::Program::map_edges).
    Edges {
        edges: Vec<SlotEdge>,
        /// How many inputs are differences of arrays over the nodes.
        differences: usize,
        /// For each node, where it is tail or head: the edge, and true for the tail. The order is that in
        /// which floats sum them up.
        ends: Vec<(usize, usize, bool)>,
    },
}

impl Points {
    pub(super) fn elements(outputs: &[Array]) -> Self {
        Self::Elements(outputs.first().map_or(0, |array| array.range().len()))
    }

    pub(super) fn edges(graph: &Graph, differences: usize) -> Self {
        let edges = graph.edges_by_slot();
        let mut ends = Vec::new();
        for group in edges.chunk_by(|a, b| a.head - a.tail == b.head - b.tail) {
            let first = ends.len() / 2;
            let of = |is_tail: bool| {
                let end = move |e: &SlotEdge| if is_tail { e.tail } else { e.head };
                let group = group.iter().enumerate();
                group.map(move |(k, edge)| (end(edge), first + k, is_tail))
            };
            let of_group: Vec<_> = of(true).chain(of(false)).collect();
            ends.extend(of_group);
        }
        ends.sort_by_key(|(node, ..)| *node);
        Self::Edges {
            edges,
            differences,
            ends,
        }
    }

    fn count(&self) -> usize {
        match self {
            Self::Elements(count) => *count,
            Self::Edges { edges, .. } => edges.len(),
        }
    }
}

/// A kernel by its operations, mapped over arrays or over the edges of a graph.
pub(super) struct Interpreted<R> {
    kernel: ListedKernel,
    points: Points,
    inputs: Vec<Array>,
    /// Adjacent, in this order.
    outputs: Vec<Array>,
    active: Vec<bool>,
    /// Working memory.
    values: Vec<R>,
}

impl<R: Real> Interpreted<R> {
    pub(super) fn new(
        kernel: ListedKernel,
        points: Points,
        inputs: &[Array],
        outputs: &[Array],
    ) -> Self {
        Self {
            kernel,
            points,
            inputs: inputs.to_vec(),
            outputs: outputs.to_vec(),
            active: vec![true; inputs.len()],
            values: Vec::new(),
        }
    }

    /// The kernel's inputs at a point.
    fn inputs_at(&self, point: usize, values: StepValues<R>, x: &mut Vec<R>) {
        x.clear();
        for (k, &input) in self.inputs.iter().enumerate() {
            let array = values.get(input);
            x.push(match &self.points {
                Points::Elements(_) => array[point],
                Points::Edges {
                    edges, differences, ..
                } if k < *differences => array[edges[point].head] - array[edges[point].tail],
                Points::Edges { edges, .. } => array[edges[point].slot],
            });
        }
    }
}

impl<R: Real> Operation<R> for Interpreted<R> {
    fn outputs(&self) -> Vec<Array> {
        self.outputs.clone()
    }

    fn forward(&mut self, parameters: &[R], row: &mut [R]) {
        let mut memory = std::mem::take(&mut self.values);
        let (mut x, mut y) = (Vec::new(), Vec::new());
        let points = 0..self.points.count();
        for point in points.clone() {
            self.inputs_at(point, StepValues { parameters, row }, &mut x);
            y.extend(self.kernel.eval.run(&x, &mut memory));
        }
        for (o, output) in self.outputs.iter().enumerate() {
            let to = &mut row[output.range()];
            let result = |point: usize| y[point * self.outputs.len() + o];
            match &self.points {
                Points::Elements(_) => points.clone().for_each(|point| to[point] = result(point)),
                Points::Edges { ends, .. } => {
                    to.fill(R::zero());
                    for &(node, edge, is_tail) in ends {
                        if is_tail {
                            to[node] += result(edge);
                        } else {
                            to[node] -= result(edge);
                        }
                    }
                }
            }
        }
        self.values = memory;
    }

    fn reverse(&mut self, values: &StepValues<R>, bars: &mut Bars<R>) {
        let mut memory = std::mem::take(&mut self.values);
        let (mut x, mut x_bar) = (Vec::new(), Vec::new());
        for point in 0..self.points.count() {
            self.inputs_at(point, *values, &mut x);
            for &output in &self.outputs {
                let bar = &*bars.get_mut(output);
                x.push(match &self.points {
                    Points::Elements(_) => bar[point],
                    // A result was added at the tail and subtracted at the head.
                    Points::Edges { edges, .. } => bar[edges[point].tail] - bar[edges[point].head],
                });
            }
            x_bar.extend(self.kernel.vjp.run(&x, &mut memory));
        }
        for (k, &input) in self.inputs.iter().enumerate() {
            if !self.active[k] {
                continue;
            }
            let to = bars.get_mut(input);
            let bar = |point: usize| x_bar[point * self.inputs.len() + k];
            match &self.points {
                Points::Elements(count) => (0..*count).for_each(|point| to[point] += bar(point)),
                Points::Edges {
                    ends, differences, ..
                } if k < *differences => {
                    for &(node, edge, is_tail) in ends {
                        if is_tail {
                            to[node] -= bar(edge);
                        } else {
                            to[node] += bar(edge);
                        }
                    }
                }
                Points::Edges { edges, .. } => {
                    let edges = edges.iter().enumerate();
                    edges.for_each(|(e, edge)| to[edge.slot] += bar(e));
                }
            }
        }
        self.values = memory;
    }

    fn set_active(&mut self, arrays: &[bool], _parameters: &[bool]) {
        self.active = self.inputs.iter().map(|array| arrays[array.id()]).collect();
    }
}
