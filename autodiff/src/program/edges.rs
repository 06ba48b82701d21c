//! A kernel mapped over the edges of a graph, its results summed up at their nodes.

use super::graph::{Graph, Group};
use super::{Aligned, Array, Operation, WIDEST};
use crate::kernel::Adjoint;
use crate::lanes::{Lane, Vectorized};
use crate::real::Real;

/// The kernel's inputs are the `C` differences head less tail, then what is given per edge; its
/// `O` results count plus at the tail and minus at the head.
pub(super) struct EdgeMap<R, K, const C: usize, const I: usize, const O: usize> {
    kernel: K,
    graph: Graph,
    /// Per node.
    ends: [Array; C],
    /// Per slot.
    per_edge: Vec<Array>,
    /// Per node.
    sums: [Array; O],
    /// Results, or cotangents of differences, per slot; with room for lanes that reach past.
    scratch: Vec<Aligned<R>>,
    ends_active: bool,
    per_edge_active: Vec<bool>,
}

impl<R: Real, K, const C: usize, const I: usize, const O: usize> EdgeMap<R, K, C, I, O> {
    pub(super) fn new(
        kernel: K,
        graph: &Graph,
        (ends, per_edge): ([Array; C], &[Array]),
        sums: [Array; O],
    ) -> Self {
        assert_eq!(
            C + per_edge.len(),
            I,
            "map_edges: the kernel has another number of inputs"
        );
        let room = graph.lead() + graph.slots() + graph.nodes() + WIDEST;
        Self {
            kernel,
            graph: graph.clone(),
            ends,
            per_edge_active: vec![true; per_edge.len()],
            per_edge: per_edge.to_vec(),
            sums,
            scratch: (0..C.max(O)).map(|_| Aligned::zeros(room)).collect(),
            ends_active: true,
        }
    }

    /// The kernel's inputs for a lane of edges. Lanes reach past a group's edges, and past the
    /// nodes: what they read there is passed on to nothing.
    #[inline(always)]
    fn inputs<L: Lane<R>>(&self, values: &[R], group: &Group, i: usize) -> [L; I] {
        let mut x = [L::zero(); I];
        for c in 0..C {
            x[c] = group
                .is_tail
                .keep::<R, L>(i, stretch(values, self.ends[c], group.offset + i, i));
        }
        for (k, array) in self.per_edge.iter().enumerate() {
            x[C + k] = L::load(&values[array.start + group.first_slot + i..]);
        }
        x
    }
}

/// Values of nodes from `head` on less those from `tail` on.
#[inline(always)]
fn stretch<R: Real, L: Lane<R>>(arena: &[R], nodes: Array, head: usize, tail: usize) -> L {
    L::load(&arena[nodes.start + head..]) - L::load(&arena[nodes.start + tail..])
}

impl<R, K, const C: usize, const I: usize, const O: usize> Operation<R> for EdgeMap<R, K, C, I, O>
where
    R: Real,
    K: Adjoint<I, O>,
{
    fn inputs(&self) -> Vec<Array> {
        [&self.ends[..], &self.per_edge].concat()
    }
    fn outputs(&self) -> Vec<Array> {
        self.sums.to_vec()
    }
    fn reverse_reads(&self) -> Vec<Array> {
        [&self.ends[..], &self.per_edge].concat()
    }
    fn forward(&mut self, values: &mut [R]) {
        R::vectorize(Forward { map: self, values });
    }
    fn reverse(&mut self, values: &[R], bars: &mut [R]) {
        R::vectorize(Reverse {
            map: self,
            values,
            bars,
        });
    }
    fn set_active(&mut self, arrays: &[bool], _parameters: &[bool]) {
        self.ends_active = self.ends.iter().any(|a| arrays[a.id]);
        self.per_edge_active = self.per_edge.iter().map(|a| arrays[a.id]).collect();
    }
}

struct Forward<'a, R, K, const C: usize, const I: usize, const O: usize> {
    map: &'a mut EdgeMap<R, K, C, I, O>,
    values: &'a mut [R],
}

impl<R, K, const C: usize, const I: usize, const O: usize> Vectorized<R>
    for Forward<'_, R, K, C, I, O>
