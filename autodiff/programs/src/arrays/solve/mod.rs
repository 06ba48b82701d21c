//! The solution of a system of linear equations whose matrix has the structure of a graph.
#![allow(unsafe_code)] // Unchecked loads: see `Unchecked::load_at`.

mod band;
mod held;
mod order;

use autodiff::Real;
use autodiff::internal::{Unchecked, WIDEST, lanes};
use autodiff::simd::{Lane, Vectorized};

use self::band::Band;
use super::array::Array;
use super::dense::Aligned;
use super::graph::{Graph, SlotEdge};
use super::operation::LaneOperation;
use super::row::{Bars, StepValues};

/// The rows and columns of the lower triangle of a block with `n` rows: `[0, 0], [1, 0], [1, 1], [2, 0], ...`.
pub(crate) fn triangle(n: usize) -> Vec<[usize; 2]> {
    let rows = 0..n;
    rows.flat_map(|row| (0..=row).map(move |column| [row, column]))
        .collect()
}

/// The largest number of unknowns per node if some directions are held.
pub(crate) const MOST_UNKNOWNS: usize = 4;

/// The declaration of linear equations in a step: see [`Program::solve`](crate::Program::solve).
pub struct Equations {
    pub(crate) graph: Graph,
    pub(crate) nodes: Vec<Array>,
    pub(crate) edges: Vec<Array>,
    pub(crate) held: Vec<Array>,
    pub(crate) b: Vec<Array>,
    /// The solution: an array for each unknown of a node.
    pub(crate) x: Vec<Array>,
}

/// Solves [`Equations`].
pub(crate) struct Solve<R> {
    entries: Vec<Entry>,
    edges: Vec<SlotEdge>,
    /// The edges of all starts.
    lanes: Vec<EdgeRegister>,
    /// For each of `lanes`, a register with 1 where it has an edge and 0 elsewhere.
    has_edge: Aligned<R>,
    /// The number of lanes of a register.
    width: usize,
    /// The number of slots.
    slots: usize,
    /// The projection of every node onto its held directions, as arrays of the lower triangle; empty if nothing is held.
    held: Vec<Array>,
    /// The nodes with a held direction in one of the starts.
    holds: Vec<bool>,
    /// The nodes among them whose held direction is not along an axis.
    is_oblique: Vec<bool>,
    /// For the nodes with a held direction and each start, the projection onto the free directions, row by row.
    free: Vec<R>,
    /// The right-hand side: an array for each unknown of a node.
    b: Vec<Array>,
    /// For each array of the right-hand side, whether it carries derivatives.
    is_active: Vec<bool>,
    outputs: Vec<Array>,
    /// For each node, the place of its first unknown in the order of elimination.
    places: Vec<usize>,
    starts: usize,
    band: Band,
    /// The matrix and then its factor. The reverse sweep computes it again, which takes less time than to load it.
    matrix: Aligned<R>,
    /// See [`Band::solve`].
    recent: Aligned<R>,
    /// The right-hand side and then the solution, in the order of elimination.
    side: Aligned<R>,
    /// The solution of the reverse sweep: an array for each unknown of a node.
    w: Vec<R>,
    /// An entry of the blocks in the diagonal, for each node. There is room for a register after the last node.
    sums: Aligned<R>,
}

/// An entry in the lower triangle of all blocks.
struct Entry {
    row: usize,
    column: usize,
    nodes: Array,
    edges: Array,
    /// For each node, the index of its number in the matrix.
    of_nodes: Vec<usize>,
    /// The slot of an edge, and the index of its number between its ends. The entries beside the diagonal of a block have
    /// two such numbers for each edge: the entry and its image above the diagonal.
    between: Vec<[usize; 2]>,
    /// Whether the arrays of nodes and of edges carry derivatives.
    is_active: [bool; 2],
}

/// The edges whose slots fill a register. In each lane, the slot and both ends are higher by one.
struct EdgeRegister {
    /// The slot and the ends of lane 0.
    slot: usize,
    tail: usize,
    head: usize,
    /// The number of lanes, up to the last one with an edge.
    n: usize,
}

impl EdgeRegister {
    /// Adds the numbers of the edges to the `sums` from number `at` on. `has_edge` is not 0 in lanes with an edge.
    ///
    /// # Safety
    /// The numbers of the edges must reach to the last edge, and the sums must have a whole register from `at` on.
    #[inline(always)]
    unsafe fn add<R: Real, L: Lane<R>>(
        &self,
        has_edge: &[R],
        of_edges: &[R],
        sums: &mut [R],
        at: usize,
    ) {
        // SAFETY: guaranteed by the caller.
        unsafe {
            let of_edges = with_edge(has_edge, L::load_n(of_edges, self.slot, self.n));
            (L::load_at(sums, at) + of_edges).store_at(sums, at);
        }
    }
}

