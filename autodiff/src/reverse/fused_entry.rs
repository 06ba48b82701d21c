//! A whole function as one entry.

use smallvec::SmallVec;

use super::index::NONE;
use crate::real::{Fused, Real};

/// One call of a [`Fused`] function, as the tape keeps it.
pub(super) struct FusedEntry<R> {
    pub(super) call: Box<dyn Call<R>>,
    pub(super) outputs: usize,
    /// Per input slice: its length, and whether any of it is a variable. Functions take few slices,
    /// so these need no allocation.
    pub(super) lengths: SmallVec<[usize; 4]>,
    pub(super) wanted: SmallVec<[bool; 4]>,
    /// The indices of all inputs, one slice after the other.
    pub(super) parents: Vec<u32>,
}

/// A [`Fused`] function and the numbers it saved, with the types erased.
pub(super) trait Call<R>: Send {
    fn reverse(&mut self, y_bar: &[R], wanted: &[bool]) -> Vec<Vec<R>>;
}

pub(super) struct SavedCall<F: Fused, R: Real> {
    pub(super) function: F,
    pub(super) saved: F::Saved<R>,
}

impl<F: Fused, R: Real> Call<R> for SavedCall<F, R> {
    fn reverse(&mut self, y_bar: &[R], wanted: &[bool]) -> Vec<Vec<R>> {
        self.function.reverse(&mut self.saved, y_bar, wanted)
    }
}

impl<R: Real> FusedEntry<R> {
    /// Pulls the cotangents of the outputs, which begin at place `first`, back to the inputs.
    pub(super) fn reverse(&mut self, first: usize, bars: &mut [R]) {
        let y_bar = &bars[first..first + self.outputs];
        if y_bar.iter().all(R::is_zero) {
            return;
        }
        let x_bar = self.call.reverse(y_bar, &self.wanted);
        assert_eq!(
            x_bar.len(),
            self.lengths.len(),
            "Fused::reverse must return one vector per input slice"
        );
        let mut parents = self.parents.as_slice();
        for (slice, x_bar) in x_bar.iter().enumerate() {
            let (here, rest) = parents.split_at(self.lengths[slice]);
            parents = rest;
            if !self.wanted[slice] {
                continue;
            }
            assert_eq!(
                x_bar.len(),
                here.len(),
                "Fused::reverse must return one cotangent per input of a wanted slice"
            );
            for (&parent, &x_bar) in here.iter().zip(x_bar) {
                if parent != NONE {
                    bars[parent as usize] += x_bar;
                }
            }
        }
    }
}