where
    R: Real,
    K: Adjoint<I, O>,
{
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        let Self { map, values } = self;
        let graph = map.graph.clone();
        for group in graph.groups() {
            for i in (0..group.len).step_by(L::N) {
                let y = map.kernel.eval(map.inputs::<L>(values, group, i));
                for o in 0..O {
                    let slot = graph.lead() + group.first_slot + i;
                    y[o].store(&mut map.scratch[o][slot..]);
                }
            }
        }
        for o in 0..O {
            collect_all::<R, L>(
                &graph,
                &map.scratch[o],
                &mut values[map.sums[o].range()],
                Sum::Set,
            );
        }
    }
}

struct Reverse<'a, R, K, const C: usize, const I: usize, const O: usize> {
    map: &'a mut EdgeMap<R, K, C, I, O>,
    values: &'a [R],
    bars: &'a mut [R],
}

impl<R, K, const C: usize, const I: usize, const O: usize> Vectorized<R>
    for Reverse<'_, R, K, C, I, O>
where
    R: Real,
    K: Adjoint<I, O>,
{
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        let Self { map, values, bars } = self;
        let graph = map.graph.clone();
        for group in graph.groups() {
            for i in (0..group.len).step_by(L::N) {
                let x = map.inputs::<L>(values, group, i);
                let mut y_bar = [L::zero(); O];
                for o in 0..O {
                    let tail_less_head = -stretch::<R, L>(bars, map.sums[o], group.offset + i, i);
                    y_bar[o] = group.is_tail.keep::<R, L>(i, tail_less_head);
                }
                let x_bar = map.kernel.vjp(x, y_bar);
                let slot = group.first_slot + i;
                for c in 0..C {
                    x_bar[c].store(&mut map.scratch[c][graph.lead() + slot..]);
                }
                for (k, array) in map.per_edge.iter().enumerate() {
                    if map.per_edge_active[k] {
                        let bar = &mut bars[array.start + slot..];
                        (L::load(bar) + x_bar[C + k]).store(bar);
                    }
                }
            }
        }
        if map.ends_active {
            for c in 0..C {
                let bars = &mut bars[map.ends[c].range()];
                collect_all::<R, L>(&graph, &map.scratch[c], bars, Sum::Subtract);
            }
        }
    }
}

/// What becomes of a node's sum.
#[derive(Clone, Copy)]
enum Sum {
    Set,
    Add,
    Subtract,
}

/// Per node the sum over its edges, plus where it is the tail and minus where it is the head.
#[inline(always)]
fn collect_all<R: Real, L: Lane<R>>(graph: &Graph, slots: &[R], nodes: &mut [R], mut sum: Sum) {
    for groups in graph.groups().chunks(4) {
        match groups.len() {
            1 => collect::<R, L, 1>((graph.lead(), groups), slots, nodes, sum),
            2 => collect::<R, L, 2>((graph.lead(), groups), slots, nodes, sum),
            3 => collect::<R, L, 3>((graph.lead(), groups), slots, nodes, sum),
            _ => collect::<R, L, 4>((graph.lead(), groups), slots, nodes, sum),
        }
        if let Sum::Set = sum {
            sum = Sum::Add;
        }
    }
}

/// The same for `G` groups: the four of a lattice are summed up in a register.
#[inline(always)]
fn collect<R: Real, L: Lane<R>, const G: usize>(
    (lead, groups): (usize, &[Group]),
    slots: &[R],
    nodes: &mut [R],
    sum: Sum,
) {
    let whole = nodes.len().next_multiple_of(L::N);
    let (mut as_tail, mut as_head) = ([slots; G], [slots; G]);
    for g in 0..G {
        let first = lead + groups[g].first_slot;
        as_tail[g] = &slots[first..][..whole];
        as_head[g] = &slots[first - groups[g].offset..][..whole];
    }
    for i in (0..nodes.len()).step_by(L::N) {
        let mut total = L::zero();
        for g in 0..G {
            total += groups[g].is_tail.keep::<R, L>(i, L::load(&as_tail[g][i..]));
            total -= groups[g].is_head.keep::<R, L>(i, L::load(&as_head[g][i..]));
        }
        let to = &mut nodes[i..];
        let result = match sum {
            Sum::Set => total,
            Sum::Add => L::load_up_to(to) + total,
            Sum::Subtract => L::load_up_to(to) - total,
        };
        result.store_up_to(to);
    }
}
