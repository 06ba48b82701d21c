//! Whole functions as one entry: [`Fused`] on the tape.

use smallvec::SmallVec;

use super::current::{self, CONSTANT};
use super::tape::NONE;
use super::var::Var;
use crate::fused::Fused;
use crate::real::Real;

/// One call of a [`Fused`] function, as the tape keeps it.
pub(super) struct FusedEntry<R> {
    call: Box<dyn Call<R>>,
    pub(super) outputs: usize,
    /// Per input slice: its length, and whether any of it is a variable. Functions take few slices,
    /// so these need no allocation.
    lengths: SmallVec<[usize; 4]>,
    wanted: SmallVec<[bool; 4]>,
    /// The indices of all inputs, one slice after the other.
    parents: Vec<u32>,
}

/// A [`Fused`] function and what it saved, with the types erased.
trait Call<R>: Send {
    fn reverse(&mut self, y_bar: &[R], wanted: &[bool]) -> Vec<Vec<R>>;
}

struct Saved<F: Fused, R: Real> {
    function: F,
    saved: F::Saved<R>,
}

impl<F: Fused, R: Real> Call<R> for Saved<F, R> {
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

/// [`Real::fused`] of the reverse variable.
pub(super) fn fused<R: Real, F: Fused>(function: F, inputs: &[&[Var<R>]]) -> Vec<Var<R>> {
    let values = |slice: &&[Var<R>]| slice.iter().map(|x| x.value).collect();
    let values: SmallVec<[Vec<R>; 4]> = inputs.iter().map(values).collect();
    let values: SmallVec<[&[R]; 4]> = values.iter().map(Vec::as_slice).collect();
    let generation = inputs.iter().copied().flatten().fold(CONSTANT, Var::common);
    if generation == CONSTANT {
        // Not `eval`: what is constant here may carry a derivative of its own.
        let outputs = R::fused(function, &values);
        return outputs.into_iter().map(Var::constant).collect();
    }
    let (outputs, saved) = function.record(&values);
    if outputs.is_empty() {
        return Vec::new();
    }
    let entry = FusedEntry {
        call: Box::new(Saved { function, saved }),
        outputs: outputs.len(),
        lengths: inputs.iter().map(|slice| slice.len()).collect(),
        wanted: inputs
            .iter()
            .map(|slice| slice.iter().any(|x| !x.is_constant()))
            .collect(),
        parents: inputs.iter().copied().flatten().map(|x| x.index).collect(),
    };
    let zero = R::zero();
    // SAFETY: `push_fused` moves what is ready; it runs no foreign code.
    #[allow(unsafe_code)]
    let first = unsafe { current::with(generation, |arena| arena.push_fused(entry, zero)) };
    let variable = |(i, value)| Var {
        value,
        index: first + i,
        generation,
    };
    (0..).zip(outputs).map(variable).collect()
}

/// The inner values of a slice; up to eight need no allocation.
pub(super) fn values<R: Real>(slice: &[Var<R>]) -> SmallVec<[R; 8]> {
    slice.iter().map(|x| x.value).collect()
}
