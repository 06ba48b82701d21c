//! Kernels as recordings, which can be replayed for any number type.

use std::borrow::Cow;

use super::replay::{Inputs, Plan, Points, Wanted};
use crate::arrays::{Array, Bars, Graph, Kernel, Operation, SlotEdge, StepValues, checked};
use crate::real::Real;

/// Records a kernel. Its uniform inputs are shared arguments of the recording, or with `by_element` further inputs. Returns
/// `None` if the kernel asks for values or calls a function with its own derivative, because a recording cannot represent
/// it.
pub(crate) fn recorded<K: Kernel<I, O>, const I: usize, const O: usize>(
    kernel: &K,
    by_element: bool,
) -> Option<Plan> {
    let numbers = match by_element {
        true => [I + K::UNIFORMS, 0],
        false => [I, K::UNIFORMS],
    };
    Plan::record(numbers, |x, shared| {
        let (x, further) = x.split_at(I);
        let uniforms = if by_element { further } else { shared };
        kernel
            .eval(std::array::from_fn(|k| x[k]), uniforms)
            .to_vec()
    })
}

/// The elements or edges to which a kernel is applied.
pub(crate) enum Places {
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
        Self::Elements(outputs.first().map_or(0, |array| array.range().len()))
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

    /// The start to which each element or edge belongs, of so many.
    fn starts(&self, starts: usize) -> impl Iterator<Item = usize> {
        let place = |k: usize| match self {
            Self::Elements(_) => k,
            Self::Edges { edges, .. } => edges[k].slot,
        };
        (0..self.count()).map(move |k| place(k) % starts)
    }

    fn count(&self) -> usize {
        match self {
            Self::Elements(count) => *count,
            Self::Edges { edges, .. } => edges.len(),
        }
    }
}

/// A recorded kernel that is mapped over arrays or over the edges of a graph.
pub(crate) struct ReplayedKernel {
    pub(crate) kernel: Plan,
    pub(crate) places: Places,
    pub(crate) inputs: Vec<Array>,
    pub(crate) uniforms: Vec<Array>,
    /// See [`recorded`]: whether the recording has the uniform inputs as further inputs.
    by_element: bool,
    /// The output arrays, adjacent in memory.
    pub(crate) outputs: Vec<Array>,
    active: Vec<bool>,
    active_uniforms: Vec<bool>,
}

impl ReplayedKernel {
    /// Returns `None` if `record` does, which is [`recorded`] with its second argument.
    pub(crate) fn new(
        record: impl FnOnce(bool) -> Option<Plan>,
        places: Places,
        inputs: &[Array],
        uniforms: &[Array],
        outputs: &[Array],
    ) -> Option<Self> {
        // Where several starts run at once, each has its own number.
        let by_element = checked(uniforms).iter().any(|array| array.len > 1);
        Some(Self {
            kernel: record(by_element)?,
            places,
            inputs: inputs.to_vec(),
            uniforms: uniforms.to_vec(),
            by_element,
            outputs: outputs.to_vec(),
            active: vec![true; inputs.len()],
            active_uniforms: vec![true; uniforms.len()],
        })
    }

    /// Calls `replay` with the recorded kernel and its inputs at all elements or edges.
    fn at_places<R: Real, T>(
        &self,
        values: StepValues<R>,
        wanted: Wanted<R>,
        replay: impl FnOnce(Points<R>) -> T,
    ) -> T {
        let column = |(k, &input): (usize, &Array)| -> Cow<[R]> {
            let array = values.get(input);
            match &self.places {
                Places::Elements(_) => array.into(),
                Places::Edges {
                    edges, differences, ..
                } if k < *differences => (edges.iter())
                    .map(|edge| array[edge.head] - array[edge.tail])
                    .collect(),
                Places::Edges { edges, .. } => edges.iter().map(|edge| array[edge.slot]).collect(),
            }
        };
        let mut columns: Vec<Cow<[R]>> = self.inputs.iter().enumerate().map(column).collect();
        let mut shared = Vec::new();
        for numbers in self.uniforms.iter().map(|&array| values.get(array)) {
            match self.by_element {
                true => columns.push(
                    (self.places.starts(numbers.len()))
                        .map(|s| numbers[s])
                        .collect(),
                ),
                false => shared.push(numbers[0]),
            }
        }
        let columns: Vec<&[R]> = columns.iter().map(|column| &column[..]).collect();
        replay(Points {
            plan: &self.kernel,
            shared: &shared,
            count: self.places.count(),
            inputs: Inputs::Numbers(&columns),
            wanted,
        })
    }
}

