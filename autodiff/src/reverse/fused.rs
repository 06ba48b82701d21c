//! Whole functions as one entry: [`Fused`] functions on the tape.

use smallvec::SmallVec;

use super::current::{self, CONSTANT};
use super::fused_entry::{FusedEntry, Parents, SavedCall};
use super::var::Var;
use crate::real::{Fused, Real};

/// Implements [`Real::fused`] for variables.
pub(super) fn fused<R: Real, F: Fused>(function: F, inputs: &[&[Var<R>]]) -> Vec<Var<R>> {
    let values = |slice: &&[Var<R>]| slice.iter().map(|x| x.value).collect();
    let values: SmallVec<[Vec<R>; 4]> = inputs.iter().map(values).collect();
    let values: SmallVec<[&[R]; 4]> = values.iter().map(Vec::as_slice).collect();
    let generation = inputs.iter().copied().flatten().fold(CONSTANT, Var::common);
    if generation == CONSTANT {
        // Calling `eval` would be wrong, because constants of this tape may carry a derivative of an inner mode.
        let outputs = R::fused(function, &values);
        return outputs.into_iter().map(Var::constant).collect();
    }
    let (outputs, saved) = function.record(&values);
    if outputs.is_empty() {
        return Vec::new();
    }
    let entry = FusedEntry {
        call: Box::new(SavedCall { function, saved }),
        outputs: outputs.len(),
        lengths: inputs.iter().map(|slice| slice.len()).collect(),
        wanted: inputs
            .iter()
            .map(|slice| slice.iter().any(|x| !x.is_constant()))
            .collect(),
        parents: inputs
            .iter()
            .map(|slice| Parents::new(slice.iter().map(|x| x.index)))
            .collect(),
    };
    let zero = R::zero();
    // SAFETY: `push_fused` only moves a finished entry and runs no code from outside `reverse`.
    #[allow(unsafe_code)]
    let first = unsafe { current::with(generation, |arena| arena.push_fused(entry, zero)) };
    let variable = |(i, value)| Var {
        value,
        index: first + i,
        generation,
    };
    (0..).zip(outputs).map(variable).collect()
}

/// Returns the values of a slice of variables. A slice of up to eight variables needs no allocation.
pub(super) fn values<R: Real>(slice: &[Var<R>]) -> SmallVec<[R; 8]> {
    slice.iter().map(|x| x.value).collect()
}
