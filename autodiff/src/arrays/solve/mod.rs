//! The solution of a system of linear equations whose matrix has the structure of a graph.

mod band;
mod order;

use self::band::Band;
use super::array::Array;
use super::graph::{Graph, SlotEdge};
use super::operation::LaneOperation;
use super::row::{Bars, StepValues};
use crate::real::Real;
use crate::simd::Lane;

/// The rows and columns of the lower triangle of a block with `n` rows: `[0, 0], [1, 0], [1, 1], [2, 0], ...`.
pub(crate) fn triangle(n: usize) -> Vec<[usize; 2]> {
    let rows = 0..n;
    rows.flat_map(|row| (0..=row).map(move |column| [row, column]))
        .collect()
}

/// The largest number of unknowns per node if some directions are held.
pub(crate) const MOST_UNKNOWNS: usize = 4;

/// Implements [`Program::solve`](crate::Program::solve).
pub(crate) struct Solve<R> {
    entries: Vec<Entry>,
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
    matrix: Vec<R>,
    /// The right-hand side and then the solution, in the order of elimination.
    side: Vec<R>,
}

/// An entry in the lower triangle of all blocks.
struct Entry {
    row: usize,
    column: usize,
    nodes: Array,
    edges: Array,
    /// For each node, the index of its number in the matrix.
    of_nodes: Vec<usize>,
    of_edges: Vec<EdgeEntry>,
    /// Whether the arrays of nodes and of edges carry derivatives.
    is_active: [bool; 2],
}

/// Where an entry of an edge's block is in the matrix.
struct EdgeEntry {
    edge: SlotEdge,
    /// In the blocks of both ends.
    own: [usize; 2],
    /// Between the ends: of the entry and of its image above the diagonal. They are equal in the diagonal of a block.
    between: [usize; 2],
}

impl<R: Real> Solve<R> {
    /// Creates the operation from the arrays of the nodes, of the edges, of the right-hand side and of the held
    /// directions, and its outputs. `starts` rollouts run together.
    pub(crate) fn new(
        graph: &Graph,
        [nodes, edges, b, held]: [&[Array]; 4],
        outputs: &[Array],
        starts: usize,
    ) -> Self {
        let slots = graph.edges_by_slot();
        let ends: Vec<[usize; 2]> = slots.iter().map(|edge| [edge.tail, edge.head]).collect();
        let (places, unknowns) = (order::places(graph.nodes(), &ends), outputs.len());
        let below = (order::bandwidth(&places, &ends) + 1) * unknowns - 1;
        let band = Band::new(graph.nodes() * unknowns, below, starts);
        let places: Vec<usize> = places.iter().map(|place| place * unknowns).collect();
        let arrays = nodes.iter().zip(edges);
        let entry = |([row, column], (&nodes, &edges)): ([usize; 2], (&Array, &Array))| {
            let own = |place: &usize| band.index(place + row, place + column);
            let of_edge = |edge: &SlotEdge| {
                let [a, b] = [edge.tail, edge.head].map(|node| places[node]);
                let (first, last) = (a.min(b), a.max(b));
                EdgeEntry {
                    edge: *edge,
                    own: [a, b].map(|place| own(&place)),
                    between: [[row, column], [column, row]]
                        .map(|[row, column]| band.index(last + row, first + column)),
                }
            };
            Entry {
                row,
                column,
                nodes,
                edges,
                of_nodes: places.iter().map(own).collect(),
                of_edges: slots.iter().map(of_edge).collect(),
                is_active: [true; 2],
            }
        };
        Self {
            entries: triangle(unknowns)
                .into_iter()
                .zip(arrays)
                .map(entry)
                .collect(),
            held: held.to_vec(),
            holds: vec![false; graph.nodes()],
            is_oblique: vec![false; graph.nodes()],
            free: vec![R::zero(); graph.nodes() * starts * unknowns * unknowns],
            b: b.to_vec(),
            is_active: vec![true; b.len()],
            outputs: outputs.to_vec(),
            matrix: vec![R::zero(); band.len() * starts],
            side: vec![R::zero(); band.len_of_side() * starts],
            places,
            starts,
            band,
        }
    }

