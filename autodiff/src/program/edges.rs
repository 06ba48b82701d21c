//! A kernel mapped over the edges of a graph, its results summed up at their nodes.
#![allow(unsafe_code)] // Unchecked loads: see `Lane::load_at`.

use super::graph::{Graph, Group};
use super::row::Frame;
use super::{Aligned, Array, Bars, Operation, WIDEST, lanes};
use crate::kernel::Adjoint;
use crate::lanes::{Lane, Vectorized};
use crate::real::Real;

/// The kernel's inputs are the `C` differences head less tail, then what is given per edge; its
/// `O` results count plus at the tail and minus at the head.
///
/// Lanes reach past a group's edges, and past the nodes: what they read there is masked.
pub(super) struct EdgeMap<R, K, const C: usize, const I: usize, const O: usize> {
    kernel: K,
    graph: Graph,
    masks: Vec<Masks>,
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

/// For a group of edges, a word of bits per lane: which slots hold edges; which nodes are tails,
/// and which are heads.
struct Masks {
    slots: Vec<u16>,
    nodes: Vec<[u16; 2]>,
}

impl Masks {
    fn new(group: &Group, lanes: usize) -> Self {
        let [mut slots, heads] = [&group.is_tail, &group.is_head].map(|bits| bits.by_lanes(lanes));
        let nodes = slots
            .iter()
            .zip(heads)
            .map(|(&tail, head)| [tail, head])
            .collect();
        slots.truncate(group.len / lanes);
        Self { slots, nodes }
    }
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
            masks: graph
                .groups()
                .iter()
                .map(|g| Masks::new(g, lanes::<R>()))
                .collect(),
            graph: graph.clone(),
            ends,
            per_edge_active: vec![true; per_edge.len()],
            per_edge: per_edge.to_vec(),
            sums,
            scratch: (0..C.max(O)).map(|_| Aligned::zeros(room)).collect(),
            ends_active: true,
        }
    }
}

