//! Calls of fused functions.

use smallvec::SmallVec;

use super::index::NONE;
use crate::real::{Fused, Real};

/// A call of a [`Fused`] function that was recorded on the tape.
pub(super) struct FusedEntry<R> {
    pub(super) call: Box<dyn Call<R>>,
    /// The index of the first output. It is set when the entry is pushed.
    pub(super) first: u32,
    pub(super) outputs: usize,
    /// The length of each input slice (`lengths`), and whether it contains a variable (`wanted`). Functions take few
    /// slices, so these lists need no allocation.
    pub(super) lengths: SmallVec<[usize; 4]>,
    pub(super) wanted: SmallVec<[bool; 4]>,
    /// For each input slice, the entries of its inputs.
    pub(super) parents: SmallVec<[Parents; 4]>,
}

/// The entries of the inputs in a slice.
pub(super) enum Parents {
    /// Consecutive entries, beginning with this index, such as the inputs of a recording.
    Run(u32),
    Each(Vec<u32>),
}

impl Parents {
    pub(super) fn new(indices: impl Iterator<Item = u32> + Clone) -> Self {
        let first = indices.clone().next().unwrap_or(NONE);
        let mut places = indices.clone().zip(u64::from(first)..);
        if first != NONE && places.all(|(index, place)| u64::from(index) == place) {
            Self::Run(first)
        } else {
            Self::Each(indices.collect())
        }
    }

    /// Calls `visit` with the index of each input that is a variable. The slice has `len` inputs.
    pub(super) fn each(&self, len: usize, mut visit: impl FnMut(u32)) {
        match self {
            Self::Run(first) => (*first..*first + len as u32).for_each(visit),
            Self::Each(indices) => {
                let variables = indices.iter().filter(|&&index| index != NONE);
                variables.for_each(|&index| visit(index));
            }
        }
    }
}

/// A [`Fused`] function with the numbers that it saved for its reverse rule. This trait hides the types of both.
pub(super) trait Call<R>: Send {
    #[track_caller]
    fn reverse(&mut self, y_bar: &[R], wanted: &[bool]) -> Vec<Vec<R>>;
}

pub(super) struct SavedCall<F: Fused, R: Real> {
    pub(super) function: F,
    pub(super) saved: F::Saved<R>,
}

impl<F: Fused, R: Real> Call<R> for SavedCall<F, R> {
    #[track_caller]
    fn reverse(&mut self, y_bar: &[R], wanted: &[bool]) -> Vec<Vec<R>> {
        self.function.reverse(&mut self.saved, y_bar, wanted)
    }
}

impl<R: Real> FusedEntry<R> {
    /// Pulls the cotangents of the outputs back to the inputs. The outputs are the entries from `first` on.
    #[track_caller]
    pub(super) fn reverse(&mut self, first: usize, bars: &mut [R]) {
        let y_bar = &bars[first..first + self.outputs];
        if y_bar.iter().all(R::is_zero) {
            return;
        }
        let x_bar = self.call.reverse(y_bar, &self.wanted);
        assert_eq!(
            x_bar.len(),
            self.lengths.len(),
            "`Fused::reverse` must return one vector for each input slice"
        );
        for (slice, x_bar) in x_bar.iter().enumerate() {
            if !self.wanted[slice] {
                continue;
            }
            assert_eq!(
                x_bar.len(),
                self.lengths[slice],
                "`Fused::reverse` must return one cotangent for each input of a slice whose `wanted` is true"
            );
            match &self.parents[slice] {
                Parents::Run(first) => {
                    let bars = &mut bars[*first as usize..][..x_bar.len()];
                    for (bar, &x_bar) in bars.iter_mut().zip(x_bar) {
                        *bar += x_bar;
                    }
                }
                Parents::Each(indices) => {
                    let pairs = indices.iter().zip(x_bar);
                    for (&parent, &x_bar) in pairs.filter(|(parent, _)| **parent != NONE) {
                        bars[parent as usize] += x_bar;
                    }
                }
            }
        }
    }
}