/// The numbers of lanes with an edge; the other lanes are zero.
#[inline(always)]
fn with_edge<R: Real, L: Lane<R>>(has_edge: &[R], numbers: L) -> L {
    L::select(L::zero().less(L::load(has_edge)), numbers, L::zero())
}

/// Divides the edges of a graph into registers of `lanes` lanes. Also returns for each lane whether it has an edge.
fn lanes_of(graph: &Graph, lanes: usize) -> (Vec<EdgeRegister>, Vec<bool>) {
    let (mut all, mut has_edge): (Vec<EdgeRegister>, Vec<bool>) = Default::default();
    for SlotEdge { slot, tail, head } in graph.edges_by_slot() {
        let lane = slot % lanes;
        match all.last_mut() {
            Some(last) if last.slot == slot - lane => last.n = lane + 1,
            _ => {
                has_edge.resize(has_edge.len() + lanes, false);
                all.push(EdgeRegister {
                    slot: slot - lane,
                    tail: tail - lane,
                    head: head - lane,
                    n: lane + 1,
                });
            }
        }
        has_edge[(all.len() - 1) * lanes + lane] = true;
    }
    (all, has_edge)
}

impl<R: Real> Solve<R> {
    pub(crate) fn new(equations: Equations) -> Self {
        let Equations {
            graph,
            nodes,
            edges,
            held,
            b,
            x: outputs,
        } = equations;
        let (width, starts) = (lanes::<R>(), outputs[0].starts);
        assert!(
            starts <= width,
            "a register has one lane or more for each start"
        );
        let (lanes, is_edge) = lanes_of(&graph.side_by_side(starts), width);
        let mut has_edge = Aligned::zeros(is_edge.len());
        for (number, _) in has_edge
            .iter_mut()
            .zip(is_edge)
            .filter(|(_, is_edge)| *is_edge)
        {
            *number = R::one();
        }
        let edges_by_slot = graph.edges_by_slot();
        let pairs = edges_by_slot.iter().map(|edge| [edge.tail, edge.head]);
        let pairs: Vec<[usize; 2]> = pairs.collect();
        let (places, unknowns) = (order::places(graph.nodes(), &pairs), outputs.len());
        let beside = (order::bandwidth(&places, &pairs) + 1) * unknowns - 1;
        let band = Band::new(graph.nodes() * unknowns, beside);
        let places: Vec<usize> = places.iter().map(|place| place * unknowns).collect();
        let arrays = nodes.into_iter().zip(edges);
        let entry = |([row, column], (nodes, edges)): ([usize; 2], (Array, Array))| {
            let own = |place: &usize| band.index(place + column, place + row);
            let mut between = Vec::new();
            for edge in &edges_by_slot {
                let [a, b] = [edge.tail, edge.head].map(|node| places[node]);
                let (first, last) = (a.min(b), a.max(b));
                between.push([edge.slot, band.index(first + column, last + row)]);
                if row != column {
                    between.push([edge.slot, band.index(first + row, last + column)]);
                }
            }
            Entry {
                row,
                column,
                nodes,
                edges,
                of_nodes: places.iter().map(own).collect(),
                between,
                is_active: [true; 2],
            }
        };
        Self {
            entries: triangle(unknowns)
                .into_iter()
                .zip(arrays)
                .map(entry)
                .collect(),
            lanes,
            has_edge,
            width,
            edges: edges_by_slot,
            slots: graph.slots(),
            held,
            holds: vec![false; graph.nodes()],
            is_oblique: vec![false; graph.nodes()],
            free: vec![R::zero(); graph.nodes() * starts * unknowns * unknowns],
            is_active: vec![true; b.len()],
            b,
            outputs,
            matrix: Aligned::zeros(band.len() * starts),
            recent: Aligned::zeros(band.len_of_recent() * starts),
            side: Aligned::zeros(band.len_of_side() * starts),
            sums: Aligned::zeros(graph.nodes() * starts + WIDEST),
            w: vec![R::zero(); unknowns * graph.nodes() * starts],
            places,
            starts,
            band,
        }
    }

    /// # Panics
    /// If a register does not have as many lanes as when this operation was created.
    #[inline(always)]
    fn check_width(&self, lanes: usize) {
        assert_eq!(
            lanes, self.width,
            "the number type changed its number of lanes; it must stay the same"
        );
    }