/// What the edges of one group read: one slice each, all as long as the group.
struct Sources<'a, R, const C: usize, const I: usize> {
    tails: [&'a [R]; C],
    heads: [&'a [R]; C],
    /// The last `I - C` of these are used.
    per_edge: [&'a [R]; I],
}

impl<'a, R: Real, const C: usize, const I: usize> Sources<'a, R, C, I> {
    #[inline(always)]
    fn new(values: Frame<'a, R>, ends: &[Array; C], per_edge: &[Array], group: &Group) -> Self {
        let nothing = &values.row[..0];
        let mut sources = Self {
            tails: [nothing; C],
            heads: [nothing; C],
            per_edge: [nothing; I],
        };
        for c in 0..C {
            let part = values.part(ends[c]);
            sources.tails[c] = &part[ends[c].start..][..group.len];
            sources.heads[c] = &part[ends[c].start + group.offset..][..group.len];
        }
        for k in C..I {
            let array = per_edge[k - C];
            sources.per_edge[k] =
                &values.part(array)[array.start + group.first_slot..][..group.len];
        }
        sources
    }

    /// The kernel's inputs for the lane of edges from `i` on.
    ///
    /// # Safety
    /// The group has `i + N` slots.
    #[inline(always)]
    unsafe fn load<L: Lane<R>>(&self, i: usize, edges: L::Mask) -> [L; I] {
        let mut x = [L::zero(); I];
        for c in 0..C {
            // SAFETY, here and below: every slice is as long as the group.
            let stretch = unsafe { L::load_at(self.heads[c], i) - L::load_at(self.tails[c], i) };
            x[c] = L::select(edges, stretch, L::zero());
        }
        for k in C..I {
            x[k] = unsafe { L::load_at(self.per_edge[k], i) };
        }
        x
    }
}

impl<R, K, const C: usize, const I: usize, const O: usize> Operation<R> for EdgeMap<R, K, C, I, O>
where
    R: Real,
    K: Adjoint<I, O>,
{
    fn outputs(&self) -> Vec<Array> {
        self.sums.to_vec()
    }
    fn forward(&mut self, parameters: &[R], row: &mut [R]) {
        R::vectorize(Forward {
            map: self,
            parameters,
            row,
        });
    }
    fn reverse(&mut self, values: Frame<R>, bars: &mut Bars<R>) {
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
    parameters: &'a [R],
    row: &'a mut [R],
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
        let Self {
            map,
            parameters,
            row,
        } = self;
        let values = Frame { parameters, row };
        let lead = map.graph.lead();
        for (group, masks) in map.graph.groups().iter().zip(&map.masks) {
            let sources = Sources::<R, C, I>::new(values, &map.ends, &map.per_edge, group);
            let mut results: [&mut [R]; O] = std::array::from_fn(|_| Default::default());
            for (result, scratch) in results.iter_mut().zip(&mut map.scratch) {
                *result = &mut scratch[lead + group.first_slot..][..group.len];
            }
            assert_eq!(
                masks.slots.len() * L::N,
                group.len,
                "masks of another width"
            );
            for (lane, &bits) in masks.slots.iter().enumerate() {
                if bits == 0 {
                    continue;
                }
                let i = lane * L::N;
                // SAFETY: a group has as many lanes as masks; the slices are as long as it.
                unsafe {
                    let y = map.kernel.eval(sources.load::<L>(i, L::mask(bits)));
                    for o in 0..O {
                        y[o].store_at(results[o], i);
                    }
                }
            }
        }
        for o in 0..O {
            let nodes = &mut row[map.sums[o].range()];
            let edges = (&map.graph, &map.masks[..], &map.scratch[o][..]);
            collect_all::<R, L>(edges, nodes, Sum::Set);
        }
    }
}

struct Reverse<'a, 'b, R, K, const C: usize, const I: usize, const O: usize> {
    map: &'a mut EdgeMap<R, K, C, I, O>,
    values: Frame<'a, R>,
    bars: &'a mut Bars<'b, R>,
}

impl<R, K, const C: usize, const I: usize, const O: usize> Vectorized<R>
    for Reverse<'_, '_, R, K, C, I, O>
where
    R: Real,
    K: Adjoint<I, O>,
{
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        let Self { map, values, bars } = self;
        for (group, masks) in map.graph.groups().iter().zip(&map.masks) {
            let sources = Sources::<R, C, I>::new(values, &map.ends, &map.per_edge, group);
            let place = map.graph.lead() + group.first_slot;
            let mut ends_bar: [&mut [R]; C] = std::array::from_fn(|_| Default::default());
            for (bar, scratch) in ends_bar.iter_mut().zip(&mut map.scratch) {
                *bar = &mut scratch[place..][..group.len];
            }
            let mut sums = [0; O];
            for o in 0..O {
                sums[o] = map.sums[o].start;
                let reach = sums[o] + group.offset + group.len;
                assert!(reach <= bars.row.len(), "sums outside their row");
            }
            let mut wanted = [None; I];
            for k in C..I {
                let (array, active) = (map.per_edge[k - C], map.per_edge_active[k - C]);
                let first = array.start + group.first_slot;
                let fits = first + group.len <= bars.part(array).len();
                assert!(fits, "slots outside their part");
                wanted[k] = active.then_some((array, first));
            }
            assert_eq!(
                masks.slots.len() * L::N,
                group.len,
                "masks of another width"
            );
            for (lane, &bits) in masks.slots.iter().enumerate() {
                if bits == 0 {
                    continue;
                }
                let (i, edges) = (lane * L::N, L::mask(bits));
                // SAFETY: a group has as many lanes as masks; what is read and written was
                // checked to hold the whole group.
                unsafe {
                    let mut y_bar = [L::zero(); O];
                    for o in 0..O {
                        let head = L::load_at(bars.row, sums[o] + i + group.offset);
                        let tail_less_head = L::load_at(bars.row, sums[o] + i) - head;
                        y_bar[o] = L::select(edges, tail_less_head, L::zero());
                    }
                    let x_bar = map.kernel.vjp(sources.load::<L>(i, edges), y_bar);
                    for c in 0..C {
                        x_bar[c].store_at(ends_bar[c], i);
                    }
                    for k in C..I {
                        if let Some((array, first)) = wanted[k] {
                            let part = bars.part_mut(array);
                            (L::load_at(part, first + i) + x_bar[k]).store_at(part, first + i);
                        }
                    }
                }
            }
        }
        if map.ends_active {
            for c in 0..C {
                let nodes = bars.get_mut(map.ends[c]);
                let edges = (&map.graph, &map.masks[..], &map.scratch[c][..]);
                collect_all::<R, L>(edges, nodes, Sum::Subtract);
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

/// A graph, its masks, and values per slot.
type Edges<'a, R> = (&'a Graph, &'a [Masks], &'a [R]);

/// Per node the sum over its edges, plus where it is the tail and minus where it is the head.
#[inline(always)]
fn collect_all<R: Real, L: Lane<R>>(edges: Edges<R>, nodes: &mut [R], mut sum: Sum) {
    let groups = edges.0.groups().len();
    let mut first = 0;
    while first < groups {
        match groups - first {
            1 => collect::<R, L, 1>(edges, first, nodes, sum),
            2 => collect::<R, L, 2>(edges, first, nodes, sum),
            3 => collect::<R, L, 3>(edges, first, nodes, sum),
            _ => collect::<R, L, 4>(edges, first, nodes, sum),
        }
        first += 4;
        if let Sum::Set = sum {
            sum = Sum::Add;
        }
    }
}

/// The same for `G` groups from the `first` on: the four of a lattice are summed up in a
/// register.
#[inline(always)]
fn collect<R: Real, L: Lane<R>, const G: usize>(
    (graph, masks, slots): Edges<R>,
    first: usize,
    nodes: &mut [R],
    sum: Sum,
) {
    let whole = nodes.len().next_multiple_of(L::N);
    let (mut as_tail, mut as_head) = ([slots; G], [slots; G]);
    let mut bits: [&[[u16; 2]]; G] = [&[]; G];
    for g in 0..G {
        let group = &graph.groups()[first + g];
        let place = graph.lead() + group.first_slot;
        as_tail[g] = &slots[place..][..whole];
        as_head[g] = &slots[place - group.offset..][..whole];
        bits[g] = &masks[first + g].nodes[..whole / L::N];
    }
    for k in 0..whole / L::N {
        let i = k * L::N;
        let mut total = L::zero();
        for g in 0..G {
            let [tail, head] = [L::mask(bits[g][k][0]), L::mask(bits[g][k][1])];
            // SAFETY: the slices hold all whole lanes.
            let (as_tail, as_head) =
                unsafe { (L::load_at(as_tail[g], i), L::load_at(as_head[g], i)) };
            total += L::select(tail, as_tail, L::zero());
            total -= L::select(head, as_head, L::zero());
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