    /// Computes the factor of the matrix.
    #[inline(always)]
    fn factorize<L: Lane<R>>(&mut self, starts: usize, values: StepValues<R>) {
        let matrix = &mut self.matrix[..];
        matrix.fill(R::zero());
        for entry in &self.entries {
            let given = values.get(entry.nodes);
            for node in 0..entry.of_nodes.len() {
                for s in 0..starts {
                    matrix[entry.of_nodes[node] * starts + s] += given[node * starts + s];
                }
            }
            let given = values.get(entry.edges);
            for EdgeEntry { edge, own, between } in &entry.of_edges {
                for s in 0..starts {
                    let number = given[edge.slot * starts + s];
                    matrix[own[0] * starts + s] += number;
                    matrix[own[1] * starts + s] += number;
                    matrix[between[0] * starts + s] -= number;
                    if between[0] != between[1] {
                        matrix[between[1] * starts + s] -= number;
                    }
                }
            }
        }
        self.hold_matrix(starts, values);
        self.band.factorize::<R, L>(starts, &mut self.matrix);
    }

    /// Removes the held directions from the matrix `A`: replaces it by `G A G + F`, where `F` projects onto the held
    /// directions and `G = I - F`. Only blocks of nodes with held directions change.
    #[inline(always)]
    fn hold_matrix(&mut self, starts: usize, values: StepValues<R>) {
        if self.held.is_empty() {
            return;
        }
        for node in 0..self.places.len() {
            self.holds[node] = false;
            for &held in &self.held {
                for s in 0..starts {
                    self.holds[node] |= !values.get(held)[node * starts + s].is_zero();
                }
            }
            self.is_oblique[node] = self.holds[node] && !self.hold_unknowns(starts, values, node);
            if self.holds[node] {
                self.set_free(starts, values, node);
            }
            if self.is_oblique[node] {
                for s in 0..starts {
                    self.hold_block(starts, [node, node], s);
                }
            }
        }
        for k in 0..self.entries[0].of_edges.len() {
            let SlotEdge {
                tail: a, head: b, ..
            } = self.entries[0].of_edges[k].edge;
            if self.is_oblique[a] || self.is_oblique[b] {
                let is_before = self.places[a] < self.places[b];
                let ends = if is_before { [b, a] } else { [a, b] };
                for s in 0..starts {
                    self.hold_block(starts, ends, s);
                }
            }
        }
    }

    /// Removes the held directions of a node from the matrix if each is along an axis: the row and the column of such an
    /// unknown become those of the unit matrix. Returns false if another direction is held.
    #[inline(always)]
    fn hold_unknowns(&mut self, starts: usize, values: StepValues<R>, node: usize) -> bool {
        for entry in 0..self.held.len() {
            let Entry { row, column, .. } = self.entries[entry];
            for s in 0..starts {
                let held = values.get(self.held[entry])[node * starts + s];
                if !(held.is_zero() || row == column && (held - R::one()).is_zero()) {
                    return false;
                }
            }
        }
        for entry in 0..self.held.len() {
            let Entry { row, column, .. } = self.entries[entry];
            for s in 0..starts {
                if row == column && !values.get(self.held[entry])[node * starts + s].is_zero() {
                    let unknown = self.places[node] + row;
                    self.band.set_unit(starts, &mut self.matrix, unknown, s);
                }
            }
        }
        true
    }

    /// Computes the projection `G` of a node onto its free directions.
    #[inline(always)]
    fn set_free(&mut self, starts: usize, values: StepValues<R>, node: usize) {
        let n = self.outputs.len();
        let mut entry = 0;
        for row in 0..n {
            for column in 0..=row {
                for s in 0..starts {
                    let at = node * starts + s;
                    let held = values.get(self.held[entry])[at];
                    let unit = if row == column { R::one() } else { R::zero() };
                    self.free[at * n * n + row * n + column] = unit - held;
                    self.free[at * n * n + column * n + row] = unit - held;
                }
                entry += 1;
            }
        }
    }

