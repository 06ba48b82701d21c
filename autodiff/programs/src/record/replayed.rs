//! Kernels as recordings, which can be replayed for any number type.

use std::borrow::Cow;

use autodiff::{Dual, Real};

use super::replay::{Plan, PointInputs, Points, Replayed, Wanted};
use super::symbol::Symbol;
use crate::arrays::{Array, Bars, Graph, Kernel, Operation, SlotEdge, StepValues};

/// Records a kernel. Returns `None` if the kernel asks for values or calls a function with its own derivative, because a
/// recording cannot represent it.
pub(crate) fn recorded<K: Kernel<I, O>, const I: usize, const O: usize>(
    kernel: &K,
) -> Option<Plan> {
    let code =
        |x: &[Symbol], given: &[Symbol]| kernel.eval(std::array::from_fn(|k| x[k]), given).to_vec();
    if const { K::COMPILED.is_replayed() } {
        Plan::record_simplified([I, K::UNIFORMS], code)
    } else {
        Plan::record([I, K::UNIFORMS], code)
    }
}

/// The elements or edges to which a kernel is applied.
pub enum Places {
    /// This many elements of arrays of equal length.
    Elements(usize),
    /// The edges of a graph; see [`Program::map_edges`](crate::Program::map_edges).
    Edges {
        edges: Vec<SlotEdge>,
        /// The number of inputs that are differences of node values. They come first.
        differences: usize,
        /// Whether results are summed at the nodes; otherwise they stay at the edges.
        sums: bool,
        /// The ends of all edges. For each end: the node, the edge, and whether the node is the edge's tail. The list
        /// is ordered by node. The edges of a node have the order in which lanes sum them.
        ends: Vec<(usize, usize, bool)>,
    },
}

impl Places {
    pub(crate) fn elements(outputs: &[Array]) -> Self {
        Self::Elements(outputs.first().map_or(0, |array| array.len()))
    }

    pub(crate) fn edges(graph: &Graph, differences: usize, sums: bool) -> Self {
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
            sums,
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

/// A recorded kernel that is mapped over arrays or over the edges of a graph.
pub struct ReplayedKernel {
    pub(crate) kernel: Plan,
    pub places: Places,
    pub inputs: Vec<Array>,
    pub uniforms: Vec<Array>,
    /// The output arrays, adjacent in memory.
    pub outputs: Vec<Array>,
    active: Vec<bool>,
    active_uniforms: Vec<bool>,
}

impl ReplayedKernel {
    pub(crate) fn new(
        kernel: Plan,
        places: Places,
        inputs: &[Array],
        uniforms: &[Array],
        outputs: &[Array],
    ) -> Self {
        Self {
            kernel,
            places,
            inputs: inputs.to_vec(),
            uniforms: uniforms.to_vec(),
            outputs: outputs.to_vec(),
            active: vec![true; inputs.len()],
            active_uniforms: vec![true; uniforms.len()],
        }
    }

    /// The number of starts (initial states) that run at once. Each is replayed alone, so that its bits do not depend on
    /// the others. Without elements or edges there is nothing to replay for any of them.
    fn starts(&self) -> usize {
        let starts = self.outputs.first().map_or(1, |array| array.starts);
        if self.places.count() == 0 { 0 } else { starts }
    }

    /// The values of each input at all elements or edges of one start. An input that no result depends on is zero.
    fn columns<'a, R: Real>(&self, values: StepValues<'a, R>, start: usize) -> Vec<Cow<'a, [R]>> {
        let starts = self.starts();
        let column = |(k, &input): (usize, &Array)| -> Cow<'a, [R]> {
            let array = &values.get(input)[start..];
            let at = |place: usize| array[place * starts];
            if !self.kernel.reads(k) {
                return vec![R::zero(); self.places.count()].into();
            }
            match &self.places {
                Places::Elements(_) if starts == 1 => array.into(),
                Places::Elements(count) => (0..*count).map(at).collect(),
                Places::Edges {
                    edges, differences, ..
                } if k < *differences => (edges.iter())
                    .map(|edge| at(edge.head) - at(edge.tail))
                    .collect(),
                Places::Edges { edges, .. } => edges.iter().map(|edge| at(edge.slot)).collect(),
            }
        };
        self.inputs.iter().enumerate().map(column).collect()
    }

    /// The values of the uniform inputs of one start.
    fn shared<R: Real>(&self, values: StepValues<R>, start: usize) -> Vec<R> {
        let of_start = |&array: &Array| {
            let numbers = values.get(array);
            numbers[start % numbers.len()]
        };
        self.uniforms.iter().map(of_start).collect()
    }

    /// Replays the kernel with its inputs at all elements or edges of one start.
    fn replay<R: Real>(
        &self,
        values: StepValues<R>,
        start: usize,
        wanted: Wanted<R>,
    ) -> Replayed<R> {
        let columns = self.columns(values, start);
        let columns: Vec<&[R]> = columns.iter().map(|column| &column[..]).collect();
        let points = Points {
            plan: &self.kernel,
            shared: &self.shared(values, start),
            count: self.places.count(),
            inputs: PointInputs::Numbers(&columns),
            wanted,
        };
        points.replay()
    }

    /// The cotangents of each result at all elements or edges of one start.
    fn seeds<R: Real>(&self, start: usize, bars: &mut Bars<R>) -> Vec<Vec<R>> {
        let starts = self.starts();
        let seed = |&output: &Array| -> Vec<R> {
            let bar = &bars.get_mut(output)[start..];
            let at = |place: usize| bar[place * starts];
            match &self.places {
                Places::Elements(count) => (0..*count).map(at).collect(),
                Places::Edges {
                    sums: false, edges, ..
                } => edges.iter().map(|edge| at(edge.slot)).collect(),
                // A result was added at the tail and subtracted at the head, so its cotangent is the tail's minus the
                // head's.
                Places::Edges { edges, .. } => {
                    let edges = edges.iter();
                    edges.map(|edge| at(edge.tail) - at(edge.head)).collect()
                }
            }
        };
        self.outputs.iter().map(seed).collect()
    }

    /// Adds the cotangents of the inputs at all elements or edges of one start.
    fn reverse_start<R: Real>(&self, start: usize, values: StepValues<R>, bars: &mut Bars<R>) {
        let (starts, seeds) = (self.starts(), self.seeds(start, bars));
        let replayed = self.replay(values, start, Wanted::ByInputs(Some(&seeds)));
        let by_uniforms = self.uniforms.iter().zip(&replayed.by_shared);
        for ((&uniform, &bar), active) in by_uniforms.zip(&self.active_uniforms) {
            if *active {
                let to = bars.get_mut(uniform);
                to[start % to.len()] += bar;
            }
        }
        for (k, (&input, x_bar)) in self.inputs.iter().zip(&replayed.by_inputs).enumerate() {
            if !self.active[k] {
                continue;
            }
            let to = &mut bars.get_mut(input)[start..];
            match &self.places {
                Places::Elements(_) => {
                    let to = to.iter_mut().step_by(starts);
                    to.zip(x_bar).for_each(|(to, &bar)| *to += bar);
                }
                Places::Edges {
                    ends, differences, ..
                } if k < *differences => {
                    for &(node, edge, is_tail) in ends {
                        if is_tail {
                            to[node * starts] -= x_bar[edge];
                        } else {
                            to[node * starts] += x_bar[edge];
                        }
                    }
                }
                Places::Edges { edges, .. } => {
                    let edges = edges.iter().zip(x_bar);
                    edges.for_each(|(edge, &bar)| to[edge.slot * starts] += bar);
                }
            }
        }
    }

    /// Adds the cotangents of the uniform inputs.
    pub(super) fn add_uniform_bars<R: Real>(&self, values: StepValues<R>, bars: &mut Bars<R>) {
        (0..self.starts()).for_each(|start| self.add_uniform_bars_of(start, values, bars));
    }

    /// Adds the cotangents of the uniform inputs of one start, one element or edge at a time. They come from dual numbers,
    /// so they do not depend on the number of lanes.
    fn add_uniform_bars_of<R: Real>(
        &self,
        start: usize,
        values: StepValues<R>,
        bars: &mut Bars<R>,
    ) {
        let (columns, seeds) = (self.columns(values, start), self.seeds(start, bars));
        let shared = self.shared(values, start).into_iter();
        let mut shared: Vec<Dual<R, 1>> = shared.map(Dual::constant).collect();
        for place in 0..self.places.count() {
            let x = columns.iter().map(|column| Dual::constant(column[place]));
            let x: Vec<Dual<R, 1>> = x.collect();
            for (k, &uniform) in self.uniforms.iter().enumerate() {
                if !self.active_uniforms[k] {
                    continue;
                }
                shared[k].tangent = [R::one()];
                let y = self.kernel.evaluate(&x, &shared);
                shared[k].tangent = [R::zero()];
                let results = y.iter().zip(&seeds);
                let bar = results.fold(R::zero(), |sum, (y, seeds)| {
                    R::chain_add(y.tangent[0], seeds[place], sum)
                });
                let to = bars.get_mut(uniform);
                to[start % to.len()] += bar;
            }
        }
    }
}