impl<R: Real> Operation<R> for ReplayedKernel {
    fn outputs(&self) -> Vec<Array> {
        self.outputs.clone()
    }

    fn forward(&mut self, parameters: &[R], row: &mut [R]) {
        let values = StepValues { parameters, row };
        let all = self.at_places(values, Wanted::Results, |points| points.replay().results);
        for (&output, results) in self.outputs.iter().zip(&all) {
            let to = &mut row[output.range()];
            match &self.places {
                Places::Elements(_) => to.copy_from_slice(results),
                Places::Edges {
                    sums: false, edges, ..
                } => {
                    to.fill(R::zero());
                    let edges = edges.iter().zip(results);
                    edges.for_each(|(edge, &result)| to[edge.slot] = result);
                }
                Places::Edges { ends, .. } => {
                    to.fill(R::zero());
                    for &(node, edge, is_tail) in ends {
                        if is_tail {
                            to[node] += results[edge];
                        } else {
                            to[node] -= results[edge];
                        }
                    }
                }
            }
        }
    }

    fn reverse(&mut self, values: &StepValues<R>, bars: &mut Bars<R>) {
        let seed = |&output: &Array| -> Vec<R> {
            let bar = &*bars.get_mut(output);
            match &self.places {
                Places::Elements(_) => bar.to_vec(),
                Places::Edges {
                    sums: false, edges, ..
                } => edges.iter().map(|edge| bar[edge.slot]).collect(),
                // A result was added at the tail and subtracted at the head, so its cotangent is the tail's minus the
                // head's.
                Places::Edges { edges, .. } => edges
                    .iter()
                    .map(|edge| bar[edge.tail] - bar[edge.head])
                    .collect(),
            }
        };
        let seeds: Vec<Vec<R>> = self.outputs.iter().map(seed).collect();
        let wanted = Wanted::ByInputs(Some(&seeds));
        let replayed = self.at_places(*values, wanted, |points| points.replay());
        for (k, &uniform) in self.uniforms.iter().enumerate() {
            if !self.active_uniforms[k] {
                continue;
            }
            let to = bars.get_mut(uniform);
            if !self.by_element {
                to[0] += replayed.by_shared[k];
                continue;
            }
            let by_element = &replayed.by_inputs[self.inputs.len() + k];
            for (start, &bar) in self.places.starts(to.len()).zip(by_element) {
                to[start] += bar;
            }
        }
        for (k, (&input, x_bar)) in self.inputs.iter().zip(&replayed.by_inputs).enumerate() {
            if !self.active[k] {
                continue;
            }
            let to = bars.get_mut(input);
            match &self.places {
                Places::Elements(_) => to.iter_mut().zip(x_bar).for_each(|(to, &bar)| *to += bar),
                Places::Edges {
                    ends, differences, ..
                } if k < *differences => {
                    for &(node, edge, is_tail) in ends {
                        if is_tail {
                            to[node] -= x_bar[edge];
                        } else {
                            to[node] += x_bar[edge];
                        }
                    }
                }
                Places::Edges { edges, .. } => {
                    let edges = edges.iter().zip(x_bar);
                    edges.for_each(|(edge, &bar)| to[edge.slot] += bar);
                }
            }
        }
    }

    fn set_active(&mut self, arrays: &[bool], _parameters: &[bool]) {
        let active = |of: &[Array]| of.iter().map(|array| arrays[array.id]).collect();
        self.active = active(&self.inputs);
        self.active_uniforms = active(&self.uniforms);
    }
}
