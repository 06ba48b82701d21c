//! Directions in which a solution is held: they are removed from the matrix and from the right-hand side.

use autodiff::Real;

use super::{Entry, MOST_UNKNOWNS, Solve};
use crate::arrays::graph::SlotEdge;
use crate::arrays::row::StepValues;

impl<R: Real> Solve<R> {
    /// Removes the held directions from the matrix `A`: replaces it by `G A G + F`, where `F` projects onto the held
    /// directions and `G = I - F`. Only blocks of nodes with held directions change.
    #[inline(always)]
    pub(super) fn hold_matrix(&mut self, starts: usize, values: StepValues<R>) {
        if self.held.is_empty() {
            return;
        }
        self.holds.fill(false);
        for &held in &self.held {
            let held = values.get(held);
            for node in 0..self.holds.len() {
                for s in 0..starts {
                    self.holds[node] |= !held[node * starts + s].is_zero();
                }
            }
        }
        let mut any_oblique = false;
        for node in 0..self.places.len() {
            self.is_oblique[node] = self.holds[node] && !self.hold_unknowns(starts, values, node);
            if self.holds[node] {
                self.set_free(starts, values, node);
            }
            if self.is_oblique[node] {
                any_oblique = true;
                for s in 0..starts {
                    self.hold_block(starts, [node, node], s);
                }
            }
        }
        if !any_oblique {
            return;
        }
        for k in 0..self.edges.len() {
            let SlotEdge {
                tail: a, head: b, ..
            } = self.edges[k];
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
                let at = self.band.index(a.min(b), a.max(b));
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
                let at = self.band.index(a.min(b), a.max(b));
                self.matrix[at * starts + s] = entry;
            }
        }
    }

    /// Removes the held directions from the vector in `side`.
    #[inline(always)]
    pub(super) fn hold_side(&mut self, starts: usize) {
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