    /// Removes the held directions from the block with the rows of one node and the columns of another, or of the same
    /// node. The second node is not after the first in the order of elimination.
    #[inline(always)]
    fn hold_block(&mut self, starts: usize, [below, before]: [usize; 2], s: usize) {
        let n = self.outputs.len();
        let [of_below, of_before] =
            [below, before].map(|node| &self.free[(node * starts + s) * n * n..][..n * n]);
        let mut block = [R::zero(); MOST_UNKNOWNS * MOST_UNKNOWNS];
        for row in 0..n {
            for column in 0..n {
                let [a, b] = [self.places[below] + row, self.places[before] + column];
                let at = self.band.index(a.max(b), a.min(b));
                block[row * n + column] = self.matrix[at * starts + s];
            }
        }
        if self.is_oblique[below] {
            block = product(n, of_below, &block);
        }
        if self.is_oblique[before] {
            block = product(n, &block, of_before);
        }
        for row in 0..n {
            for column in 0..n {
                let [a, b] = [self.places[below] + row, self.places[before] + column];
                let mut entry = block[row * n + column];
                if below == before {
                    let unit = if row == column { R::one() } else { R::zero() };
                    entry += unit - of_below[row * n + column];
                }
                let at = self.band.index(a.max(b), a.min(b));
                self.matrix[at * starts + s] = entry;
            }
        }
    }

    /// Removes the held directions from the vector in `side`.
    #[inline(always)]
    fn hold_side(&mut self, starts: usize) {
        let n = self.outputs.len();
        for node in 0..self.places.len() {
            if !self.holds[node] {
                continue;
            }
            for s in 0..starts {
                let free = &self.free[(node * starts + s) * n * n..][..n * n];
                let mut sums = [R::zero(); MOST_UNKNOWNS];
                for row in 0..n {
                    for k in 0..n {
                        let at = (self.places[node] + k) * starts + s;
                        sums[row] += free[row * n + k] * self.side[at];
                    }
                }
                for row in 0..n {
                    self.side[(self.places[node] + row) * starts + s] = sums[row];
                }
            }
        }
    }

    /// Copies one unknown of all nodes of the right-hand side.
    #[inline(always)]
    fn set_side(&mut self, starts: usize, unknown: usize, b: &[R]) {
        for node in 0..self.places.len() {
            for s in 0..starts {
                self.side[(self.places[node] + unknown) * starts + s] = b[node * starts + s];
            }
        }
    }

    /// Replaces the right-hand side by the solution.
    #[inline(always)]
    fn solve<L: Lane<R>>(&mut self, starts: usize) {
        self.band
            .solve::<R, L>(starts, &self.matrix, &mut self.side);
    }

    /// The solution for one unknown of a node, for the start `s`.
    #[inline(always)]
    fn solved(&self, starts: usize, unknown: usize, node: usize, s: usize) -> R {
        self.side[(self.places[node] + unknown) * starts + s]
    }

    /// Implements [`LaneOperation::forward_in`].
    #[inline(always)]
    fn forward_of<L: Lane<R>>(&mut self, starts: usize, parameters: &[R], row: &mut [R]) {
        let begin = self.outputs[0].start;
        let (row, after) = row.split_at_mut(begin);
        let values = StepValues { parameters, row };
        self.factorize::<L>(starts, values);
        for unknown in 0..self.b.len() {
            self.set_side(starts, unknown, values.get(self.b[unknown]));
        }
        self.hold_side(starts);
        self.solve::<L>(starts);
        for unknown in 0..self.outputs.len() {
            let output = self.outputs[unknown];
            let x = &mut after[output.start - begin..][..output.len];
            for node in 0..self.places.len() {
                for s in 0..starts {
                    x[node * starts + s] = self.solved(starts, unknown, node, s);
                }
            }
        }
    }