    /// Computes the matrix. `T` is a register that holds one number of each start.
    #[inline(always)]
    fn set_matrix<L: Lane<R>, T: Lane<R>>(&mut self, starts: usize, values: StepValues<R>) {
        let matrix = &mut self.matrix[..];
        self.band.clear(starts, matrix);
        for entry in &self.entries {
            // SAFETY: the numbers of a graph's nodes and edges, and the entries of the matrix, are at the places that were
            // computed for this graph.
            unsafe {
                let of_edges = &values.get(entry.edges)[..self.slots * starts];
                let sums = &mut self.sums[..];
                sums[..entry.nodes.len].copy_from_slice(values.get(entry.nodes));
                // All tails and then all heads, because loads of what was just stored are slow.
                for k in 0..self.lanes.len() {
                    let lane = &self.lanes[k];
                    lane.add::<R, L>(&self.has_edge[k * L::N..], of_edges, sums, lane.tail);
                }
                for k in 0..self.lanes.len() {
                    let lane = &self.lanes[k];
                    lane.add::<R, L>(&self.has_edge[k * L::N..], of_edges, sums, lane.head);
                }
                for node in 0..entry.of_nodes.len() {
                    let sum = T::load_n(sums, node * starts, starts);
                    sum.store_n(matrix, entry.of_nodes[node] * starts, starts);
                }
                for &[slot, index] in &entry.between {
                    // Unlike a negation, this difference is never -0.
                    let number = T::zero() - T::load_n(of_edges, slot * starts, starts);
                    number.store_n(matrix, index * starts, starts);
                }
            }
        }
        self.hold_matrix(starts, values);
    }

    /// Copies one unknown of all nodes of the right-hand side.
    #[inline(always)]
    fn set_side<T: Lane<R>>(&mut self, starts: usize, unknown: usize, b: &[R]) {
        let (side, places) = (&mut self.side[..], &self.places[..]);
        for node in 0..places.len() {
            let number: T = part(b, node * starts, starts);
            number.store_up_to(&mut side[(places[node] + unknown) * starts..][..starts]);
        }
    }

    /// Replaces the right-hand side by the solution. It is not inlined, so that its long code exists once.
    #[inline(never)]
    fn solve(&mut self) {
        R::vectorize(InBand(self));
    }

    /// Copies one unknown of all nodes of the solution.
    #[inline(always)]
    fn copy_solution<T: Lane<R>>(&self, starts: usize, unknown: usize, x: &mut [R]) {
        let (side, places) = (&self.side[..], &self.places[..]);
        for node in 0..places.len() {
            let number: T = part(side, (places[node] + unknown) * starts, starts);
            number.store_up_to(&mut x[node * starts..][..starts]);
        }
    }

    /// Implements [`LaneOperation::forward_in`].
    #[inline(always)]
    fn forward_of<L: Lane<R>, T: Lane<R>>(
        &mut self,
        starts: usize,
        parameters: &[R],
        row: &mut [R],
    ) {
        self.check_width(L::N);
        let (values, all) = StepValues::and_outputs(parameters, row, &self.outputs);
        self.set_matrix::<L, T>(starts, values);
        for unknown in 0..self.b.len() {
            self.set_side::<T>(starts, unknown, values.get(self.b[unknown]));
        }
        self.hold_side(starts);
        self.solve();
        for unknown in 0..self.outputs.len() {
            let output = self.outputs[unknown];
            let x = &mut all[output.start - self.outputs[0].start..][..output.len];
            self.copy_solution::<T>(starts, unknown, x);
        }
    }