impl<R: Real> Operation<R> for ReplayedKernel {
    fn outputs(&self) -> Vec<Array> {
        self.outputs.clone()
    }

    fn forward(&mut self, parameters: &[R], row: &mut [R]) {
        let starts = self.starts();
        if let Places::Edges { .. } = self.places {
            let outputs = self.outputs.iter();
            outputs.for_each(|output| row[output.range()].fill(R::zero()));
        }
        for start in 0..starts {
            let values = StepValues { parameters, row };
            let all = self.replay(values, start, Wanted::Results).results;
            for (&output, results) in self.outputs.iter().zip(&all) {
                let to = &mut row[output.range()][start..];
                match &self.places {
                    Places::Elements(_) => {
                        let to = to.iter_mut().step_by(starts);
                        to.zip(results).for_each(|(to, &result)| *to = result);
                    }
                    Places::Edges {
                        sums: false, edges, ..
                    } => {
                        let edges = edges.iter().zip(results);
                        edges.for_each(|(edge, &result)| to[edge.slot * starts] = result);
                    }
                    Places::Edges { ends, .. } => {
                        for &(node, edge, is_tail) in ends {
                            if is_tail {
                                to[node * starts] += results[edge];
                            } else {
                                to[node * starts] -= results[edge];
                            }
                        }
                    }
                }
            }
        }
    }

    fn reverse(&mut self, values: &StepValues<R>, bars: &mut Bars<R>) {
        for start in 0..self.starts() {
            self.reverse_start(start, *values, bars);
        }
    }

    fn set_active(&mut self, arrays: &[bool], _parameters: &[bool]) -> bool {
        let active = |of: &[Array]| of.iter().map(|array| arrays[array.id]).collect();
        self.active = active(&self.inputs);
        for (k, active) in self.active.iter_mut().enumerate() {
            *active &= self.kernel.reads(k);
        }
        self.active_uniforms = active(&self.uniforms);
        self.active.contains(&true) || self.active_uniforms.contains(&true)
    }
}