    /// Implements [`LaneOperation::reverse_in`]. The reverse of `A x = b` is one more solution with the same factor: with
    /// `A w = x_bar`, the cotangent of `b` is `w`, and that of `A` is `-w x'`. A block of an edge acts on the difference
    /// between its ends. Held directions are removed from `w`, as from `x`.
    #[inline(always)]
    fn reverse_of<L: Lane<R>>(&mut self, starts: usize, values: StepValues<R>, bars: &mut Bars<R>) {
        self.factorize::<L>(starts, values);
        for unknown in 0..self.outputs.len() {
            self.set_side(starts, unknown, &bars.row[self.outputs[unknown].range()]);
        }
        self.solve::<L>(starts);
        self.hold_side(starts);
        for unknown in 0..self.b.len() {
            if self.is_active[unknown] {
                let bar = bars.get_mut(self.b[unknown]);
                for node in 0..self.places.len() {
                    for s in 0..starts {
                        bar[node * starts + s] += self.solved(starts, unknown, node, s);
                    }
                }
            }
        }
        for entry in &self.entries {
            let [a, b] = [entry.row, entry.column];
            let (x_a, x_b) = (values.get(self.outputs[a]), values.get(self.outputs[b]));
            if entry.is_active[0] {
                let bar = bars.get_mut(entry.nodes);
                for node in 0..self.places.len() {
                    for s in 0..starts {
                        let at = node * starts + s;
                        let w_a = self.solved(starts, a, node, s);
                        let w_b = self.solved(starts, b, node, s);
                        bar[at] -= entry.product([w_a, w_b], [x_a[at], x_b[at]]);
                    }
                }
            }
            if entry.is_active[1] {
                let bar = bars.get_mut(entry.edges);
                for EdgeEntry { edge, .. } in &entry.of_edges {
                    for s in 0..starts {
                        let (tail, head) = (edge.tail * starts + s, edge.head * starts + s);
                        let w = |unknown: usize| {
                            self.solved(starts, unknown, edge.head, s)
                                - self.solved(starts, unknown, edge.tail, s)
                        };
                        let x = [x_a[head] - x_a[tail], x_b[head] - x_b[tail]];
                        bar[edge.slot * starts + s] -= entry.product([w(a), w(b)], x);
                    }
                }
            }
        }
    }
}

/// The product of two matrices with `n` rows and columns.
#[inline(always)]
fn product<R: Real>(n: usize, a: &[R], b: &[R]) -> [R; MOST_UNKNOWNS * MOST_UNKNOWNS] {
    let mut product = [R::zero(); MOST_UNKNOWNS * MOST_UNKNOWNS];
    for row in 0..n {
        for column in 0..n {
            for k in 0..n {
                product[row * n + column] += a[row * n + k] * b[k * n + column];
            }
        }
    }
    product
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
    fn set_active(&mut self, arrays: &[bool]) {
        for entry in &mut self.entries {
            entry.is_active = [arrays[entry.nodes.id], arrays[entry.edges.id]];
        }
        self.is_active = self.b.iter().map(|b| arrays[b.id]).collect();
    }
    // For a single start the number of starts is a constant, so the loops over starts disappear.
    #[inline(always)]
    fn forward_in<L: Lane<R>>(&mut self, parameters: &[R], row: &mut [R]) {
        match self.starts {
            1 => self.forward_of::<L>(1, parameters, row),
            starts => self.forward_of::<L>(starts, parameters, row),
        }
    }
    #[inline(always)]
    fn reverse_in<L: Lane<R>>(&mut self, values: StepValues<R>, bars: &mut Bars<R>) {
        match self.starts {
            1 => self.reverse_of::<L>(1, values, bars),
            starts => self.reverse_of::<L>(starts, values, bars),
        }
    }
}