    /// Implements [`LaneOperation::reverse_in`]. The reverse of `A x = b` is one more solution with the same factor: with
    /// `A w = x_bar`, the cotangent of `b` is `w`, and that of `A` is `-w x'`. A block of an edge acts on the difference
    /// between its ends. Held directions are removed from `w`, as from `x`.
    #[inline(always)]
    fn reverse_of<L: Lane<R>, T: Lane<R>>(
        &mut self,
        starts: usize,
        values: StepValues<R>,
        bars: &mut Bars<R>,
    ) {
        self.check_width(L::N);
        self.set_matrix::<L, T>(starts, values);
        for unknown in 0..self.outputs.len() {
            self.set_side::<T>(starts, unknown, &bars.row[self.outputs[unknown].range()]);
        }
        self.solve();
        self.hold_side(starts);
        let len = self.places.len() * starts;
        let mut w = std::mem::take(&mut self.w);
        for unknown in 0..self.outputs.len() {
            self.copy_solution::<T>(starts, unknown, &mut w[unknown * len..][..len]);
        }
        for unknown in 0..self.b.len() {
            if self.is_active[unknown] {
                let w = &w[unknown * len..][..len];
                let bar = bars.get_mut(self.b[unknown]);
                for at in (0..len).step_by(L::N) {
                    let n = L::N.min(len - at);
                    let sum = part::<R, L>(bar, at, n) + part::<R, L>(w, at, n);
                    sum.store_up_to(&mut bar[at..at + n]);
                }
            }
        }
        for entry in &self.entries {
            let [a, b] = [entry.row, entry.column];
            let (w_a, w_b) = (&w[a * len..][..len], &w[b * len..][..len]);
            let (x_a, x_b) = (values.get(self.outputs[a]), values.get(self.outputs[b]));
            if entry.is_active[0] {
                let bar = bars.get_mut(entry.nodes);
                for at in (0..len).step_by(L::N) {
                    let n = L::N.min(len - at);
                    let w = [part::<R, L>(w_a, at, n), part(w_b, at, n)];
                    let x = [part(x_a, at, n), part(x_b, at, n)];
                    let rest = part::<R, L>(bar, at, n) - entry.product(w, x);
                    rest.store_up_to(&mut bar[at..at + n]);
                }
            }
            if entry.is_active[1] {
                let bar = bars.get_mut(entry.edges);
                for k in 0..self.lanes.len() {
                    let lane = &self.lanes[k];
                    let (n, ends) = (lane.n, [lane.tail, lane.head]);
                    let w = [difference::<R, L>(w_a, ends, n), difference(w_b, ends, n)];
                    let x = [difference(x_a, ends, n), difference(x_b, ends, n)];
                    let product =
                        with_edge::<R, L>(&self.has_edge[k * L::N..], entry.product(w, x));
                    let bar = &mut bar[lane.slot..][..n];
                    (part::<R, L>(bar, 0, n) - product).store_up_to(bar);
                }
            }
        }
        self.w = w;
    }
}

/// Loads `n` numbers from index `at` on. The other lanes are zero.
#[inline(always)]
fn part<R: Real, L: Lane<R>>(numbers: &[R], at: usize, n: usize) -> L {
    L::load_up_to(&numbers[at..at + n])
}

/// The differences between `n` numbers at heads and at tails, where adjacent edges begin at the two ends.
#[inline(always)]
fn difference<R: Real, L: Lane<R>>(numbers: &[R], [tail, head]: [usize; 2], n: usize) -> L {
    part::<R, L>(numbers, head, n) - part::<R, L>(numbers, tail, n)
}

impl Entry {
    /// The derivative of `w' A x` with respect to this entry, from the components of `w` and `x` at its row and column. An
    /// entry beside the diagonal of a block also stands for its image above the diagonal.
    #[inline(always)]
    fn product<R: Real>(&self, w: [R; 2], x: [R; 2]) -> R {
        if self.row == self.column {
            w[0] * x[0]
        } else {
            w[0] * x[1] + w[1] * x[0]
        }
    }
}

impl<R: Real> LaneOperation<R> for Solve<R> {
    fn outputs(&self) -> Vec<Array> {
        self.outputs.clone()
    }
    fn set_active(&mut self, arrays: &[bool]) -> bool {
        for entry in &mut self.entries {
            entry.is_active = [arrays[entry.nodes.id], arrays[entry.edges.id]];
        }
        self.is_active = self.b.iter().map(|b| arrays[b.id]).collect();
        true
    }
    // For a single start the number of starts is a constant, so the loops over starts disappear. Scalars have a single start.
    #[inline(always)]
    fn forward_in<L: Lane<R>>(&mut self, parameters: &[R], row: &mut [R]) {
        if const { L::N == 1 } || self.starts == 1 {
            self.forward_of::<L, R>(1, parameters, row);
        } else {
            self.forward_of::<L, L>(self.starts, parameters, row);
        }
    }
    #[inline(always)]
    fn reverse_in<L: Lane<R>>(&mut self, values: StepValues<R>, bars: &mut Bars<R>) {
        if const { L::N == 1 } || self.starts == 1 {
            self.reverse_of::<L, R>(1, values, bars);
        } else {
            self.reverse_of::<L, L>(self.starts, values, bars);
        }
    }
}

/// The solution in a band. It enters lanes by itself, so that the sweeps forward and in reverse share its long code.
struct InBand<'a, R>(&'a mut Solve<R>);

impl<R: Real> Vectorized<R> for InBand<'_, R> {
    const USE_THE_ATTRIBUTE_KERNEL: () = ();
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        let Solve {
            matrix,
            recent,
            side,
            band,
            starts,
            ..
        } = self.0;
        if const { L::N == 1 } || *starts == 1 {
            band.solve::<R, L, R>(1, matrix, recent, side);
        } else {
            band.solve::<R, L, L>(*starts, matrix, recent, side);
        }
    }
}
